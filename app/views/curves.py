"""Data of a run's plots: curves part by part, logged samples, marks, and units that fit."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from app.records.measurements import zeroings_of
from knitlab_core.errors import SpecificationError
from rigs.analysis.stress_strain import stress_strain
from rigs.instruments.pchip import Pchip
from rigs.instruments.zeros import size_in_time, zeroed
from rigs.jumps import parted
from rigs.protocol.unrolled import unrolled

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from app.records.reader import RunReader
    from rigs.analysis.material_limits import LimitCrossing
    from rigs.axes import Axis, FloatArray
    from rigs.instruments.zeros import Zeroing
    from rigs.protocol.protocol import Protocol
    from rigs.record import Phase, SpecimenSize
    from rigs.trace import Trace

#: What an axis does in a part of its curve; `held` and `free` while another axis is driven.
Role: TypeAlias = Literal["loading", "unloading", "hold", "held", "free"]

ROLES: tuple[Role, ...] = ("loading", "unloading", "hold", "held", "free")

_PHASE_ROLES: Mapping[Phase, Role] = {
    "Stretch": "loading",
    "Preload": "loading",
    "Recover": "unloading",
    "Hold": "hold",
    "Zero": "hold",
}

#: Points that a curve has between two equilibria.
PER_ROW = 8

#: Change of strain, and of stress as a share of it, that is none on a plot [1].
STILL = 1e-4

PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """A part of a curve in which an axis has one role.

    Attributes
    ----------
    role : Role
        What it does.
    cycle : int
        Counter of the set, from 1.
    time, strain, stress, force : FloatArray, shape (n,)
        [s], effective strain [1] and stress [Pa], and force [N], zeroed as the test asked for; n is 2 or more.
    """

    role: Role
    cycle: int
    time: FloatArray
    strain: FloatArray
    stress: FloatArray
    force: FloatArray

    @property
    def still(self) -> bool:
        """Return whether strain and stress are constant, so that the part is drawn as one point."""
        return bool(np.ptp(self.strain) < STILL and np.ptp(self.stress) <= STILL * np.abs(self.stress).max())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Log:
    """Logged samples of an axis with noise; nan separates parts where a channel was zeroed.

    Attributes
    ----------
    time, strain, stress, force : FloatArray, shape (n,)
        As in `Part`.
    """

    time: FloatArray
    strain: FloatArray
    stress: FloatArray
    force: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mark:
    """Point of a curve at which a limit of the material was passed.

    Attributes
    ----------
    crossing : LimitCrossing
        Which limit, and when.
    time, strain, stress, force : float
        As in `Part`.
    """

    crossing: LimitCrossing
    time: float
    strain: float
    stress: float
    force: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """What is drawn of one axis.

    Attributes
    ----------
    axis : Axis
        The axis.
    parts : sequence of Part
        The whole test without noise, from the equilibria, in the order of time.
    log : Log or None
        What the instrument logged; None if that is the same, or the run was cut off before.
    marks : sequence of Mark
        Where limits of the material were passed.
    """

    axis: Axis
    parts: Sequence[Part]
    log: Log | None
    marks: Sequence[Mark]

    @property
    def cycles(self) -> tuple[int, ...]:
        """Return the counters of the sets in which the axis is loaded or unloaded."""
        return tuple(sorted({part.cycle for part in self.parts if part.role in {"loading", "unloading"}}))

    @property
    def roles(self) -> tuple[Role, ...]:
        """Return the roles of the axis in this test."""
        return tuple(role for role in ROLES if any(part.role == role for part in self.parts))


def curves_of(run: RunReader) -> tuple[Curve, ...]:
    """Return the curve of every axis of the record.

    Raises
    ------
    SpecificationError
        If the run has no row.
    """
    if not len(run.trace):
        raise SpecificationError("run.equilibria", 0, "at least one row to plot")
    zeroings = zeroings_of(run)
    trace = parted(run.trace)
    curves = []
    for axis in trace.axes:
        rows, found = _values(run.trace, axis, run.size, zeroings), _values(trace, axis, run.size, zeroings)
        curves.append(
            Curve(
                axis=axis,
                parts=tuple(_parts(trace, found, _roles(run.test, axis))),
                log=_log_of(run, axis, zeroings),
                marks=tuple(_mark(crossing, rows[:, crossing.row]) for crossing in run.crossings),
            )
        )
    return tuple(curves)


def _values(trace: Trace, axis: Axis, size: SpecimenSize, zeroings: Sequence[Zeroing]) -> FloatArray:
    """Return time [s], strain [1], stress [Pa] and force [N] of an axis, (4, n), counted from its zeroings."""
    time = trace.columns["time"]
    travel = zeroed(trace.columns[f"crosshead_{axis}"], time, "displacement", zeroings)
    force = zeroed(trace.columns[f"force_{axis}"], time, "force", zeroings)
    strain, stress = stress_strain(travel, force, axis, size_in_time(time, size, zeroings))
    return np.stack([time, strain, stress, force])


def _mark(crossing: LimitCrossing, values: FloatArray) -> Mark:
    time, strain, stress, force = map(float, values)
    return Mark(crossing=crossing, time=time, strain=strain, stress=stress, force=force)


def _roles(protocol: Protocol, axis: Axis) -> dict[int, Role]:
    """Return the role of an axis in the steps that drive others, by the number of the step."""
    beside: Role | None = {"hold": "held", "free": "free"}.get(protocol.others)  # type: ignore[assignment]
    return {
        leaf.number: beside
        for leaf in unrolled(protocol.steps)
        if beside is not None and leaf.step.moves and axis not in leaf.step.axes
    }


def _parts(trace: Trace, values: FloatArray, beside: Mapping[int, Role]) -> Iterator[Part]:
    """Yield the parts of a curve, each from the row it starts at.

    Zeroing takes no time and moves nothing: no line is drawn across it.
    """
    keys = list(zip(trace.columns["step"], trace.columns["cycle"], trace.phase, strict=True))
    begins = [row for row in range(1, len(keys)) if keys[row] != keys[row - 1]]
    for first, end in pairwise([0, *begins, len(keys)]):
        step, cycle, phase = keys[first]
        rows = values[:, max(first - 1, 0) : end]
        if phase == "Zero" or rows.shape[1] < 2:
            continue
        role = _PHASE_ROLES[phase] if phase == "Hold" else beside.get(int(step), _PHASE_ROLES[phase])
        time, strain, stress, force = _smooth(rows)
        yield Part(role=role, cycle=int(cycle), time=time, strain=strain, stress=stress, force=force)


def _smooth(rows: FloatArray) -> FloatArray:
    """Interpolate rows (k, n) by the shape-preserving cubic of the instruments; the first row holds times.

    Rows at one time are a jump, and are joined by a straight line.
    """
    jumps = np.flatnonzero(np.diff(rows[0]) <= 0.0) + 1
    pieces = []
    for piece in np.split(rows, jumps, axis=1):
        count = piece.shape[1]
        if count > 2:
            at = np.interp(np.arange((count - 1) * PER_ROW + 1) / PER_ROW, np.arange(count), piece[0])
            piece = np.concatenate([at[None], Pchip.through(piece[0], piece[1:].T)(at).T])  # noqa: PLW2901
        pieces.append(piece)
    return np.concatenate(pieces, axis=1)


def _log_of(run: RunReader, axis: Axis, zeroings: Sequence[Zeroing]) -> Log | None:
    """Return the logged samples of an axis; None where they equal those without flaw."""
    logged = next((log for log in run.samples.values() if f"force_{axis}" in log.reads.values()), None)
    if logged is None:
        return None
    channel = {column: name for name, column in logged.reads.items()}
    names = [channel[f"{column}_{axis}"] for column in ("crosshead", "force")]
    if all(np.array_equal(logged.measured[name], logged.clean[name]) for name in names):
        return None
    travel, force = (logged.measured[name].copy() for name in names)
    for values, name in zip((travel, force), names, strict=True):
        values[1:][np.diff(logged.offset[name]) != 0.0] = np.nan
    time = logged.true_time
    strain, stress = stress_strain(travel, force, axis, size_in_time(time, run.size, zeroings))
    return Log(time=time, strain=strain, stress=stress, force=force)


def prefixed(largest: float, *, least: float = 1.0) -> tuple[float, str]:
    """Return the SI prefix that suits values up to a size, as the factor to multiply them by and its letter.

    Parameters
    ----------
    largest : float
        The largest value, in the SI unit.
    least : float
        The smallest that `largest` may become [1]: 0.1 writes 300 µN as 0.3 mN.

    Examples
    --------
    >>> prefixed(11.3e3)
    (0.001, 'k')
    >>> prefixed(3e-4, least=0.1)
    (1000.0, 'm')
    """
    size, letter = next((one for one in PREFIXES if abs(largest) >= least * one[0]), PREFIXES[-1])
    return (1.0, "") if largest == 0.0 else (1.0 / size, letter)


def stress_unit(parts: Sequence[FloatArray]) -> tuple[float, str]:
    """Return the factor and the unit that suit stresses [Pa]."""
    factor, letter = prefixed(_largest(parts))
    return factor, f"{letter}Pa"


def force_unit(parts: Sequence[FloatArray]) -> tuple[float, str]:
    """Return the factor and the unit that suit forces [N]."""
    factor, letter = prefixed(_largest(parts), least=0.1)
    return factor, f"{letter}N"


def _largest(parts: Sequence[FloatArray]) -> float:
    return max((float(np.nanmax(np.abs(part))) for part in parts if len(part)), default=0.0)
