"""Scores of planar rows on records with a known answer: reproduced, and not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.studies.scoreboard import planar
from app.studies.scoreboard.plan import PRE_STRAINS
from tests.app.studies.scoreboard import made
from tests.app.studies.scoreboard.made import cycles, exponential, line, record_of, tables_of

if TYPE_CHECKING:
    from app.studies.scoreboard.analysed import Analysed
    from rigs.axes import FloatArray


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
