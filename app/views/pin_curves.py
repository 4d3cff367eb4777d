"""Curves of an extensometer: strain between its pins over time, and stress over it along axes that were driven."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.records.measurements import zeroings_of
from rigs.analysis.stress_strain import stress_strain
from rigs.axes import DIRECTIONS
from rigs.instruments.zeros import pin_strain, size_in_time, zeroed

if TYPE_CHECKING:
    from app.records.reader import RunReader
    from rigs.axes import Axis, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PinCurve:
    """Curve of the two pins along an axis.

    Attributes
    ----------
    axis : Axis
        The axis.
    time, strain : FloatArray, shape (n,)
        [s], and strain between the pins, counted from the last zero of displacement [1].
    stress : FloatArray or None
        Stress of the axis at these times [Pa]; None where nothing drives it.
    """

    axis: Axis
    time: FloatArray
    strain: FloatArray
    stress: FloatArray | None


def pin_curves(run: RunReader) -> tuple[PinCurve, ...]:
    """Return the curve of every pair of pins of a run, from the equilibria; none without an extensometer."""
    columns, zeroings = run.trace.columns, zeroings_of(run)
    time = columns["time"]
    found = []
    for axis in DIRECTIONS:
        if f"pin_distance_{axis}" not in columns:
            continue
        stress = None
        if axis in run.trace.axes:
            travel = zeroed(columns[f"crosshead_{axis}"], time, "displacement", zeroings)
            force = zeroed(columns[f"force_{axis}"], time, "force", zeroings)
            _, stress = stress_strain(travel, force, axis, size_in_time(time, run.size, zeroings))
        strain = pin_strain(columns[f"pin_distance_{axis}"], time, zeroings)
        found.append(PinCurve(axis=axis, time=time, strain=strain, stress=stress))
    return tuple(found)
