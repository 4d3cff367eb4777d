"""Tests beside each other: repeats as bands, and scores against one of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from knitlab_core.errors import SpecificationError
from rigs.analysis.figures import RETURNED, Figure, figures_table
from rigs.analysis.repeatability import Band, band_of, common_range, nrmse, read_at
from rigs.analysis.work import cycle_work, is_closed, loop_area

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigs.analysis.alignment import Aligned
    from rigs.analysis.table import Table
    from rigs.axes import FloatArray

Across: TypeAlias = Literal["strain", "travel"]
Along: TypeAlias = Literal["stress", "force"]

SECANTS: Final = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5)
"""Strains to which secants run; those of travel end at quarters of what all tests cover."""


SLOPE_UNITS: Final[Mapping[tuple[Across, Along], str]] = {
    ("strain", "stress"): "Pa",
    ("strain", "force"): "N",
    ("travel", "stress"): "Pa/m",
    ("travel", "force"): "N/m",
}
WORK_UNITS: Final[Mapping[tuple[Across, Along], str]] = {
    ("strain", "stress"): "J/m3",
    ("strain", "force"): "J/m",
    ("travel", "stress"): "J/m2",
    ("travel", "force"): "J",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Repeats of one test: of a run, or in the files of an instrument.

    Attributes
    ----------
    name, axis : str
        What it is of, and along which axis.
    tests : sequence of Aligned
        The repeats.
    measured : bool
        Whether an instrument measured it.
    """

    name: str
    axis: str
    tests: Sequence[Aligned]
    measured: bool

    def curves(self, across: Across, along: Along) -> list[tuple[FloatArray, FloatArray]]:
        """Return the loadings of the repeats, as x and y."""
        return [(getattr(one.loading, across), getattr(one.loading, along)) for one in self.tests]

    def band(self, across: Across, along: Along) -> Band:
        """Return the repeats at common x.

        Raises
        ------
        SpecificationError
            If they have no x in common.
        """
        found = band_of(self.curves(across, along))
        if found is None:
            raise SpecificationError(across, f"none in common in {self.name}", "repeats of one range")
        return found


def quantities(groups: Sequence[Group]) -> tuple[Across, Along]:
    """Return what is compared over what: stress over strain where every test has them, else force, or over travel."""
    tests = [one.loading for group in groups for one in group.tests]
    across: Across = "strain" if all(np.isfinite(one.strain).any() for one in tests) else "travel"
    along: Along = "stress" if all(np.isfinite(one.stress).any() for one in tests) else "force"
    return across, along


def reference_of(groups: Sequence[Group], axis: str) -> Group:
    """Return what the others of an axis are measured by: the first that was measured, or else the first."""
    here = [group for group in groups if group.axis == axis]
    return next((group for group in here if group.measured), here[0])


def comparison_table(groups: Sequence[Group], across: Across, along: Along) -> Table:
    """Return the scores of groups along each of their axes.

    NRMSE and the share inside the band are those of a group's mean curve against the reference's, over the x that both
    cover. Secants, works and loops are means over the repeats, with the least and the largest as `low` and `high`. A
    secant runs from where a loading sets out to a strain.
    """
    found: list[Figure] = []
    for axis in dict.fromkeys(group.axis for group in groups):
        here = [group for group in groups if group.axis == axis]
        reference = reference_of(groups, axis)
        at = common_range([curve for group in here for curve in group.curves(across, along)])
        if not len(at):
            raise SpecificationError(
                across, f"none that all tests along {axis or 'the axis'} cover", "tests of one range"
            )
        for group in here:
            found += _scores(group, reference, at, across, along)
    return figures_table("comparison", found)


def _scores(group: Group, reference: Group, at: FloatArray, across: Across, along: Along) -> Iterator[Figure]:
    curves = group.curves(across, along)
    cycle = int(group.tests[0].test.cycle[0])
    values: dict[str, tuple[Sequence[float], str]] = {
        "Repeats": ([float(len(curves))], "1"),
        "Slack taken off": ([one.slack for one in group.tests], "m"),
        "Force taken off": ([one.offset for one in group.tests], "N"),
        "Direction reversed": ([float(one.reversed_force or one.reversed_travel) for one in group.tests], "1"),
    }
    if group is not reference:
        values |= _differences(group.band(across, along), reference.band(across, along))
    for end in secant_ends(at, across):
        name, unit = _secant_name(end, across, along)
        values[name] = ([secant(x, y, end) for x, y in curves], unit)
    work = WORK_UNITS[across, along]
    last = f"{100 * at[-1]:.3g} %" if across == "strain" else f"{1e3 * at[-1]:.3g} mm"
    values[f"Energy of loading to {last}"] = ([work_to(x, y, float(at[-1])) for x, y in curves], work)
    loops = [_loop(one, across, along) for one in group.tests]
    values["Loop area"] = ([loop for loop, _ in loops], work)
    values["Hysteresis ratio"] = ([share for _, share in loops], "1")
    for name, (each, unit) in values.items():
        low, high = (float(np.min(each)), float(np.max(each))) if len(each) > 1 else (float("nan"),) * 2
        yield Figure(
            name=group.name,
            axis=group.axis,
            cycle=cycle,
            figure=name,
            value=float(np.mean(each)),
            unit=unit,
            low=low,
            high=high,
        )


def _differences(band: Band, reference: Band) -> dict[str, tuple[Sequence[float], str]]:
    """Return how far a mean curve is from the reference's, and how much of it is within the reference's band."""
    at = common_range([(band.x, band.mean), (reference.x, reference.mean)])
    mean, wanted = read_at(band.x, band.mean, at), read_at(reference.x, reference.mean, at)
    low, high = (read_at(reference.x, edge, at) for edge in (reference.low, reference.high))
    found: dict[str, tuple[Sequence[float], str]] = {"NRMSE": ([nrmse(wanted, mean)], "1")}
    if reference.repeats > 1:
        found["Share inside the band"] = ([float(np.mean((mean >= low) & (mean <= high)))], "1")
    return found


def secant_ends(at: FloatArray, across: Across) -> list[float]:
    """Return the x to which secants run, within what all tests cover (m,)."""
    if across == "strain":
        return [end for end in SECANTS if at[0] < end <= at[-1] * (1.0 + 1e-9)]
    return [float(at[0] + share * (at[-1] - at[0])) for share in (0.25, 0.5, 0.75, 1.0)]


def _secant_name(end: float, across: Across, along: Along) -> tuple[str, str]:
    """Return name and unit of a secant."""
    where = f"0 % - {100 * end:g} %" if across == "strain" else f"0 mm - {1e3 * end:.3g} mm"
    return f"{'Modulus' if along == 'stress' else 'Stiffness'} (secant {where})", SLOPE_UNITS[across, along]


def secant(x: FloatArray, y: FloatArray, end: float) -> float:
    """Return the slope from where a loading begins, or from x = 0 where it begins before, to an x."""
    start = max(0.0, float(np.nanmin(x)))
    low, high = read_at(x, y, np.array([start, end]))
    return float((high - low) / (end - start)) if end > start else float("nan")


def work_to(x: FloatArray, y: FloatArray, end: float) -> float:
    """Return ∫ y dx of a loading from where it begins to an x, by the trapezium rule on `READINGS` places."""
    start = max(0.0, float(np.nanmin(x)))
    at = np.linspace(start, end, 401)
    return float(np.trapezoid(read_at(x, y, at), at))


def _loop(one: Aligned, across: Across, along: Along) -> tuple[float, float]:
    """Return the area of a cycle's loop and its share of the loading's work; nan of one that did not come back."""
    x, y = getattr(one.test, across), getattr(one.test, along)
    if not is_closed(x, RETURNED if one.test.sampled else 1e-3):
        return float("nan"), float("nan")
    area = loop_area(x, y)
    work = cycle_work(getattr(one.loading, across), getattr(one.loading, along))
    return area, area / work if work > 0.0 else float("nan")


def by_axis(groups: Sequence[Group]) -> Mapping[str, list[Group]]:
    """Return the groups of each axis, in their order."""
    return {axis: [one for one in groups if one.axis == axis] for axis in dict.fromkeys(one.axis for one in groups)}
