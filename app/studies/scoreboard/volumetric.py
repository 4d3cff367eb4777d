"""Scores of the rows of volumetric knits: Figs. 4 and 5."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from app.studies.scoreboard.analysed import UnscorableError
from app.studies.scoreboard.plan import PILE_PRE_STRAINS
from app.studies.scoreboard.verdict import Score, is_near, judged
from rigs.analysis.maxima import row_of_maximum
from rigs.analysis.moduli import stress_at
from rigs.analysis.onset import half_rise
from rigs.analysis.ranks import rank_correlation
from rigs.analysis.regression import segment_modulus
from rigs.analysis.repeatability import curve_nrmse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.studies.scoreboard.analysed import Analysed
    from rigs.axes import FloatArray

TOPOLOGIES: Final = ("topology 4x4x2", "topology 6x6x6")

SLOPE: Final = (0.7, 0.95)
"""Where the slope before the largest force is taken, in the strain at it [1]."""


def topology(runs: Mapping[str, Analysed]) -> Score:
    """Score one yarn, both kinds of clasps in their full number, and a clearance above 0, of 4x4x2 and 6x6x6."""
    good, words, values = True, [], {}
    for name in TOPOLOGIES:
        facts = runs[name].facts
        rows, loops, layers = (int(facts[key]) for key in ("rows", "loops", "layers"))
        wanted = {"rows": (rows - 1) * loops * layers, "layers": rows * loops * (layers - 1)}
        found = {joined: int(facts.get(f"clasps {joined}", 0)) for joined in wanted}
        good &= found == wanted and facts["strands"] == 1 and facts["clearance"] > 0.0
        values[f"clearance {name}"] = facts["clearance"]
        words.append(
            f"{rows}x{loops}x{layers}: {facts['strands']:.0f} yarn, {found['rows']} of {wanted['rows']} clasps between "
            f"rows, {found['layers']} of {wanted['layers']} between layers, centrelines "
            f"{1e3 * (facts['clearance'] + 2.0 * facts['fibre_radius']):.2f} mm apart at least "
            f"(2r = {2e3 * facts['fibre_radius']:.2f} mm)"
        )
    return judged(good, "; ".join(words), values, "clasps are missing, strands overlap, or the yarn is in pieces")


def stiffest(runs: Mapping[str, Analysed]) -> Score:
    """Score the stress at 40 % along the pile: above that along course and wale."""
    values = {axis: stress_at(*runs[f"fig4c {axis}"].loading(axis), 0.4) for axis in ("C", "W", "P")}
    ours = f"{', '.join(f'{axis} {value / 1e3:.2f}' for axis, value in values.items())} kPa at 40 %"
    return judged(values["P"] > max(values["C"], values["W"]), ours, values, "the pile is not stiffest")


def equibiaxial(runs: Mapping[str, Analysed]) -> Score:
    """Score the NRMSE of volumetric and planar loading, each over its largest stress and strain: 10 % at most."""
    values = {}
    for axis in ("C", "W"):
        planar, block = runs["fig3a"].loading(axis), runs["volumetric"].loading(axis)
        values[axis] = curve_nrmse(_scaled(*planar), _scaled(*block))
    ends = {axis: runs["volumetric"].loading(axis) for axis in ("C", "W")}
    flat = {axis: runs["fig3a"].loading(axis) for axis in ("C", "W")}
    ours = f"NRMSE of scaled curves {', '.join(f'{axis} {100 * value:.0f} %' for axis, value in values.items())}"
    ratio = float(ends["W"][1][-1] / ends["C"][1][-1])
    late = {
        name: f"{100 * half_rise(*loadings['C']) / loadings['C'][0][-1]:.0f} % (C), "
        f"{100 * half_rise(*loadings['W']) / loadings['W'][0][-1]:.0f} % (W)"
        for name, loadings in (("volumetric", ends), ("planar", flat))
    }
    why = (
        f"half of the stress is reached at {late['volumetric']} of the strain, by the planar knit at "
        f"{late['planar']}; at its end the wale carries {ratio:.1f} times the course, for each stitch has a pile loop "
        "too, whose yarn the course can draw on"
    )
    return judged(all(value <= 0.1 for value in values.values()), ours, values, why)


def _scaled(strain: FloatArray, stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    return strain / strain[-1], stress / stress[-1]


def tuned_pile(runs: Mapping[str, Analysed]) -> Score:
    """Score whether the pile's secant to 40 % and its loop rise with every pre-strain."""
    first = [runs[f"fig4d {pre:g}"].cycles("P")[0] for pre in PILE_PRE_STRAINS]
    secants, loops = [one.peak_secant for one in first], [one.loop_area for one in first]
    values = {
        "rank of secant": rank_correlation(PILE_PRE_STRAINS, secants),
        "rank of loop": rank_correlation(PILE_PRE_STRAINS, loops),
    } | {f"secant at {pre:g}": value for pre, value in zip(PILE_PRE_STRAINS, secants, strict=True)}
    if not np.isfinite(loops).all():
        raise UnscorableError(f"a cycle of the pile did not come back: {runs['fig4d 0.2'].message}")
    ours = (
        f"secant {', '.join(f'{value / 1e3:.0f}' for value in secants)} kPa, loop "
        f"{', '.join(f'{value / 1e3:.2f}' for value in loops)} kJ/m³ at pre-strains of 0, 0.1, 0.2"
    )
    good = values["rank of secant"] > 0.999 and values["rank of loop"] > 0.999
    return judged(good, ours, values, "they do not both rise")


def _by_modulus(run: Analysed) -> tuple[FloatArray, FloatArray, int]:
    """Return strain [1] and σ/E [1] of a test to rupture, and the row of its largest force."""
    if "P" not in run.curves:
        raise UnscorableError(f"{run.name} was not pulled along its pile")
    test = run.curves["P"]
    top = row_of_maximum(test.force)
    if top is None:
        raise UnscorableError(f"{run.name} carried nothing")
    return test.strain, test.stress / run.facts["young_modulus"], top


def same_response(runs: Mapping[str, Analysed]) -> Score:
    """Score the NRMSE of σ/E of micro and macro, up to the lesser strain of both at their largest force: 25 %."""
    curves = {name: _by_modulus(runs[f"fig5 {name}"]) for name in ("macro", "micro")}
    last = min(float(strain[top]) for strain, _, top in curves.values())
    loadings = {
        name: (strain[: top + 1][strain[: top + 1] <= last], over[: top + 1][strain[: top + 1] <= last])
        for name, (strain, over, top) in curves.items()
    }
    error = curve_nrmse(loadings["macro"], loadings["micro"])
    tops = {name: float(over[top]) for name, (_, over, top) in curves.items()}
    ours = f"NRMSE {100 * error:.0f} % up to {100 * last:.0f} %; largest σ/E " + ", ".join(
        f"{name} {value:.1e}" for name, value in tops.items()
    )
    middle = {name: float(np.interp(0.6 * last, *loading)) for name, loading in loadings.items()}
    why = (
        f"at {60 * last:.0f} % of strain the micro knit carries {middle['micro'] / middle['macro']:.1f} times its "
        "twin: its outer layers are fixed in plates, and fused points hold its loops"
    )
    return judged(error <= 0.25, ours, {"NRMSE": error}, why)


def fused_points(runs: Mapping[str, Analysed]) -> Score:
    """Score micro over macro secant up to half of the strain at which most fused points break: above 1; that strain: 1.

    The strain is the middle of the fullest of 40 bins, and 1 within 25 %.
    """
    bonds = runs["fig5 micro"].tables("bonds").columns
    broken = np.asarray(bonds["broken"], dtype=np.float64)
    if not broken.size or not broken.any():
        raise UnscorableError("no fused point broke")
    edges = np.asarray(bonds["from strain"], dtype=np.float64), np.asarray(bonds["to strain"], dtype=np.float64)
    middles = 0.5 * (edges[0] + edges[1])
    peak, mean = float(middles[int(np.argmax(broken))]), float(np.average(middles, weights=broken))
    half = 0.5 * peak
    early = {name: float(np.interp(half, *_by_modulus(runs[f"fig5 {name}"])[:2])) for name in ("micro", "macro")}
    ratio = early["micro"] / early["macro"] if early["macro"] > 0.0 else float("nan")
    first, last = float(edges[0][broken > 0.0].min()), float(edges[1][broken > 0.0].max())
    ours = (
        f"at first {ratio:.1f} times as stiff (to {100 * half:.0f} %); {broken.sum():.0f} points break from "
        f"{100 * first:.0f} to {100 * last:.0f} %, most at {100 * peak:.0f} %, on average at {100 * mean:.0f} %"
    )
    why = (
        f"necks break one by one as their loops straighten; their strength and size are not published, and the knit's "
        f"force is largest at {100 * _strain_at_top(runs['fig5 micro']):.0f} %"
    )
    return judged(ratio > 1.0 and is_near(peak, 1.0), ours, {"early ratio": ratio, "peak of breaks": peak}, why)


def _strain_at_top(run: Analysed) -> float:
    strain, _, top = _by_modulus(run)
    return float(strain[top])


def same_strength(runs: Mapping[str, Analysed]) -> Score:
    """Score micro over macro of the slope of σ/E before the largest force and of the largest σ/E: 1 within 25 %.

    The slope is a regression over 0.7 to 0.95 of the strain at the largest force.
    """
    slopes, tops = {}, {}
    for name in ("micro", "macro"):
        strain, over, top = _by_modulus(runs[f"fig5 {name}"])
        rising = np.maximum.accumulate(strain[: top + 1])
        at = float(strain[top])
        slopes[name] = segment_modulus(rising, over[: top + 1], SLOPE[0] * at, SLOPE[1] * at).slope
        tops[name] = float(over[top])
    values = {"slope": slopes["micro"] / slopes["macro"], "strength": tops["micro"] / tops["macro"]}
    ours = f"slope {values['slope']:.2f}, strength {values['strength']:.2f} (micro over macro, by modulus)"
    why = (
        f"slopes of σ/E are {slopes['micro']:.1e} and {slopes['macro']:.1e}, largest σ/E {tops['micro']:.1e} and "
        f"{tops['macro']:.1e}; both knits have as many loops, other fixtures and other yield curves"
    )
    return judged(all(is_near(value, 1.0) for value in values.values()), ours, values, why)
