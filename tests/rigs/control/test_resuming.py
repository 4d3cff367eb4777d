"""A test that goes on from a checkpoint, through its file and on a rig that is made again, ends as it would have."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
import pytest

from app.records.checkpoint import Origin, Saved, read_checkpoint, save
from app.schemas.machine_data import machines_of
from knitlab_core.knits import Stitch
from knitlab_core.materials import RelaxationTerm, Value, material_named
from rigs.control.checkpoint import Checkpoint, restore
from rigs.control.experiment import perform
from rigs.instruments.zeros import Zeroing
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Cycle, Hold, LogSpec, Preload, Protocol, Ramp, SpecimenSpec, Target, Zero
from rigs.record import Equilibrium, Frame
from tests.measured_yarns import measured_yarn

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rigs.axes import Axis
    from rigs.control.experiment import Event
    from rigs.protocol.catalogue import Grips, RigName
    from rigs.protocol.step import Step

SPEED: Final = 2e-4
ORIGIN: Final = Origin(name="x", protocol="", materials="", facts={"seed": 1})

STEPS: Final[tuple[Step, ...]] = (
    Zero(),
    Preload(axes=("C", "W"), force=0.05, rate=SPEED, tag="pre"),
    Zero(channels=("displacement",), gauge_length="here"),
    Hold(duration=30.0),
    Cycle(axes=("C",), lower=0.0, upper=0.06, rate=SPEED, n=2),
)


class Case(NamedTuple):
    """A specimen, what is done to it, and on which rig."""

    specimen: SpecimenSpec
    steps: tuple[Step, ...]
    rig: RigName = "biaxial-hook"
    mount: Axis | None = None
    grips: Grips = "hooks"


def knit(**more: object) -> SpecimenSpec:
    spec = SpecimenSpec(
        knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM", nodes_per_loop=16
    )
    return replace(spec, **more)  # type: ignore[arg-type]


def ramp(strain: float) -> Ramp:
    return Ramp(axes=("C", "W"), to=Target(kind="strain", value=strain), rate=SPEED)


def guess(value: float, unit: str) -> Value:
    return Value(value=value, unit=unit, source="made up", assumed=True)


RESIN: Final = material_named("RGD8530-DM")
CREEPING: Final = replace(RESIN, relaxation=(RelaxationTerm(share=guess(0.3, "1"), time=guess(5.0, "s")),))
BRITTLE: Final = replace(RESIN, elongation_at_break=guess(0.05, "1"))

CELL: Final = {"knit": "volumetric-default", "rows": 1, "loops": 1, "layers": 2, "periodic": True, "shear": "free"}

CASES: Final = {
    "elastic": Case(knit(), STEPS),
    "relaxing": Case(knit(viscoelastic=True, material=CREEPING), (*STEPS[:2], Hold(duration=20.0), ramp(0.1))),
    "yielding": Case(knit(yields=True, nodes_per_loop=12), (ramp(0.22), ramp(0.18))),
    "breaking": Case(knit(rupture="go on", material=BRITTLE), (ramp(0.28), ramp(0.34))),
    "volumetric cell": Case(knit(**CELL), (ramp(0.06),)),
    "sheared cell": Case(
        knit(rows=1, loops=1, periodic=True),
        (ramp(0.04), Zero(gauge_length="here"), Cycle(axes=("WC",), lower=-0.02, upper=0.03, rate=SPEED, n=1)),
        "biaxial-shear",
    ),
    "straight": Case(knit(material="cotton-2-ply", rest_shape="straight", nodes_per_loop=24), (ramp(0.05),)),
}


#: Of acrylic yarn that relaxes into its loops: a cell under shear, and a specimen whose loops are those of such a cell.
FABRIC: Final = {
    "knit": Stitch(curvature=1.5, height=0.55, depth=0.3, row_spacing=0.69, fibre_radius=0.05),
    "loop_width": 2.62e-3,
    "material": measured_yarn(),
    "rest_shape": "straight",
}
SHEAR: Final = Cycle(axes=("WC",), lower=-0.04, upper=0.06, rate=SPEED, n=1)
PULL: Final = Ramp(axes=("W",), to=Target(kind="strain", value=0.04), rate=SPEED)
LONG: Final = {
    "real fabric": Case(knit(**FABRIC, rows=1, loops=1, periodic=True), (SHEAR,), "shear-frame", "WC"),
    "relaxed loops": Case(knit(**FABRIC, rows=4, loops=4, relaxed=True), (PULL,), "uniaxial-frame", "W", "clamps"),
}


def protocol_of(case: Case) -> Protocol:
    return Protocol(
        rig=case.rig,
        mount=case.mount,
        grips=case.grips,
        specimen=case.specimen,
        speed_ref="pair",
        others="hold" if case.mount is None else "free",
        steps=case.steps,
        log=LogSpec(noise=False),
        max_strain_increment=0.02,
    )


def same(one: object, two: object) -> bool:
    """Tell whether two events are alike to the last bit, wall time apart."""
    if isinstance(one, Equilibrium) and isinstance(two, Equilibrium):
        return replace(one, seconds=0.0) == replace(two, seconds=0.0)
    if isinstance(one, Frame) and isinstance(two, Frame):
        parts = [(getattr(one, field.name), getattr(two, field.name)) for field in fields(Frame)]
        return all(np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b for a, b in parts)
    return one == two


def filed(checkpoint: Checkpoint, path: Path) -> Checkpoint:
    save(path, Saved(origin=ORIGIN, checkpoint=checkpoint, lengths={}, zeroings=(), seconds=1.0))
    return read_checkpoint(path).checkpoint


def without_checkpoints(events: Sequence[Event]) -> list[Event]:
    return [event for event in events if not isinstance(event, Checkpoint)]


@pytest.mark.parametrize("name", [*CASES, *(pytest.param(name, marks=pytest.mark.slow) for name in LONG)])
def test_a_test_goes_on_to_the_same_events_from_wherever_it_stood(name: str, tmp_path: Path) -> None:
    protocol = protocol_of({**CASES, **LONG}[name])
    specimen, machines = make_specimen(protocol.specimen), machines_of(protocol)
    events = list(perform(*mount(specimen, protocol, machines), protocol))
    places = [k for k, event in enumerate(events) if isinstance(event, Checkpoint)]
    assert len(places) >= len(protocol.steps)
    for number, place in enumerate(places):
        checkpoint = events[place]
        assert isinstance(checkpoint, Checkpoint)
        kept = filed(checkpoint, tmp_path / "checkpoint.h5")
        laid, _ = mount(specimen, protocol, machines, relaxed=False)
        again = perform(restore(laid, kept), kept.state, protocol, cursor=kept.cursor)
        # To the end from the first and two others, a few events far from the rest.
        whole = number in {0, len(places) // 2, len(places) - 4}
        rest = list(again if whole else islice(again, 4))
        expected = without_checkpoints(events[place + 1 :])
        for one, two in zip(without_checkpoints(rest), expected, strict=False):
            assert same(one, two), (number, one, two)
        if whole:
            assert len(without_checkpoints(rest)) == len(expected)


def test_the_cases_do_what_they_are_for() -> None:
    protocol = protocol_of(CASES["breaking"])
    events = list(perform(*mount(make_specimen(protocol.specimen), protocol, machines_of(protocol)), protocol))
    severed = {event.severed for event in events if isinstance(event, Checkpoint)}
    assert len(severed) > 1
    zeroings = [event for event in events if isinstance(event, Zeroing)]
    assert not zeroings
