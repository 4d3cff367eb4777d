"""Scores of the rows about many designs: exponents, the paper's ξ, materials, cotton (Fig. 3c)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.studies.scoreboard.analysed import UnscorableError
from app.studies.scoreboard.plan import CHANGED, MATERIALS, design_names
from app.studies.scoreboard.verdict import Score, judged
from rigs.analysis.master_curve import Design, bending_factor, paper_factor
from rigs.analysis.onset import toe
from rigs.analysis.regression import LineFit, fit_line
from rigs.analysis.scaling import ScalingTest, log_stresses, scaling_test

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from app.studies.scoreboard.analysed import Analysed
    from rigs.axes import Axis, FloatArray

AT: Final = 0.3
"""Strain at which exponents are fitted [1]."""

BETWEEN: Final = (0.2, 0.4)
"""Strains between which curves are compared [1]."""

BETWEEN_LOCKS: Final = (0.5, 0.65)
"""The same in locking strains [1]."""

PAPER: Final[Mapping[str, float]] = {"d": -3.0, "a": -2.0, "n": 2.0, "r": 4.0}
"""Exponents of stress that the paper's ξ stands for: stress is proportional to 1 / ξ."""

PLANAR: Final[tuple[Axis, ...]] = ("C", "W")


def designs_of(runs: Mapping[str, Analysed], names: Sequence[str], axes: Sequence[Axis] = PLANAR) -> list[Design]:
    """Return the loadings of tests along axes, each with the numbers of its specimen, those that were run alone."""
    found = []
    for name in names:
        if name not in runs:
            continue
        run = runs[name]
        values = {**run.facts, "E": run.facts["young_modulus"], "t": run.facts["thickness"]}
        for axis in axes:
            strain, stress = run.loading(axis)
            found.append(Design(name=name, axis=axis, values=values, strain=strain, stress=stress))
    return found


def exponents(runs: Mapping[str, Analysed], changed: Sequence[str]) -> dict[str, LineFit]:
    """Return the exponent of stress at `AT` by each number that was changed while others stayed, along each axis."""
    found = {}
    for number in changed:
        for axis in PLANAR:
            designs = designs_of(runs, _changed(number), (axis,))
            found[f"{number} {axis}"] = exponent_of(designs, number)
    return found


def exponent_of(designs: Sequence[Design], number: str) -> LineFit:
    """Fit ln(stress) at `AT` by the logarithm of a number; the slope is the exponent, with its 95 % interval."""
    stresses = np.array([float(one.stress_at(AT)) for one in designs])
    values = np.array([one.values[number] for one in designs])
    good = np.isfinite(stresses)
    return fit_line(np.log(values[good]), np.log(stresses[good]))


def _said(fit: LineFit) -> str:
    return f"{fit.slope:.1f} ± {0.5 * (fit.high - fit.low):.1f}"


def stiffness(runs: Mapping[str, Analysed]) -> Score:
    """Score the signs of the exponents of d, a, n and r: as the paper's along both axes, 95 % intervals without 0.

    The number of fibres n is changed at one section of the yarn, as the paper did; the exponent at one fibre radius is
    that plus half of the exponent of r.
    """
    fits = exponents(runs, list(PAPER))
    ours = "; ".join(f"{number} {_said(fits[f'{number} C'])} (C), {_said(fits[f'{number} W'])} (W)" for number in PAPER)
    values = {name: fit.slope for name, fit in fits.items()}
    wrong = [
        name for name, fit in fits.items() if not (fit.low > 0.0 if PAPER[name.split()[0]] > 0.0 else fit.high < 0.0)
    ]
    why = f"no such sign beyond its interval: {', '.join(wrong)}; {_fibres_said(runs)}"
    return judged(not wrong, f"exponents at {AT:.0%} of strain: {ours}", values, why)


def _fibres_said(runs: Mapping[str, Analysed]) -> str:
    """Return the stress of yarns of several fibres over that of one, in words."""
    said = []
    for axis in PLANAR:
        stresses = [float(one.stress_at(AT)) for one in designs_of(runs, _changed("n"), (axis,))]
        said.append(f"{', '.join(f'{stress / stresses[0]:.2f}' for stress in stresses[1:])} ({axis})")
    fibres = ", ".join(f"{number:g}" for number in CHANGED["n"])
    return f"glued yarns of {fibres} fibres of one section carry {' and '.join(said)} times what one fibre does"


def lengths(runs: Mapping[str, Analysed]) -> Score:
    """Score the exponents of l and h, w - h held: 0.5 at most along both axes."""
    fits = exponents(runs, ("l", "h"))
    values = {name: fit.slope for name, fit in fits.items()}
    ours = "; ".join(f"{number} {_said(fits[f'{number} C'])} (C), {_said(fits[f'{number} W'])} (W)" for number in "lh")
    bent = ", ".join(f"{number} {_by_bending(runs, number):.1f}" for number in "lh")
    toes = "; ".join(f"{number}: {_toes_said(runs, number)}" for number in "lh")
    why = (
        "a larger loop of the same yarn bends more easily: a stress that keeps Σ = σ t L l w/(E I) would go with the "
        f"exponents {bent}, and exponents are steeper the nearer the slack is, which has just ended at {AT:.0%}: toes "
        f"(5 % of the largest stress) from the least to the largest value, {toes}"
    )
    return judged(all(abs(value) <= 0.5 for value in values.values()), ours, values, why)


def _by_bending(runs: Mapping[str, Analysed], number: str) -> float:
    """Return the exponent of stress by a number at a constant Σ."""
    found = designs_of(runs, _changed(number), ("C",))
    logs = -np.log([bending_factor(one.values, "C") for one in found])
    return fit_line(np.log([one.values[number] for one in found]), logs).slope


def _toes_said(runs: Mapping[str, Analysed], number: str) -> str:
    """Return the toes of the designs with the least and with the largest value of a number, in words."""
    said = []
    for axis in PLANAR:
        ends = sorted(designs_of(runs, _changed(number), (axis,)), key=lambda one: one.values[number])
        least, largest = (100.0 * toe(one.strain, one.stress, float(one.stress[-1])) for one in (ends[0], ends[-1]))
        said.append(f"{least:.1f} to {largest:.1f} % ({axis})")
    return ", ".join(said)


def _changed(number: str) -> list[str]:
    """Return the tests in which a number has its values, its own first."""
    return ["fig3c", *(f"fig3c {number}={value:g}" for value in CHANGED[number])]


def collapses(runs: Mapping[str, Analysed]) -> dict[str, ScalingTest]:
    """Return the test of each scaling on all designs along both axes: the paper's, stress over E, bending."""
    designs = designs_of(runs, design_names())
    factors: dict[str, Callable[[Mapping[str, float], Axis], float]] = {
        "xi": paper_factor,
        "xi without v": lambda values, _: paper_factor(values, "W"),
        "1/E": lambda values, _: 1.0 / values["E"],
        "bending": bending_factor,
    }
    found = {
        name: scaling_test(designs, [factor(one.values, one.axis) for one in designs], BETWEEN)
        for name, factor in factors.items()
    }
    scaled = [_over_lock(one) for one in designs]
    bending = [bending_factor(one.values, one.axis) for one in designs]
    return {**found, "bending over locking": scaling_test(scaled, bending, BETWEEN_LOCKS)}


def _left_over(runs: Mapping[str, Analysed]) -> str:
    """Return how far ln(ξ σ) is from that of the specimen itself where one number is changed, rms, in words."""
    groups = {number: [f"fig3c {number}={value:g}" for value in values] for number, values in CHANGED.items()}
    groups["E"] = [f"fig3c {material}" for material in MATERIALS]
    said = []
    for number, names in groups.items():
        off = []
        for axis in PLANAR:
            own = _normalised(designs_of(runs, ["fig3c"], (axis,)), axis)
            off.append(_normalised(designs_of(runs, names, (axis,)), axis) - own)
        said.append((float(np.sqrt(np.nanmean(np.concatenate(off) ** 2))), number))
    return ", ".join(f"{number} {value:.2f}" for value, number in sorted(said, reverse=True))


def _over_lock(design: Design) -> Design:
    """Return a design with its strain over its locking strain."""
    strain = design.strain / design.values["locking_strain"]
    return Design(name=design.name, axis=design.axis, values=design.values, strain=strain, stress=design.stress)


def master_curve(runs: Mapping[str, Analysed]) -> Score:
    """Score the spread of ln(ξ σ) between designs: at most half of that of ln(σ), at 20 to 40 % of strain."""
    found = collapses(runs)
    xi, stiff, bending = found["xi"], found["1/E"], found["bending over locking"]
    values = {
        "spread before": xi.before,
        "spread after": xi.after,
        "R2": xi.r_squared,
        "left out": xi.left_out,
        "p": xi.p_value,
    }
    ours = (
        f"spread of ln σ {xi.before:.2f}, of ln ξσ {xi.after:.2f} (R² {xi.r_squared:.2f}, a design left out is missed "
        f"by {xi.left_out:.2f}, p {xi.p_value:.2g}), of ln σ/E {stiff.after:.2f}; over ε/ε_lock ln σ "
        f"{bending.before:.2f}, ln Σ {bending.after:.2f}; {xi.curves} curves"
    )
    without = found["xi without v"]
    course, wale = (designs_of(runs, ["fig3c"], (axis,))[0].stress_at(AT) for axis in PLANAR)
    why = (
        f"v asks for σ_W/σ_C = 0.5, our specimen has {float(wale / course):.2f} at {AT:.0%}: without v ln ξσ is spread "
        f"by {without.after:.2f} (R² {without.r_squared:.2f}, p {without.p_value:.2g}); how far ξσ moves where one "
        f"number is changed, rms of ln: {_left_over(runs)}"
    )
    return judged(xi.after <= 0.5 * xi.before, ours, values, why)


def materials(runs: Mapping[str, Analysed]) -> Score:
    """Score the exponent of Young's modulus between the two resins: 2 within 25 % along both axes."""
    values: dict[str, float] = {}
    for axis in PLANAR:
        soft, stiff = (designs_of(runs, [f"fig3c {material}"], (axis,)) for material in MATERIALS)
        if not soft or not stiff:
            raise UnscorableError("one of the two materials was not run")
        ratio = float(stiff[0].stress_at(AT)) / float(soft[0].stress_at(AT))
        values[axis] = float(np.log(ratio) / np.log(stiff[0].values["E"] / soft[0].values["E"]))
    ours = f"σ ∝ E^{values['C']:.2f} (C), E^{values['W']:.2f} (W) at {AT:.0%}, 0.82 and 2.0 GPa"
    why = (
        "geometry alone leaves stress proportional to the modulus (exponent 1 for linear elastic rods), relaxation and "
        "yield bend it a little; an exponent of 2 needs another difference of the two prints"
    )
    return judged(all(abs(value - 2.0) <= 0.5 for value in values.values()), ours, values, why)


def cotton(runs: Mapping[str, Analysed]) -> Score:
    """Score ln(ξ σ) of cotton against the printed designs: within their range, or ln 2 of it, where all have a stress.

    Compared are rms distances from the mean printed curve, axis by axis, and the largest distance of a printed one.
    """
    if "cotton" not in runs:
        raise UnscorableError("cotton was not run")
    values: dict[str, float] = {}
    for axis in PLANAR:
        printed = _normalised(designs_of(runs, design_names(), (axis,)), axis)
        spun = _normalised(designs_of(runs, ["cotton"], (axis,)), axis)[0]
        mean = printed.mean(axis=0)
        both = np.isfinite(mean) & np.isfinite(spun)
        if not both.any():
            strain, stress = runs["cotton"].loading(axis)
            raise UnscorableError(
                f"cotton pushes its hooks along {axis}, by {-stress[0] / 1e3:.1f} kPa as mounted and by "
                f"{-stress[-1] / 1e3:.1f} kPa at {100 * strain[-1]:.0f} %: a stress below 0 has no logarithm"
                f"{runs['cotton'].ended()}"
            )
        values[f"cotton {axis}"] = float(np.sqrt(np.mean((spun - mean)[both] ** 2)))
        values[f"signed {axis}"] = float(np.mean((spun - mean)[both]))
        values[f"prints {axis}"] = float(np.sqrt(np.mean((printed - mean)[:, both] ** 2, axis=1)).max())
    ours = "; ".join(
        f"{axis}: cotton is {np.exp(abs(values[f'signed {axis}'])):.1f} times "
        f"{'above' if values[f'signed {axis}'] > 0.0 else 'below'} the mean print, the farthest print "
        f"{np.exp(values[f'prints {axis}']):.1f} times off"
        for axis in PLANAR
    )
    good = all(values[f"cotton {axis}"] <= max(values[f"prints {axis}"], np.log(2.0)) for axis in PLANAR)
    fact = runs["cotton"].facts
    why = (
        f"yarn that is straight at rest is bent into its loops and loads its hooks from the beginning, "
        f"{_force_at_rest(runs['cotton'])}; its E of {fact['young_modulus'] / 1e9:g} GPa is assumed"
    )
    return judged(good, ours, values, why)


def _normalised(designs: Sequence[Design], axis: Axis) -> FloatArray:
    """Return ln(ξ σ) of designs at `BETWEEN`, (n, strains)."""
    if not designs:
        raise UnscorableError("no design was run")
    factors = np.array([paper_factor(one.values, axis) for one in designs])
    found: FloatArray = log_stresses(designs, BETWEEN) + np.log(factors)[:, None]
    return found


def _force_at_rest(cotton: Analysed) -> str:
    at_rest = {axis: float(cotton.loading(axis)[1][0]) for axis in PLANAR}
    return ", ".join(f"{value / 1e3:.1f} kPa along {axis} as mounted" for axis, value in at_rest.items())
