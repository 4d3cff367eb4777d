from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from app.export import export_logs
from app.rig_data import machines_of
from app.run_layout import make_record
from app.run_reader import RunReader
from app.runs import RunWriter
from knitlab_core.errors import SpecificationError
from rigs.catalogue import CATALOGUE, Arrangement
from rigs.experiment import perform
from rigs.instruments import measure
from rigs.protocol import Protocol, Ramp, SpecimenSpec, Target
from rigs.record import Equilibrium, Outcome, trace_of
from rigs.rig import mount
from rigs.specimen import make_specimen

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.steps import Axis

# The stage carried on the frame: two machines on one specimen.
JOINED = Arrangement(
    drives={**CATALOGUE["biaxial-hook"].drives, "P": CATALOGUE["uniaxial-frame"].drives["P"]},
    mounts_one=False,
    sides="hold",
)


@pytest.fixture
def joined(monkeypatch: pytest.MonkeyPatch) -> None:
    rigs: dict[str, Arrangement] = {str(name): rig for name, rig in CATALOGUE.items()}
    rigs["joined"] = JOINED
    for module in ("catalogue", "protocol", "motion"):
        monkeypatch.setattr(f"rigs.{module}.CATALOGUE", rigs)


def ramp(strain: float, *axes: Axis) -> Ramp:
    return Ramp(axes=axes, to=Target(kind="strain", value=strain), rate=2e-4)


def protocol(**knit: Any) -> Protocol:  # noqa: ANN401 (whatever a specimen is made of)
    spec = SpecimenSpec(rows=2, loops=1, loop_width=8e-3, material="RGD8530-DM", nodes_per_loop=24, **knit)
    return Protocol(
        rig="joined",  # type: ignore[arg-type]
        specimen=spec,
        speed_ref="grip",
        others="hold",
        steps=(ramp(0.02, "C", "W"), ramp(0.04, "P")),
        max_strain_increment=0.02,
    )


@pytest.mark.usefixtures("joined")
def test_a_rig_of_two_machines_is_data_alone(tmp_path: Path) -> None:
    test = protocol(knit="volumetric-default", layers=2)
    specimen = make_specimen(test.specimen)
    rig, state = mount(specimen, test, machines_of(test))
    *events, outcome = perform(rig, state, test)
    rows = [event for event in events if isinstance(event, Equilibrium)]
    assert outcome == Outcome(end="target")
    way = {axis: [row.displacement[axis] / rig.gauges[axis] for row in rows] for axis in rig.grips}
    assert (way["C"][-1], way["W"][-1], way["P"][-1]) == pytest.approx((0.02, 0.02, 0.04))
    assert all(pile == 0.0 or course == way["C"][-1] for course, pile in zip(way["C"], way["P"], strict=True))
    # Two grips move apart on the stage, one on the frame.
    gauges = rig.gauges
    times = [0.02 * max(gauges["C"], gauges["W"]) / 4e-4, 0.04 * gauges["P"] / 2e-4]
    assert rows[-1].time == pytest.approx(sum(times))
    assert {channel.name for channel in rig.instruments[1].channels} == {"Displacement", "Force"}
    with RunWriter(
        make_record(
            tmp_path / "run.h5",
            protocol="",
            size=rig.size,
            axes=test.axes,
            strands=[len(specimen.nodes)],
            instruments=rig.instruments,
            provenance={},
        )
    ) as writer:
        for row in rows:
            writer.append(row)
        for instrument in rig.instruments:
            writer.write_samples(measure(instrument, trace_of(rows), seed=1))
    run = RunReader(tmp_path / "run.h5")
    assert run.trace.axes == ("C", "W", "P")
    logs = export_logs(run, tmp_path, "s")
    assert [path.name for path in logs] == ["s.csv", "s_1.csv"]
    assert [len(path.read_bytes().split(b"\r\n")) for path in logs] == [
        len(run.samples["biaxial-hook"].time) + k for k in (2, 3)
    ]


@pytest.mark.usefixtures("joined")
def test_a_planar_knit_has_no_faces_to_pull_along_the_pile() -> None:
    with pytest.raises(SpecificationError, match=r"knit: found 'faces across C and W', allowed .* C and W and P"):
        protocol(knit="stockinette-default")
