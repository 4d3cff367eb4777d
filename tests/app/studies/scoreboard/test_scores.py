"""Each score on records with a known answer: reproduced, and not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.studies.scoreboard import constants, designs, planar, volumetric
from app.studies.scoreboard.analysed import Analysed, UnscorableError
from app.studies.scoreboard.plan import PRE_STRAINS
from tests.app.studies.scoreboard import made
from tests.app.studies.scoreboard.made import cycles, exponential, line, record_of, tables_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.analysis.table import Cell
    from rigs.axes import FloatArray

XI = {"d": -3.0, "a": -2.0, "n": 2.0, "r": 4.0, "E": 2.0}
"""Exponents of stress that the paper's ξ stands for."""


def fig3a(course: made.Curve, wale: made.Curve, back: made.Curve | None = None, count: int = 1) -> dict[str, Analysed]:
    return {"fig3a": record_of("fig3a", [cycles("C", course, back, count), cycles("W", wale, back, count)])}


def test_the_papers_exponential_is_reproduced_and_a_slower_one_is_not() -> None:
    found = planar.exponential(fig3a(exponential(900.0, 16.5), exponential(1800.0, 16.5)))
    assert (found.verdict, found.why) == ("reproduced", "")
    assert found.values["beta C"] == pytest.approx(16.5)
    slow = planar.exponential(fig3a(exponential(900.0, 16.5), exponential(900.0, 10.0)))
    assert slow.verdict == "differs"
    assert "wale -39 %" in slow.why


def test_a_line_is_no_exponential() -> None:
    assert planar.exponential(fig3a(line(1e5), line(1e5))).verdict == "differs"


@pytest.mark.parametrize(("factor", "verdict"), [(1.5, "reproduced"), (0.8, "differs")])
def test_the_stiffer_axis_is_told(factor: float, verdict: str) -> None:
    found = planar.anisotropy(fig3a(line(1e5), line(factor * 1e5)))
    assert found.verdict == verdict
    assert all(value == pytest.approx(factor) for value in found.values.values())


@pytest.mark.parametrize(("later", "verdict"), [(0.8, "reproduced"), (1.0, "differs")])
def test_a_stiffer_first_loading_is_told(later: float, verdict: str) -> None:
    def softened(strain: FloatArray, number: int) -> FloatArray:
        return 1e5 * strain * (1.0 if number == 1 else later)

    found = planar.first_loading(fig3a(softened, softened, line(5e4), 4))
    assert found.verdict == verdict
    assert found.values["W1/W2 C"] == pytest.approx(1.0 / later)


@pytest.mark.parametrize(("drop", "verdict"), [(0.0, "reproduced"), (0.05, "differs")])
def test_later_loadings_that_sink_are_not_identical(drop: float, verdict: str) -> None:
    def sinking(strain: FloatArray, number: int) -> FloatArray:
        return 1e5 * strain * (1.0 - drop * number)

    found = planar.later_cycles(fig3a(sinking, sinking, line(5e4), 4))
    assert found.verdict == verdict
    # Cycles 2 and 4 are 2 drops apart, at the range of cycle 2; √(1/3) is the rms of a line from 0 to 1.
    assert found.values["C"] == pytest.approx(2.0 * drop / (1.0 - 2.0 * drop) / np.sqrt(3.0), abs=1e-4)


@pytest.mark.parametrize(("control", "verdict"), [(1e5, "reproduced"), (0.9e5, "differs")])
def test_a_loop_needs_a_control_without_one(control: float, verdict: str) -> None:
    runs = fig3a(line(1e5), line(1e5), line(0.7e5))
    runs["control"] = record_of("control", [cycles(axis, line(1e5), line(control)) for axis in "CW"])
    found = planar.hysteresis(runs)
    assert found.verdict == verdict
    # Back from the top it first falls at one strain, which takes no work: 30 % of the triangle is lost.
    assert found.values["fig3a"] == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize(
    ("contacts", "angle", "verdict"), [(1, 10.0, "reproduced"), (4, 10.0, "differs"), (1, 25.0, "differs")]
)
def test_the_sequence_is_an_order_of_half_rises(contacts: int, angle: float, verdict: str) -> None:
    strain = made.STRAIN
    bend, stretch = 1e-3 * strain**2, 1e-3 * strain**3
    stored = bend + stretch
    share = np.divide(1.0, stored, out=np.zeros_like(stored), where=stored > 0.0)
    tables = {
        "energy": {
            "strain C": strain,
            "elastic_bend of stored": bend * share,
            "elastic_stretch of stored": stretch * share,
            "stored energy": stored,
        },
        "contacts": {"strain C": strain, "contacts": 100.0 * strain**contacts},
        "shapes": {
            "strain C": strain[::10],
            "median leg angle": np.linspace(23.0, angle, 5),
            "median leg straightness": np.linspace(0.9, 0.95, 5),
        },
    }
    found = planar.sequence({"fig3a": tables_of("fig3a", tables)})  # type: ignore[arg-type]
    assert found.verdict == verdict
    assert found.values["bending"] == pytest.approx(0.4 * 0.5**0.5, abs=1e-3)
    assert found.values["stretch"] == pytest.approx(0.4 * 0.5 ** (1 / 3), abs=1e-3)


@pytest.mark.parametrize(
    ("ratio", "grown", "verdict"), [(0.5, 1e-4, "reproduced"), (-0.1, 1e-4, "differs"), (0.5, 1e-3, "differs")]
)
def test_the_yarn_of_a_uniaxial_test_keeps_its_length(ratio: float, grown: float, verdict: str) -> None:
    shapes = {"strain C": [0.0, 0.2, 0.4], "yarn elongation": [0.0, 5e-4, 2e-3]}
    runs = {"fig3a": tables_of("fig3a", {"shapes": shapes})}
    for axis in "CW":
        columns = {
            f"strain {axis}": [0.0, 0.4],
            f"Poisson's ratio of {axis}": [0.0, ratio],
            "yarn elongation": [0.0, grown],
        }
        runs[f"uniaxial {axis}"] = tables_of("uniaxial", {"shapes": columns})
    assert planar.uniaxial(runs).verdict == verdict


def pre_strained(secants: dict[str, tuple[float, ...]], later: float = 1.0) -> dict[str, Analysed]:
    """Return tests of Fig. 3d whose loadings are lines, back along half of them; later loadings are softer."""
    found = {}
    for along, slopes in secants.items():
        for pre, slope in zip(PRE_STRAINS, slopes, strict=True):

            def out(strain: FloatArray, number: int, slope: float = slope) -> FloatArray:
                return slope * strain * (1.0 if number == 1 else later)

            def back(strain: FloatArray, _: int, slope: float = slope) -> FloatArray:
                return 0.5 * slope * strain

            name = f"fig3d {along} {pre:g}"
            found[name] = record_of(name, [cycles(planar.ALONG[along], out, back, 3)])
    return found


def test_secants_are_those_of_the_first_loading_within_a_quarter() -> None:
    course = (16e3, 40e3, 80e3, 120e3, 160e3)
    runs = pre_strained({"course": course, "wale": (30e3, *course[1:])})
    found = planar.secants_course(runs)
    assert found.verdict == "reproduced"
    assert tuple(found.values.values()) == pytest.approx((16e3, 160e3))
    assert planar.secants_wale(runs).verdict == "differs"


def test_loops_are_areas_between_the_ways() -> None:
    # A loop of half of a triangle of 0.4 strain: slope 0.4² / 4 each.
    slopes = tuple(4.0 * area / 0.16 for area in (0.4e3, 1e3, 2e3, 4e3, 7e3))
    runs = pre_strained({"course": slopes, "wale": slopes})
    found = planar.loops_course(runs)
    assert found.verdict == "reproduced"
    assert tuple(found.values.values()) == pytest.approx((0.4e3, 7e3), rel=0.03)
    assert planar.loops_wale(runs).verdict == "differs"


@pytest.mark.parametrize(("slopes", "later", "verdict"), [
    ((1e4, 2e4, 3e4, 4e4, 5e4), 1.0, "reproduced"),
    ((1e4, 3e4, 2e4, 4e4, 5e4), 1.0, "differs"),
    ((1e4, 2e4, 3e4, 4e4, 5e4), 0.4, "differs"),
])  # fmt: skip
def test_pre_strain_raises_step_by_step_and_returns(slopes: tuple[float, ...], later: float, verdict: str) -> None:
    found = planar.pre_strained(pre_strained({"course": slopes, "wale": slopes}, later))
    assert found.verdict == verdict
    # A line of 0.4 of the slope reaches 5 % of the first's largest stress at 5 % of strain instead of 2 %.
    assert found.values["residual C"] == pytest.approx(0.02 / later - 0.02, abs=1e-6)


@pytest.mark.parametrize(
    ("free", "rubbing", "verdict"), [(0.0, 0.09, "reproduced"), (0.05, 0.09, "differs"), (0.0, 0.0, "differs")]
)
def test_hooks_slip_and_rubbing_ones_do_not(free: float, rubbing: float, verdict: str) -> None:
    runs = {}
    for pole, ratio in ((0.0, free), (0.1, rubbing)):
        # The first row carries next to nothing, and its ratio says nothing.
        columns = {"lateral over axial": [5.0, ratio, ratio], "axial force of a hook": [0.01, 0.5, 1.0]}
        runs[f"hooks {pole:g}"] = tables_of("hooks", {"hooks": columns})
    assert planar.hooks(runs).verdict == verdict


def test_exponents_are_found_and_the_papers_signs_are_reproduced() -> None:
    runs = made.designs(XI)
    found = designs.stiffness(runs)
    assert found.verdict == "reproduced"
    assert {name: round(value, 6) for name, value in found.values.items() if name.endswith("C")} == {
        "d C": -3.0,
        "a C": -2.0,
        "n C": 2.0,
        "r C": 4.0,
    }
    wrong = designs.stiffness(made.designs({**XI, "d": 1.0}))
    assert wrong.verdict == "differs"
    assert "d C, d W" in wrong.why


@pytest.mark.parametrize(("exponent", "verdict"), [(0.3, "reproduced"), (-1.2, "differs")])
def test_lengths_that_matter_do_not_drop_out(exponent: float, verdict: str) -> None:
    found = designs.lengths(made.designs({**XI, "l": exponent}))
    assert found.verdict == verdict
    assert found.values["l W"] == pytest.approx(exponent)


def test_xi_collapses_what_follows_it_and_nothing_else() -> None:
    # Along the course ξ has half of the wale's factor, so that course stress is twice the wale's.
    found = designs.master_curve(made.designs(XI, wale=0.5))
    assert found.verdict == "reproduced"
    assert found.values["spread after"] == pytest.approx(0.0, abs=1e-9)
    assert found.values["R2"] == pytest.approx(1.0)
    other = designs.master_curve(made.designs({"E": 1.0, "r": 2.0, "d": 1.0, "a": -1.0, "n": 1.0}, wale=1.5))
    assert other.verdict == "differs"
    assert "without v" in other.why


@pytest.mark.parametrize(("exponent", "verdict"), [(2.0, "reproduced"), (1.0, "differs")])
def test_the_exponent_of_the_modulus_is_found(exponent: float, verdict: str) -> None:
    found = designs.materials(made.designs({**XI, "E": exponent}))
    assert found.verdict == verdict
    assert found.values["C"] == pytest.approx(exponent)


@pytest.mark.parametrize(("times", "verdict"), [(1.0, "reproduced"), (1.9, "reproduced"), (30.0, "differs")])
def test_cotton_is_on_the_curve_within_the_prints_or_a_factor_of_two(times: float, verdict: str) -> None:
    runs = made.designs(XI)
    curves = [cycles(axis, exponential(times * 1e3, 16.5)) for axis in "CW"]
    facts = {**made.BASE, "young_modulus": 1.1e9, "thickness": 1e-3, "locking_strain": 0.6}
    runs["cotton"] = record_of("cotton", curves, facts)
    found = designs.cotton(runs)
    assert found.verdict == verdict
    assert found.values["signed C"] == pytest.approx(np.log(times), abs=1e-6)


def printed(strands: float, between_layers: float, clearance: float) -> dict[str, Analysed]:
    found = {}
    for name, rows, layers, per_layer in (("4x4x2", 4.0, 2.0, between_layers), ("6x6x6", 6.0, 6.0, 180.0)):
        facts = {"rows": rows, "loops": rows, "layers": layers, "strands": strands, "clearance": clearance}
        counts = {"clasps rows": (rows - 1.0) * rows * layers, "clasps layers": per_layer}
        found[f"topology {name}"] = record_of(name, facts={**facts, **counts, "fibre_radius": 0.4e-3})
    return found


@pytest.mark.parametrize(
    ("strands", "layers", "clearance", "verdict"),
    [
        (1.0, 16.0, 4e-4, "reproduced"),
        (2.0, 16.0, 4e-4, "differs"),
        (1.0, 15.0, 4e-4, "differs"),
        (1.0, 16.0, -1e-6, "differs"),
    ],
)
def test_a_topology_is_one_yarn_with_all_clasps(strands: float, layers: float, clearance: float, verdict: str) -> None:
    assert volumetric.topology(printed(strands, layers, clearance)).verdict == verdict


@pytest.mark.parametrize(("pile", "verdict"), [(3e5, "reproduced"), (0.9e5, "differs")])
def test_the_stiffest_direction_is_told(pile: float, verdict: str) -> None:
    slopes = {"C": 1e4, "W": 1e5, "P": pile}
    runs = {f"fig4c {axis}": record_of(axis, [cycles(axis, line(slope))]) for axis, slope in slopes.items()}
    assert volumetric.stiffest(runs).verdict == verdict


@pytest.mark.parametrize(("rate", "verdict"), [(16.5, "reproduced"), (2.0, "differs")])
def test_like_shapes_are_alike_whatever_their_size(rate: float, verdict: str) -> None:
    runs = fig3a(exponential(900.0, 16.5), exponential(900.0, 16.5))
    strain = np.linspace(0.0, 0.3, 31)
    curves = [cycles(axis, exponential(10.0, rate * 4.0 / 3.0), strain=strain) for axis in "CW"]
    runs["volumetric"] = record_of("volumetric", curves)
    assert volumetric.equibiaxial(runs).verdict == verdict


@pytest.mark.parametrize(("slopes", "verdict"), [((1e4, 2e4, 4e4), "reproduced"), ((1e4, 4e4, 2e4), "differs")])
def test_a_pile_that_is_tuned_rises(slopes: tuple[float, ...], verdict: str) -> None:
    runs = {
        f"fig4d {pre:g}": record_of("fig4d", [cycles("P", line(slope), line(0.5 * slope))])
        for pre, slope in zip((0.0, 0.1, 0.2), slopes, strict=True)
    }
    assert volumetric.tuned_pile(runs).verdict == verdict


def rupture(micro: float, breaks: float) -> dict[str, Analysed]:
    """Return two knits whose σ/E is that of a square of strain up to 1, then falls; times `micro` of the micro one."""
    strain = np.linspace(0.0, 1.2, 121)

    def over_modulus(factor: float) -> made.Curve:
        return lambda at, _: factor * 2e-5 * np.where(at <= 1.0, at**2, 0.2)

    found = {}
    for name, factor, modulus in (("micro", micro, 3e9), ("macro", 1.0, 0.82e9)):
        curve = over_modulus(factor * modulus)
        found[f"fig5 {name}"] = record_of(name, [cycles("P", curve, strain=strain)], {"young_modulus": modulus})
    bonds: dict[str, Sequence[Cell]] = {
        "from strain": [0.3, breaks - 0.02],
        "to strain": [0.34, breaks + 0.02],
        "broken": [1, 5],
    }
    table = tables_of("micro", {"bonds": bonds}).tables
    one = found["fig5 micro"]
    found["fig5 micro"] = Analysed(name="fig5 micro", curves=one.curves, facts=one.facts, tables=table)
    return found


@pytest.mark.parametrize(
    ("micro", "breaks", "verdicts"),
    [
        (1.2, 1.0, ("reproduced", "reproduced", "reproduced")),
        (2.0, 0.4, ("differs", "differs", "differs")),
        (0.9, 1.0, ("reproduced", "differs", "reproduced")),
    ],
)
def test_micro_and_macro_are_compared_by_modulus(micro: float, breaks: float, verdicts: tuple[str, ...]) -> None:
    runs = rupture(micro, breaks)
    found = [one(runs) for one in (volumetric.same_response, volumetric.fused_points, volumetric.same_strength)]
    assert tuple(one.verdict for one in found) == verdicts
    assert found[1].values["peak of breaks"] == pytest.approx(breaks)
    assert found[2].values == pytest.approx({"slope": micro, "strength": micro}, rel=1e-6)


def test_no_fused_point_that_breaks_has_no_strain() -> None:
    runs = rupture(1.0, 1.0)
    none = tables_of("micro", {"bonds": {"from strain": [], "to strain": [], "broken": []}}).tables
    runs["fig5 micro"] = Analysed(name="fig5 micro", curves=runs["fig5 micro"].curves, tables=none)
    with pytest.raises(UnscorableError, match="no fused point broke"):
        volumetric.fused_points(runs)


@pytest.mark.parametrize(
    ("speed", "hooks", "verdict"), [(0.2e-3, 12, "reproduced"), (0.3e-3, 12, "differs"), (0.2e-3, 6, "differs")]
)
def test_constants_are_read_back(speed: float, hooks: int, verdict: str) -> None:
    planar_facts = {"speed C": speed, "loops": 6.0, "rows": 6.0, "pole_friction": 0.0}
    runs = {
        "fig3a": Analysed(name="fig3a", facts=planar_facts, hooks=lambda: {"C": 6, "W": hooks}),
        "fig3c RGD8530-DM": record_of("soft", facts={"young_modulus": 0.82e9}),
        "fig3c VeroUltraWhite": record_of("stiff", facts={"young_modulus": 2.0e9}),
        "fig5 micro": record_of(
            "micro", facts={"young_modulus": 3.0e9, "loop_width": 50e-6, "height": 100e-6, "speed P": 1.02e-7}
        ),
    }
    assert constants.constants(runs).verdict == verdict
