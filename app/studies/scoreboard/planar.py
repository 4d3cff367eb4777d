"""Scores of the rows of the planar specimen: Figs. 3a, 3b and 3d, the uniaxial test, the hooks."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from app.studies.scoreboard.analysed import UnscorableError
from app.studies.scoreboard.plan import POLE
from app.studies.scoreboard.verdict import Score, is_near, judged, percent_off
from rigs.analysis.curve_tables import from_toe
from rigs.analysis.fits import exponential_fit, exponential_or_kinked
from rigs.analysis.moduli import stress_at
from rigs.analysis.onset import half_rise, toe
from rigs.analysis.ranks import rank_correlation
from rigs.analysis.repeatability import curve_nrmse
from rigs.analysis.work import summed_hysteresis

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.studies.scoreboard.analysed import Analysed

RATE: Final = 16.50
LATE: Final = (0.3, 0.4)
"""Window beyond the slack of both axes, which is told where β differs [1]."""

SECANTS: Final = {"course": (15e3, 166e3), "wale": (21e3, 190e3)}
LOOPS: Final = {"course": (0.39e3, 6.9e3), "wale": (0.43e3, 4.6e3)}
"""The paper's numbers without pre-strain and at 0.4 [Pa], [J/m³]."""

AXES: Final = {"C": "course", "W": "wale"}
ALONG: Final = {"course": "C", "wale": "W"}


def exponential(runs: Mapping[str, Analysed]) -> Score:
    """Score β of the first loading: within 25 % along both axes, R² of ln σ 0.95 or more."""
    values: dict[str, float] = {}
    words, kinked = [], []
    for axis, name in AXES.items():
        strain, stress = runs["fig3a"].loading(axis)
        first, last = from_toe(strain, stress)
        fit, shape = (
            exponential_fit(strain, stress, first, last),
            exponential_or_kinked(strain, stress, first, last),
        )
        values |= {f"beta {axis}": fit.rate, f"R2 {axis}": fit.r2}
        words.append(
            f"{name} β = {fit.rate:.1f} ({fit.rate_low:.1f} to {fit.rate_high:.1f}), R² {fit.r2:.3f}, "
            f"{100 * first:.0f} to {100 * last:.0f} %"
        )
        if shape.weight < 0.5:
            kinked.append(f"{name} with a kink at {100 * shape.kink:.0f} %")
    good = all(is_near(values[f"beta {axis}"], RATE) and values[f"R2 {axis}"] >= 0.95 for axis in AXES)
    ours = "; ".join(words)
    if kinked:
        ours += f"; a line with a kink fits σ better: {', '.join(kinked)}"
    off = ", ".join(f"{name} {percent_off(values[f'beta {axis}'], RATE)}" for axis, name in AXES.items())
    late = {axis: exponential_fit(*runs["fig3a"].loading(axis), *LATE).rate for axis in AXES}
    why = (
        f"β is off by {off}; the curves are a slack part and a stiff one: over {100 * LATE[0]:.0f} to "
        f"{100 * LATE[1]:.0f} % alone β is {late['C']:.1f} (C), {late['W']:.1f} (W)"
    )
    return judged(good, ours, values, why)


def anisotropy(runs: Mapping[str, Analysed]) -> Score:
    """Score σ_W / σ_C of the first equibiaxial loading: above 1 at 20, 30 and 40 % of strain."""
    course, wale = runs["fig3a"].loading("C"), runs["fig3a"].loading("W")
    levels = (0.2, 0.3, 0.4)
    ratios = {f"{at:.0%}": stress_at(*wale, at) / stress_at(*course, at) for at in levels}
    ours = ", ".join(f"{value:.2f} at {name}" for name, value in ratios.items())
    slack = {axis: toe(strain, stress, stress[-1]) for axis, (strain, stress) in (("C", course), ("W", wale))}
    rise = {axis: stress[-1] / (strain[-1] - slack[axis]) for axis, (strain, stress) in (("C", course), ("W", wale))}
    why = (
        f"the wale is slack for longer, for rows are printed apart: it has a twentieth of its largest stress at "
        f"{100 * slack['W']:.0f} %, the course at {100 * slack['C']:.0f} %; from there to the end its secant is "
        f"{rise['W'] / rise['C']:.2f} times the course's"
    )
    return judged(all(value > 1.0 for value in ratios.values()), ours, ratios, why)


def first_loading(runs: Mapping[str, Analysed]) -> Score:
    """Score the work of the first loading over that of the second: above 1.05 along both axes."""
    values = {}
    for axis in AXES:
        works = [one.loading_work for one in runs["fig3a"].cycles(axis)]
        values[f"W1/W2 {axis}"] = works[0] / works[1]
    ours = ", ".join(f"{name} {values[f'W1/W2 {axis}']:.2f}" for axis, name in AXES.items())
    return judged(all(value > 1.05 for value in values.values()), ours, values, "the later loadings are not softer")


def later_cycles(runs: Mapping[str, Analysed]) -> Score:
    """Score the NRMSE of loadings 2, 3 and 4, two by two: 2 % at most."""
    values = {}
    for axis in AXES:
        found = [runs["fig3a"].loading(axis, cycle) for cycle in (2, 3, 4)]
        pairs = ((found[0], found[1]), (found[0], found[2]), (found[1], found[2]))
        values[axis] = max(curve_nrmse(one, other) for one, other in pairs)
    ours = ", ".join(f"{name} {100 * values[axis]:.1f} % at most" for axis, name in AXES.items())
    peaks = {axis: [one.stress[0.4] for one in runs["fig3a"].cycles(axis)] for axis in AXES}
    drops = ", ".join(
        f"{name} {' '.join(f'{100 * (b / a - 1):+.1f} %' for a, b in pairwise(peaks[axis][1:]))}"
        for axis, name in AXES.items()
    )
    why = f"the resin goes on relaxing: peak stress changes from cycle to cycle by {drops}"
    return judged(all(value <= 0.02 for value in values.values()), ours, values, why)


def hysteresis(runs: Mapping[str, Analysed]) -> Score:
    """Score the loop over the work of loading, of both axes together: 5 % or more; without friction 0.5 % at most."""
    shares = {}
    for name in ("fig3a", "control"):
        cycles = [runs[name].cycles(axis)[0] for axis in AXES]
        shares[name] = summed_hysteresis([one.loop_area for one in cycles], [one.loading_work for one in cycles])
    ours = (
        f"{100 * shares['fig3a']:.0f} % of the first loading's work is lost; without friction, relaxation and yield "
        f"{100 * shares['control']:.2f} %"
    )
    good = shares["fig3a"] >= 0.05 and abs(shares["control"]) <= 0.005
    return judged(good, ours, shares, "the control keeps some, or the specimen loses none")


def sequence(runs: Mapping[str, Analysed]) -> Score:
    """Score the order of half rises along the first loading: contacts, bending, axial stretch; legs more upright."""
    run = runs["fig3a"]
    strain, bend, stretch, stored = run.rows_of(
        "energy", "strain C", "elastic_bend of stored", "elastic_stretch of stored", "stored energy"
    )
    stored = np.nan_to_num(stored)
    at, contacts = run.rows_of("contacts", "strain C", "contacts")
    shapes, angle, straight = run.rows_of("shapes", "strain C", "median leg angle", "median leg straightness")
    values = {
        "contacts": half_rise(at, contacts),
        "bending": half_rise(strain, np.nan_to_num(bend) * stored),
        "stretch": half_rise(strain, np.nan_to_num(stretch) * stored),
        "angle at rest": float(angle[0]),
        "angle at end": float(angle[-1]),
    }
    ours = (
        f"half of its rise is reached by contacts at {100 * values['contacts']:.0f} %, bending energy at "
        f"{100 * values['bending']:.0f} %, stretch energy at {100 * values['stretch']:.0f} %; leg angle "
        f"{angle[0]:.0f}° to {angle[-1]:.0f}°, straightness {straight[0]:.2f} to {straight[-1]:.2f} "
        f"at {100 * shapes[-1]:.0f} %"
    )
    order = values["contacts"] < values["bending"] < values["stretch"]
    upright = abs(values["angle at end"]) < abs(values["angle at rest"]) and straight[-1] > straight[0]
    why = "legs do not get more upright" if order else "the half rises have another order"
    return judged(order and upright, ours, values, why)


def uniaxial(runs: Mapping[str, Analysed]) -> Score:
    """Score ν above 0 at the end, and ΔL/L of the yarn at most a fifth of the equibiaxial test's at that strain."""
    values: dict[str, float] = {}
    strain, both = runs["fig3a"].rows_of("shapes", "strain C", "yarn elongation")
    biaxial = float(np.interp(0.4, strain, both))
    for axis in AXES:
        along, ratio, grown = runs[f"uniaxial {axis}"].rows_of(
            "shapes", f"strain {axis}", f"Poisson's ratio of {axis}", "yarn elongation"
        )
        if along[-1] < 0.399:
            raise UnscorableError(f"uniaxial {axis} ended at {100 * along[-1]:.0f} %")
        values |= {f"nu {axis}": float(ratio[-1]), f"elongation {axis}": float(grown[-1])}
    ours = ", ".join(
        f"{name} ν = {values[f'nu {axis}']:.2f}, ΔL/L = {100 * values[f'elongation {axis}']:.3f} %"
        for axis, name in AXES.items()
    )
    contracts = all(values[f"nu {axis}"] > 0.0 for axis in AXES)
    kept = all(abs(values[f"elongation {axis}"]) <= 0.2 * biaxial for axis in AXES)
    why = "the sides do not contract" if not contracts else "the yarn stretches more than a fifth of that"
    return judged(contracts and kept, f"{ours}; equibiaxial {100 * biaxial:.3f} %, at 40 %", values, why)


def secants_course(runs: Mapping[str, Analysed]) -> Score:
    """Score the course's secants to 40 %, without and with pre-strain: within 25 %."""
    return _secants(runs, "course")


def secants_wale(runs: Mapping[str, Analysed]) -> Score:
    """Score the wale's secants to 40 %, without and with pre-strain: within 25 %."""
    return _secants(runs, "wale")


def loops_course(runs: Mapping[str, Analysed]) -> Score:
    """Score the course's loops, without and with pre-strain: within 25 %."""
    return _loops(runs, "course")


def loops_wale(runs: Mapping[str, Analysed]) -> Score:
    """Score the wale's loops, without and with pre-strain: within 25 %."""
    return _loops(runs, "wale")


def _secants(runs: Mapping[str, Analysed], along: str) -> Score:
    first = {pre: runs[f"fig3d {along} {pre:g}"].cycles(ALONG[along])[0] for pre in (0.0, 0.4)}
    values = {f"secant at {pre:g}": one.peak_secant for pre, one in first.items()}
    early = " and ".join(f"{one.initial_secant / 1e6:.3f}" for one in first.values())
    ours = f"{' → '.join(f'{value / 1e6:.3f}' for value in values.values())} MPa to 40 %; to 0.4 % {early} MPa"
    pairs = list(zip(values.values(), SECANTS[along], strict=True))
    off = ", ".join(percent_off(*pair) for pair in pairs)
    why = f"off by {off}; to 0.4 % {_slack_of(runs, along)}"
    return judged(all(is_near(*pair) for pair in pairs), f"{ours} ({off})", values, why)


def _loops(runs: Mapping[str, Analysed], along: str) -> Score:
    first = {pre: runs[f"fig3d {along} {pre:g}"].cycles(ALONG[along])[0] for pre in (0.0, 0.4)}
    values = {f"loop at {pre:g}": one.loop_area for pre, one in first.items()}
    pairs = list(zip(values.values(), LOOPS[along], strict=True))
    off = ", ".join(percent_off(*pair) for pair in pairs)
    ours = f"{' → '.join(f'{value / 1e6:.2e}' for value in values.values())} MPa ({off})"
    lost = " and ".join(f"{100 * one.hysteresis:.0f} %" for one in first.values())
    needed = " and ".join(
        f"{100 * paper / one.loading_work:.0f} %" for paper, one in zip(LOOPS[along], first.values(), strict=True)
    )
    why = f"{lost} of the loading's work is lost, the paper's loops would be {needed}; {_slack_of(runs, along)}"
    return judged(all(is_near(*pair) for pair in pairs), ours, values, why)


def _slack_of(runs: Mapping[str, Analysed], along: str) -> str:
    """Return how late a loading without pre-strain sets in, and its work beside that of a straight line, in words."""
    run = runs[f"fig3d {along} 0"]
    strain, stress = run.loading(ALONG[along])
    one = run.cycles(ALONG[along])[0]
    straight = 0.5 * float(stress[-1]) * float(strain[-1] - strain[0])
    at = 100 * toe(strain, stress, float(stress[-1]))
    return (
        f"without pre-strain the {along} is slack up to {at:.0f} % (5 % of its stress) and its loading does "
        f"{100 * one.loading_work / straight:.0f} % of the work of a straight line"
    )


def pre_strained(runs: Mapping[str, Analysed]) -> Score:
    """Score whether stiffness and loops rise with pre-strain, and the specimen returns and repeats.

    Rank correlations of secant and loop with the pre-strain are 1 along both axes; the toe of the second loading is at
    most 2 % of strain behind that of the first; loadings 2 and 3 differ by an NRMSE of 5 % at most.
    """
    values: dict[str, float] = {}
    later = []
    for along, axis in ALONG.items():
        pres = sorted(float(name.split()[-1]) for name in runs if name.startswith(f"fig3d {along} "))
        if len(pres) < 3:
            raise UnscorableError("fewer than three pre-strains were run")
        tests = [runs[f"fig3d {along} {pre:g}"] for pre in pres]
        first = [one.cycles(axis)[0] for one in tests]
        values[f"rank of secant {axis}"] = rank_correlation(pres, [one.peak_secant for one in first])
        values[f"rank of loop {axis}"] = rank_correlation(pres, [one.loop_area for one in first])
        residual, repeats = [], []
        for test in tests:
            branches = [test.loading(axis, cycle) for cycle in (1, 2, 3)]
            top = float(branches[0][1][-1])
            residual.append(toe(*branches[1], top) - toe(*branches[0], top))
            repeats.append(curve_nrmse(branches[1], branches[2]))
        values |= {f"residual {axis}": max(residual), f"NRMSE {axis}": max(repeats)}
        later.append(f"{along} {100 * max(residual):.1f} %")
    ranks = all(value > 0.999 for name, value in values.items() if name.startswith("rank"))
    returns = all(values[f"residual {axis}"] <= 0.02 for axis in AXES)
    repeats_too = all(values[f"NRMSE {axis}"] <= 0.05 for axis in AXES)
    ours = (
        f"rank correlations {', '.join(f'{v:.2f}' for n, v in values.items() if n.startswith('rank'))}; the second "
        f"loading sets in later by up to {', '.join(later)}; loadings 2 and 3 differ by "
        f"{100 * max(values[f'NRMSE {axis}'] for axis in AXES):.1f} % at most"
    )
    parts = ((ranks, "they do not all rise"), (returns, "it does not return to its start"), (repeats_too, "it drifts"))
    why = (
        f"{', '.join(text for good, text in parts if not good)}: what has yielded stays bent and is slack afterwards; "
        "the same yield makes the first loading stiffer (row 3)"
    )
    return judged(ranks and returns and repeats_too, ours, values, why)


def hooks(runs: Mapping[str, Analysed]) -> Score:
    """Score the largest lateral over axial force of a hook: 1 % at most on free poles; above 0 on others, as a control.

    Rows that carry less than a tenth of the largest force do not count.
    """
    values = {}
    for pole in (0.0, POLE):
        ratio, pull = runs[f"hooks {pole:g}"].rows_of("hooks", "lateral over axial", "axial force of a hook")
        values[f"pole friction {pole:g}"] = float(np.nanmax(ratio[pull >= 0.1 * np.nanmax(pull)]))
    free, rubbing = values.values()
    ours = (
        f"{free:.1e} on free poles, {rubbing:.2f} at a pole friction of {POLE:g}, over the mean pull of a side's hooks"
    )
    return judged(free <= 0.01 and rubbing > 0.0, ours, values, "hooks carry force along their poles")
