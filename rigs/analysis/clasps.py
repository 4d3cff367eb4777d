"""Which clasps of a knit let go during a test: where the yarn of a held loop has left the head that held it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from knitlab_core.knits import clasp_kind, clasp_place, parted_at

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    from rigs.axes import Axis
    from rigs.record import Equilibrium, SpecimenSize
    from rigs.trace import Trace

Holding: TypeAlias = "Mapping[str, npt.NDArray[np.bool_]]"

MOST_PLACES: Final = 12
"""Places of lost clasps that are named."""

COLUMN: Final = "clasps_"
"""How the columns of a trace begin that count the clasps that hold; what is joined follows, ``rows`` or ``layers``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ClaspLoss:
    """Row of a run at which fewer clasps held than at any row before.

    Attributes
    ----------
    joined : str
        What the clasps join: ``rows``, ``layers``, or a chained edge, ``bound_off`` or ``cast_on``.
    row : int
        Row of the equilibria, from 0.
    time : float
        Time of the row on the rig's clock [s].
    strain : Mapping
        Effective strain of the specimen along each driven axis [1].
    lost, held, mounted : int
        Clasps that let go at this row, that hold still, and that held before: as mounted, or as laid in.
    places : str
        Where, in words; empty where only their number is known. It is known of those that let go before the test.
    """

    joined: str
    row: int
    time: float
    strain: Mapping[Axis, float]
    lost: int
    held: int
    mounted: int
    places: str = ""

    def __str__(self) -> str:
        """Return one line for the user."""
        if self.places:
            count = "a clasp" if self.lost == 1 else f"{self.lost} clasps"
            return (
                f"{count} {clasp_kind(self.joined)} let go as the yarn relaxed: {self.places}; "
                f"{self.held} of {self.mounted} hold"
            )
        where = ", ".join(f"{axis} {100 * value:.1f} %" for axis, value in self.strain.items())
        count = "a clasp" if self.lost == 1 else f"{self.lost} clasps"
        return (
            f"{count} {clasp_kind(self.joined)} let go at {self.time:.4g} s, strain {where}: "
            f"{self.held} of {self.mounted} hold"
        )

    def data(self) -> dict[str, Any]:
        """Return the loss as plain data, SI units."""
        return {
            "joined": self.joined,
            "row": self.row,
            "time": self.time,
            "strain": {str(axis): value for axis, value in self.strain.items()},
            "lost": self.lost,
            "held": self.held,
            "mounted": self.mounted,
            "places": self.places,
            "text": str(self),
        }


def lost_as_mounted(laid: Holding, mounted: Holding) -> tuple[ClaspLoss, ...]:
    """Return the clasps that a knit lost before its test, as its yarn relaxed, with their places.

    Parameters
    ----------
    laid, mounted : Mapping of str to array
        Which clasps are found to hold as laid in and as mounted, by what is joined, as `clasps_hold` gives it. A coarse
        mesh may miss some of the knit as laid in; they are not lost.
    """
    found = []
    for joined, held in mounted.items():
        lost = [clasp_place(joined, tuple(map(int, index))) for index in np.argwhere(laid[joined] & ~held)]
        if lost:
            more = "" if len(lost) <= MOST_PLACES else f" and {len(lost) - MOST_PLACES} more"
            found.append(
                ClaspLoss(
                    joined=joined,
                    row=0,
                    time=0.0,
                    strain={},
                    lost=len(lost),
                    held=int(laid[joined].sum()) - len(lost),
                    mounted=int(laid[joined].sum()),
                    places=", ".join(lost[:MOST_PLACES]) + more,
                )
            )
    return tuple(found)


def unravelled(laid: Holding, now: Holding) -> str:
    """Return as a message which neighbouring rows or layers no clasp holds together any more; empty if all are held.

    Parameters
    ----------
    laid, now : Mapping of str to array
        Which clasps are found to hold as laid in and now. A mesh so coarse that some are missed as laid in says
        nothing.
    """
    where = parted_at(now) if all(held.all() for held in laid.values()) else ""
    left = ", ".join(f"{held.sum()} of {held.size} clasps {clasp_kind(joined)}" for joined, held in now.items())
    return where and f"the knit unravelled: nothing holds {where} together; {left} hold"


@dataclass(slots=True, kw_only=True)
class ClaspCount:
    """Count of the clasps that hold, row by row.

    Attributes
    ----------
    losses : list of ClaspLoss
        Those so far, in the order of time.
    """

    losses: list[ClaspLoss] = field(default_factory=list)
    _mounted: dict[str, int] = field(default_factory=dict)
    _least: dict[str, int] = field(default_factory=dict)

    def note(
        self, number: int, time: float, clasps: Mapping[str, int], strain: Mapping[Axis, float]
    ) -> tuple[ClaspLoss, ...]:
        """Take the clasps that hold at a row; return what let go. A row that is told again changes nothing."""
        found = []
        for joined, held in clasps.items():
            before = self._least.setdefault(joined, self._mounted.setdefault(joined, held))
            if held < before:
                self._least[joined] = held
                loss = ClaspLoss(
                    joined=joined,
                    row=number,
                    time=time,
                    strain=strain,
                    lost=before - held,
                    held=held,
                    mounted=self._mounted[joined],
                )
                found.append(loss)
        self.losses += found
        return tuple(found)

    def note_row(self, number: int, row: Equilibrium, strain: Mapping[Axis, float]) -> tuple[ClaspLoss, ...]:
        """Take a row of the equilibria, as `note` does, with the strains of the specimen there [1]."""
        return self.note(number, row.time, row.clasps, strain)


def clasps_of(trace: Trace) -> dict[str, np.ndarray]:
    """Return how many clasps hold at every row (n,), by what is joined; empty for knits whose clasps are unknown."""
    return {name.removeprefix(COLUMN): held for name, held in trace.columns.items() if name.startswith(COLUMN)}


def count_clasps(trace: Trace, size: SpecimenSize) -> ClaspCount:
    """Return the count of a run's clasps to its last row."""
    count, columns = ClaspCount(), clasps_of(trace)
    table = np.array(list(columns.values())).reshape(len(columns), len(trace))
    # Only rows that differ from the one before can be news.
    news = np.flatnonzero(np.any(np.diff(table, axis=1, prepend=-1) != 0, axis=0)) if columns else ()
    for row in map(int, news):
        strain = {axis: float(trace.columns[f"displacement_{axis}"][row]) / size.gauge(axis) for axis in trace.axes}
        held = {joined: int(column[row]) for joined, column in columns.items()}
        count.note(row, float(trace.columns["time"][row]), held, strain)
    return count
