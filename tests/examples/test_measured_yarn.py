"""The example of a yarn by measurement: what its knit does, and that forces scale with the stiffnesses given."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import load
from app.schemas.machine_data import machines_of
from app.views.compare import compared
from knitlab_core.errors import SpecificationError
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Ramp, Target
from rigs.record import Equilibrium

if TYPE_CHECKING:
    from knitlab_core.materials import MeasuredYarn

EXAMPLE = Path(__file__).parents[2] / "examples" / "yarn_small.yaml"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> RunReader:
    result = run_protocol(EXAMPLE, tmp_path_factory.mktemp("yarn") / "run", lambda _share, _text: None, draw=None)
    assert (result.outcome, result.message) == ("target", "")
    return RunReader(result.folder / "run.h5")


def test_the_knit_stiffens_as_its_loops_press_on_each_other_and_rubs(small: RunReader) -> None:
    columns = small.trace.columns
    top = int(np.argmax(columns["displacement_C"]))
    strain = columns["displacement_C"][: top + 1] / small.size.extents["C"]
    assert strain[-1] == pytest.approx(0.3)
    course, wale = (np.interp([0.1, 0.2, 0.3], strain, columns[f"force_{axis}"][: top + 1]) for axis in ("C", "W"))
    for force in (course, wale):
        assert force[2] > 3.0 * force[1] > 9.0 * force[0] > 0.0
    assert (wale > 2.0 * course).all()
    assert columns["friction_work"][-1] > 0.0
    assert energy_balance_error(small.trace) < 0.01
    # Bending opens the loops: what the yarn is stretched by, the mean strain of its fibres, is next to nothing.
    assert columns["fibre_strain"].max() < 1e-3


def test_the_record_says_where_every_number_comes_from(small: RunReader) -> None:
    facts = small.provenance
    assert facts["material.bending"] == pytest.approx(4.5e-8)
    assert facts["material.bending.source"] == "N*m**2; the protocol"
    assert "least squares of relative deviations over 5 rows" in str(facts["material.rigidity.source"])
    assert "by measurement: EI 0.045 N mm²" in str(facts["yarn"])
    assert not any(name.startswith("material.young_modulus") for name in facts)


def test_its_stress_is_not_divided_by_a_modulus_that_it_does_not_have(small: RunReader) -> None:
    assert len(compared([small], by_modulus=False)) == 2
    with pytest.raises(
        SpecificationError, match="yarn_small, whose yarn is one by measurement and has no Young's modulus"
    ):
        compared([small], by_modulus=True)


def pulled(yarn: MeasuredYarn, *, periodic: bool = False) -> float:
    """Return the force along the wale at 20 % [N]."""
    protocol = load(EXAMPLE).protocol
    ramp = Ramp(axes=("C", "W"), to=Target(kind="strain", value=0.2), rate=2e-4)
    spec = replace(protocol.specimen, material=yarn, periodic=periodic)
    protocol = replace(protocol, specimen=spec, steps=(ramp,), max_strain_increment=0.05)
    rig, state = mount(make_specimen(spec), protocol, machines_of(protocol))
    rows = [event for event in perform(rig, state, protocol) if isinstance(event, Equilibrium)]
    return rows[-1].force["W"]


def test_forces_scale_with_the_stiffnesses_and_a_softer_surface_gives_way() -> None:
    yarn = load(EXAMPLE).protocol.specimen.measured
    assert yarn is not None

    def times(factor: float, *names: str) -> MeasuredYarn:
        changed: dict[str, Any] = {}
        for name, value in yarn.numbers():
            if name in names:
                changed[name] = replace(value, value=factor * value.value)
        return replace(yarn, **changed)

    force = pulled(yarn)
    stiffer = times(2.0, "bending", "axial", "twisting", "rigidity")
    assert pulled(stiffer) == pytest.approx(2.0 * force, rel=1e-6)
    assert pulled(times(0.1, "rigidity")) < 0.95 * force
    cell = pulled(yarn, periodic=True)
    assert 0.0 < cell < force
    assert pulled(stiffer, periodic=True) == pytest.approx(2.0 * cell, rel=1e-6)
