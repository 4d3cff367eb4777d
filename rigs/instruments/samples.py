"""What an instrument logged."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Protocol

import numpy as np

from rigs.instruments.signals import true_times
from rigs.instruments.ticks import PART

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import numpy.typing as npt

    from rigs.axes import FloatArray, IntArray
    from rigs.record import Phase


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """Samples that an instrument logged, with noise and without.

    Attributes
    ----------
    instrument : str
        Name of the instrument.
    time : FloatArray, shape (n,)
        Stamps of the instrument's own clock [s].
    measured, clean : dict of str to FloatArray, shape (n,)
        Values by the channel's name, in its SI unit.
    offset : dict of str to FloatArray, shape (n,)
        What zeroing took off ``measured``.
    units : dict of str to str
        The units of both.
    reads : dict of str to str
        Column of the equilibria that each channel reads.
    cycle : IntArray, shape (n,)
        Counter of the set at every sample.
    phase : tuple of Phase
        Phase at every sample.
    tag : tuple of (str or None)
        Label at every sample.
    overloads : tuple of str
        Names of the channels that were saturated at least once.
    clock_offset, clock_skew : float
        What the instrument's clock shows at the start of the rig's [s], and how much faster it runs [1].
    delay : dict of str to float
        How long after the stamp the channels were read that are read late [s].
    jumps : FloatArray, shape (k,)
        When the specimen jumped, on the rig's clock [s].
    """

    instrument: str
    time: FloatArray
    measured: dict[str, FloatArray]
    clean: dict[str, FloatArray]
    offset: dict[str, FloatArray]
    units: dict[str, str]
    reads: dict[str, str]
    cycle: IntArray
    phase: tuple[Phase, ...]
    tag: tuple[str | None, ...]
    overloads: tuple[str, ...]
    clock_offset: float = 0.0
    clock_skew: float = 0.0
    delay: dict[str, float] = field(default_factory=dict)
    jumps: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time)

    def part(self, first: int, last: int) -> Samples:
        """Return the samples from the first on and before the last."""
        return self.chosen(slice(first, last))

    def find(self, stamp: float) -> int:
        """Return the number of the first sample that is not stamped before a stamp [s]."""
        return int(np.searchsorted(self.time, stamp))

    def chosen(self, rows: slice | IntArray) -> Samples:
        """Return some of the samples."""
        return replace(
            self,
            time=self.time[rows],
            measured={name: values[rows] for name, values in self.measured.items()},
            clean={name: values[rows] for name, values in self.clean.items()},
            offset={name: values[rows] for name, values in self.offset.items()},
            cycle=self.cycle[rows],
            phase=self.phase[rows] if isinstance(rows, slice) else tuple(self.phase[k] for k in rows),
            tag=self.tag[rows] if isinstance(rows, slice) else tuple(self.tag[k] for k in rows),
        )

    @property
    def true_time(self) -> FloatArray:
        """Return the stamps as times on the rig's clock [s], shape (n,)."""
        return true_times(self.time, self.clock_offset, self.clock_skew)


class Table(Protocol):
    """A log that is read part by part: `Samples`, or the record of them."""

    def __len__(self) -> int:
        """Return the number of samples."""

    def part(self, first: int, last: int) -> Samples:
        """Return the samples from the first on and before the last."""

    def find(self, stamp: float) -> int:
        """Return the number of the first sample that is not stamped before a stamp [s]."""


def parts_of(table: Table, most: int = PART) -> Iterator[Samples]:
    """Yield a log part by part, at most so many samples at a time."""
    for first in range(0, len(table), most):
        yield table.part(first, min(first + most, len(table)))


def around(table: Table, first: float, last: float) -> Samples:
    """Return the samples between two stamps [s], with two beyond either."""
    return table.part(max(table.find(first) - 2, 0), min(table.find(last) + 3, len(table)))


def thinned(table: Table, most: int) -> Samples:
    """Return a log for show: whole, or of some samples that follow each other those with the extremes of each channel.

    Kept are also the first and the last of them, and those between which cycle, phase, label or zero changes.
    """
    if len(table) <= most:
        return table.part(0, len(table))
    kinds = len(table.part(0, 1).measured)
    width = -(-len(table) * (2 * kinds + 2) // most)
    bins = max(1, PART // width)
    return merged([part.chosen(_telling(part, width)) for part in parts_of(table, bins * width)])


def _telling(part: Samples, width: int) -> IntArray:
    """Return the rows of a part that its curve needs, bin by bin of a width."""
    changes = np.flatnonzero(_changes(part))
    kept = [changes, changes + 1]
    for low in range(0, len(part), width):
        high = min(low + width, len(part))
        kept.append(np.array([low, high - 1]))
        for values in part.measured.values():
            some = values[low:high]
            kept.append(low + np.array([np.argmin(some), np.argmax(some)]))
    return np.unique(np.concatenate(kept)).astype(np.int64)


def _changes(part: Samples) -> npt.NDArray[np.bool_]:
    """Return for every row but the last whether something other than a reading changes after it."""
    found: npt.NDArray[np.bool_] = np.diff(part.cycle) != 0
    for offset in part.offset.values():
        found |= np.diff(offset) != 0.0
    labels = pairwise(zip(part.phase, part.tag, strict=True))
    found |= np.fromiter((a != b for a, b in labels), dtype=np.bool_, count=len(found))
    return found


def merged(parts: Sequence[Samples]) -> Samples:
    """Return parts of a log as one."""

    def whole(kind: str) -> dict[str, FloatArray]:
        names = getattr(parts[0], kind)
        return {name: np.concatenate([getattr(part, kind)[name] for part in parts]) for name in names}

    return replace(
        parts[0],
        time=np.concatenate([part.time for part in parts]),
        measured=whole("measured"),
        clean=whole("clean"),
        offset=whole("offset"),
        cycle=np.concatenate([part.cycle for part in parts]),
        phase=tuple(chain.from_iterable(part.phase for part in parts)),
        tag=tuple(chain.from_iterable(part.tag for part in parts)),
        overloads=tuple(dict.fromkeys(chain.from_iterable(part.overloads for part in parts))),
    )
