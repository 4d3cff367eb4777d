"""Estimate what a protocol asks of the yarn, for every rig and kind of knit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.checks.budget import BAND, budget_of, fibre_line, fibre_strain
from app.checks.dry_run import Plan, dry_run
from app.schemas import loads
from knitlab_core.knits import NAMED_STITCHES, locking_strain, yarn_per_loop
from rigs.protocol.specimen import SpecimenSpec
from rigs.protocol.strokes import Stroke

if TYPE_CHECKING:
    from rigs.axes import Axis

DEFAULT = NAMED_STITCHES["stockinette-default"]
MATERIALS = """
materials:
  pla:
    young_modulus: {value: 2.6 GPa, source: a test}
    poisson_ratio: {value: 0.36, source: a test}
    strength: {value: 55 MPa, source: a test}
    elongation_at_break: {value: 4 %, source: a test}
"""


def plan(rig: str, knit: str, step: str, *, others: str = "free", more: str = "") -> Plan:
    return dry_run(
        loads(
            f"schema: knitlab/protocol@1\nrig: {rig}\n{MATERIALS}"
            f"specimen: {{knit: {knit}, loop: 8 mm, material: pla, friction: 0.3{more}}}\n"
            f"speed_ref: pair\nothers: {others}\nlog: {{rate: 1 Hz}}\nsteps:\n  - {step}\n"
        )
    )


def test_sides_that_are_held_spend_yarn_on_course_and_wale() -> None:
    found = plan(
        "biaxial-hook",
        "stockinette-default, loops: [3, 3]",
        "ramp: {axes: [C, W], to: {strain: 20 %}, rate: 1 mm/s}",
        others="hold",
    )
    assert found.budget is not None
    assert found.budget.largest == pytest.approx(0.2)
    assert found.budget.measure == "as equibiaxial strain"
    assert found.budget.locking == pytest.approx(locking_strain(DEFAULT, yarn_per_loop(DEFAULT)))


@pytest.mark.parametrize(
    ("rig", "axis", "others"),
    [
        ("uniaxial-frame\nmount: W", "W", "free"),
        ("biaxial-hook", "W", "free"),
        ("uniaxial-frame\nmount: C", "C", "free"),
    ],
)
def test_free_sides_give_yarn_until_strands_lie_side_by_side(rig: str, axis: Axis, others: str) -> None:
    step = f"ramp: {{axes: [{axis}], to: {{strain: 30 %}}, rate: 1 mm/s}}"
    found = plan(rig, "stockinette-default, loops: [3, 3]", step, others=others).budget
    assert found is not None
    assert found.largest == pytest.approx(0.3)
    assert found.measure == f"along {axis}, sides free"
    # All yarn that crossings leave, by hand: four strands of 0.1 loop widths stay across, once or twice.
    yarn = (1.0 + locking_strain(DEFAULT, yarn_per_loop(DEFAULT))) * (1.0 + 2 * 0.86)
    wanted = {"W": (yarn - 0.4) / (2 * 0.86) - 1.0, "C": yarn - 0.4 - 1.0}
    assert found.locking == pytest.approx(wanted[axis])


def test_a_volumetric_knit_has_a_budget_for_each_kind_of_loop() -> None:
    step = "ramp: {axes: [P], to: {strain: 60 %}, rate: 1 mm/s}"
    found = plan("uniaxial-frame\nmount: P", "volumetric-default, loops: [2, 2, 2]", step)
    assert found.budget is not None
    assert found.budget.measure == "along P, sides free"
    assert found.budget.locking == pytest.approx(0.449, abs=1e-3)
    assert found.warnings[0].startswith(
        "arc-length budget: the protocol goes to 60.0% along P, sides free, past the estimated locking strain of 44.9%"
    )


def test_what_would_pass_the_strength_is_foreseen() -> None:
    knit, step = "stockinette-default, loops: [2, 2]", "ramp: {{axes: [W], to: {{strain: {} %}}, rate: 2 mm/s}}"
    far, near, little = (plan("uniaxial-frame\nmount: W", knit, step.format(strain)) for strain in (60, 30, 5))
    assert [text.split(":")[1].strip() for text in far.warnings] == [
        "strength of 55 MPa would be passed",
        "elongation at break of 4 % would be passed",
    ]
    assert (near.warnings, little.warnings) == ([], [])
    said = [fibre_line(one.protocol.specimen, one.fibre_strain) for one in (near, little)]
    assert [line.count("which may be passed") for line in said] == [2, 0]
    assert said[1].endswith(
        "the material bears 2.12 % at its strength of 55 MPa; 4 % at its elongation at break of 4 %"
    )
    broken = plan("uniaxial-frame\nmount: W", knit, step.format(60), more=", rupture: stop")
    assert ["strength" in text for text in broken.warnings] == [True]


def test_a_filament_is_strained_as_its_ends_are() -> None:
    step = "ramp: {axes: [C], to: {strain: 3 %}, rate: 1 mm/s}"
    found = plan("uniaxial-frame\nmount: C", "{filament: 1 mm}, loops: [1, 1]", step)
    assert found.budget is None
    assert found.fibre_strain == pytest.approx(0.03)
    (warning,) = found.warnings
    assert warning == (
        "material: strength of 55 MPa would be passed: a fibre would be strained by 3 %, limit 2.12 %; "
        "from there on the elastic fibre carries more than the material does"
    )


@pytest.mark.parametrize(
    ("knit", "layers", "lengths", "end", "solved"),
    [
        # Largest strains of a fibre that the solver found (draft mesh; docs/decisions/0024).
        ("stockinette-default", 1, {"W": 1.0}, 0.6, 0.0779),
        ("stockinette-default", 1, {"W": 1.0}, 0.4, 0.0367),
        ("stockinette-default", 1, {"C": 1.0, "W": 1.0}, 0.4, 0.0761),
        ("stockinette-default", 1, {"C": 1.0}, 0.6, 0.0169),
        ("plain-knit", 1, {"C": 1.0, "W": 1.0}, 0.4, 0.3256),
        ("volumetric-default", 2, {"P": 1.0}, 0.4, 0.0731),
    ],
)
def test_the_estimate_is_within_its_band_of_what_was_solved(
    knit: str, layers: int, lengths: dict[Axis, float], end: float, solved: float
) -> None:
    spec = SpecimenSpec(knit=knit, rows=2, loops=2, layers=layers, loop_width=8e-3, material="RGD8530-DM")
    stroke = Stroke(
        start=dict.fromkeys(lengths, 0.0),
        end=dict.fromkeys(lengths, end),
        duration=1.0,
        phase="Stretch",
        cycle=1,
        named=tuple(lengths),
        force={},
    )
    found = fibre_strain(spec, budget_of(spec, [stroke], lengths), [stroke])
    assert found is not None
    assert solved / BAND < found < solved * BAND
