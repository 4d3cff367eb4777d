"""The claims of the paper: one row each, with its criterion and the tests that it is scored from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

from app.studies.scoreboard import constants, designs, planar, volumetric
from app.studies.scoreboard.analysed import UnscorableError
from app.studies.scoreboard.plan import CHANGED, design_names
from app.studies.scoreboard.verdict import Score

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from app.studies.scoreboard.analysed import Analysed


MOST_NAMED: Final = 3
"""Tests that are named where they are missing."""


class Claim(NamedTuple):
    """What the paper says: in words, where, and its number."""

    words: str
    where: str
    paper: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One claim of the paper and how it is scored.

    Attributes
    ----------
    number : int
        Its number on the board.
    claim : Claim
        What the paper says.
    criterion : str
        When it counts as reproduced.
    tests : tuple of str
        Tests that it needs, by name or by how their names begin, followed by ``*``.
    score : callable
        Scores it from the tests by their names.
    fitted : str
        What of it was fitted to the paper, and so is no prediction; empty of what is predicted.
    """

    number: int
    claim: Claim
    criterion: str
    tests: tuple[str, ...]
    score: Callable[[Mapping[str, Analysed]], Score]
    fitted: str = ""

    def needs(self, name: str) -> bool:
        """Return whether it needs a test."""
        return any(name.startswith(one[:-1]) if one.endswith("*") else name == one for one in self.tests)

    def scored(self, runs: Mapping[str, Analysed], failed: Mapping[str, str]) -> Score:
        """Return its score from the tests that there are.

        Parameters
        ----------
        runs : Mapping
            Tests that were run.
        failed : Mapping
            Why tests could not be run.
        """
        missing = [name for name in self.tests if not name.endswith("*") and name not in runs]
        if missing:
            return Score(verdict="not scorable", ours="–", why=_said(missing, failed))
        try:
            return self.score({name: run for name, run in runs.items() if self.needs(name)})
        except UnscorableError as error:
            return Score(verdict="not scorable", ours="–", why=str(error))
        except KeyError as error:
            return Score(verdict="not scorable", ours="–", why=_said([str(error.args[0])], failed))


def _said(missing: Sequence[str], failed: Mapping[str, str]) -> str:
    """Return which tests there are not, and why."""
    known = [f"{name}: {failed[name]}" for name in missing if name in failed]
    others = [name for name in missing if name not in failed]
    few = ", ".join(others[:MOST_NAMED]) + (f" and {len(others) - MOST_NAMED} more" if len(others) > MOST_NAMED else "")
    return "; ".join([*known, *([f"not run: {few}"] if others else [])])


def _changed(*numbers: str) -> tuple[str, ...]:
    """Return the tests in which these numbers of the specimen are changed."""
    return ("fig3c", *(f"fig3c {number}={value:g}" for number in numbers for value in CHANGED[number]))


_PAIR: Final = ("fig5 micro", "fig5 macro")
_BLOCKS: Final = ("fig4c C", "fig4c W", "fig4c P")
_SECANTS: Final = "both within 25 %"

ROWS: Final[Sequence[Row]] = (
    Row(
        number=1,
        claim=Claim("exponential equibiaxial response to 40 %", "3a, 3c", "β = 16.50"),
        criterion="β of ln σ over ε, first loading from 2 % of its largest stress, within 25 %, R² ≥ 0.95, both axes",
        tests=("fig3a",),
        score=planar.exponential,
    ),
    Row(
        number=2,
        claim=Claim("the wale is stiffer than the course", "3a", "σ_W/σ_C > 1"),
        criterion="σ_W/σ_C > 1 at 20, 30 and 40 % of the first loading",
        tests=("fig3a",),
        score=planar.anisotropy,
    ),
    Row(
        number=3,
        claim=Claim("the first loading is stiffer than later ones", "3a", "yes"),
        criterion="work of loading 1 over loading 2 above 1.05, both axes",
        tests=("fig3a",),
        score=planar.first_loading,
        fitted="the yield curve was chosen so that it is clearly so; by how much was not fitted",
    ),
    Row(
        number=4,
        claim=Claim("later cycles are identical", "3a", "yes"),
        criterion="NRMSE of loadings 2, 3 and 4, two by two, at most 2 %, both axes",
        tests=("fig3a",),
        score=planar.later_cycles,
    ),
    Row(
        number=5,
        claim=Claim("hysteresis", "3a", "> 0"),
        criterion="loops of both axes at least 5 % of the work of loading; elastic and without friction at most 0.5 %",
        tests=("fig3a", "control"),
        score=planar.hysteresis,
    ),
    Row(
        number=6,
        claim=Claim("contact first, then bending, then upright legs and axial strain", "3b", "sequence"),
        criterion="half rise of contacts before that of bending energy before that of stretch energy; legs end more "
        "upright and straighter",
        tests=("fig3a",),
        score=planar.sequence,
    ),
    Row(
        number=7,
        claim=Claim("uniaxial: sides contract, the yarn keeps its length", "text", "yes"),
        criterion="ν > 0 at 40 %, and |ΔL/L| at most a fifth of the equibiaxial one, both axes",
        tests=("fig3a", "uniaxial C", "uniaxial W"),
        score=planar.uniaxial,
    ),
    Row(
        number=8,
        claim=Claim("stiffness falls with d and a, rises with n and r", "SI", "exponents −3, −2, +2, +4"),
        criterion="signs of the exponents of stress at 30 %, 95 % intervals without 0, both axes",
        tests=_changed("d", "a", "n", "r"),
        score=designs.stiffness,
    ),
    Row(
        number=9,
        claim=Claim("l and h drop out of ξ", "SI", "exponents 0"),
        criterion="exponents of stress at 30 % within ±0.5, both axes",
        tests=_changed("l", "h"),
        score=designs.lengths,
    ),
    Row(
        number=10,
        claim=Claim("ξ = v d³a²/(E²n²r⁴) collapses all curves", "3c", "accurately"),
        criterion="spread of ln ξσ at most half of that of ln σ, between designs, 20 to 40 %",
        tests=tuple(design_names()),
        score=designs.master_curve,
    ),
    Row(
        number=11,
        claim=Claim("two materials collapse", "3c", "σ ∝ E²"),
        criterion="exponent of E between the two resins 2 within 25 %, both axes",
        tests=("fig3c RGD8530-DM", "fig3c VeroUltraWhite"),
        score=designs.materials,
    ),
    Row(
        number=12,
        claim=Claim("cotton of a knitting machine lies on the same curve", "3c", "yes"),
        criterion="rms distance of ln ξσ from the mean print no more than the farthest print's, or ln 2, both axes",
        tests=("cotton", *design_names()),
        score=designs.cotton,
    ),
    Row(
        number=13,
        claim=Claim("course secant, wale pre-strain 0 → 0.4", "3d", "0.015 → 0.166 MPa"),
        criterion=_SECANTS,
        tests=("fig3d course 0", "fig3d course 0.4"),
        score=planar.secants_course,
        fitted="both secants",
    ),
    Row(
        number=14,
        claim=Claim("wale secant, course pre-strain 0 → 0.4", "3d", "0.021 → 0.190 MPa"),
        criterion=_SECANTS,
        tests=("fig3d wale 0", "fig3d wale 0.4"),
        score=planar.secants_wale,
        fitted="both secants",
    ),
    Row(
        number=15,
        claim=Claim("dissipation of the course, wale pre-strain 0 → 0.4", "3d", "0.39e-3 → 6.9e-3 MPa"),
        criterion=_SECANTS,
        tests=("fig3d course 0", "fig3d course 0.4"),
        score=planar.loops_course,
        fitted="yield and relaxation were chosen for these loops to be near",
    ),
    Row(
        number=16,
        claim=Claim("dissipation of the wale, course pre-strain 0 → 0.4", "3d", "0.43e-3 → 4.6e-3 MPa"),
        criterion=_SECANTS,
        tests=("fig3d wale 0", "fig3d wale 0.4"),
        score=planar.loops_wale,
    ),
    Row(
        number=17,
        claim=Claim("monotone in pre-strain, returns to its start, repeatable", "3d", "yes"),
        criterion="rank correlations of secant and loop 1; toe of loading 2 at most 2 % of strain later; NRMSE of "
        "loadings 2 and 3 at most 5 %",
        tests=("fig3d *",),
        score=planar.pre_strained,
    ),
    Row(
        number=18,
        claim=Claim("one yarn, two kinds of loop in 4x4x2 and 6x6x6", "4a, 4b", "yes"),
        criterion="one strand; every clasp between rows and between layers; centrelines more than 2r apart",
        tests=volumetric.TOPOLOGIES,
        score=volumetric.topology,
    ),
    Row(
        number=19,
        claim=Claim("volumetric: the pile is stiffest", "4c", "P > C, W"),
        criterion="stress at 40 %, sides free",
        tests=_BLOCKS,
        score=volumetric.stiffest,
    ),
    Row(
        number=20,
        claim=Claim("volumetric equibiaxial response is like the planar one", "SI", "yes"),
        criterion="NRMSE of curves over their largest strain and stress at most 10 %, both axes",
        tests=("fig3a", "volumetric"),
        score=volumetric.equibiaxial,
    ),
    Row(
        number=21,
        claim=Claim("pile stiffness and dissipation are tuned by pre-strain 0 to 0.2", "4d", "yes"),
        criterion="secant to 40 % and loop rise with every pre-strain",
        tests=("fig4d 0", "fig4d 0.1", "fig4d 0.2"),
        score=volumetric.tuned_pile,
    ),
    Row(
        number=22,
        claim=Claim("macro and micro have the same σ/E", "5b", "yes"),
        criterion="NRMSE at most 25 % up to the lesser strain at the largest force",
        tests=_PAIR,
        score=volumetric.same_response,
    ),
    Row(
        number=23,
        claim=Claim("micro is stiffer at first, fused points rupture near ε = 1", "5b", "ε ≈ 1"),
        criterion="micro over macro above 1 up to half of the strain at which most break; that strain 1 within 25 %",
        tests=_PAIR,
        score=volumetric.fused_points,
    ),
    Row(
        number=24,
        claim=Claim("same slope after that, same normalised strength", "5b", "≈"),
        criterion="ratios of slope (0.7 to 0.95 of the strain at the largest force) and of largest σ/E 1 within 25 %",
        tests=_PAIR,
        score=volumetric.same_strength,
    ),
    Row(
        number=25,
        claim=Claim(
            "constants of the experiments",
            "Methods",
            "0.2 mm/s; 1e-3 /s; two hooks per boundary loop; E 0.82, 2.0, 3.0 GPa; 50 µm",
        ),
        criterion="read back from logs and records, within 1 % (the strain rate, stated as approximate, within 5 %)",
        tests=("fig3a", "fig3c RGD8530-DM", "fig3c VeroUltraWhite", "fig5 micro"),
        score=constants.constants,
    ),
    Row(
        number=26,
        claim=Claim("hooks: force one way, slip the other", "Methods", "≈ 0"),
        criterion="largest lateral over axial force of a hook at most 1 %; above 0 where poles rub",
        tests=("hooks *",),
        score=planar.hooks,
    ),
)
"""All 26 claims, by number."""
