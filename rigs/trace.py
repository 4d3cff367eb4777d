"""Trace of a run: its equilibria, column by column."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from rigs.axes import AXES
from rigs.record import units

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import Axis, FloatArray, IntArray
    from rigs.record import Equilibrium, Phase


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trace:
    """Equilibria of a run, column by column.

    Attributes
    ----------
    columns : dict of str to FloatArray, shape (n,)
        The numbers of every row, by the names of `Equilibrium.numbers`, in SI units.
    phase : tuple of Phase
        Phase of every row.
    tag : tuple of (str or None)
        Label of every row.
    """

    columns: dict[str, FloatArray]
    phase: tuple[Phase, ...]
    tag: tuple[str | None, ...]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.phase)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes that were driven."""
        return tuple(axis for axis in AXES if f"force_{axis}" in self.columns)

    def first(self, count: int) -> Trace:
        """Return the first rows."""
        columns = {name: column[:count] for name, column in self.columns.items()}
        return Trace(columns=columns, phase=self.phase[:count], tag=self.tag[:count])

    def followed_by(self, later: Trace) -> Trace:
        """Return these rows and later ones of the same run; either may have none."""
        if not len(self) or not len(later):
            return later if not len(self) else self
        columns = {name: np.concatenate([column, later.columns[name]]) for name, column in self.columns.items()}
        return Trace(columns=columns, phase=self.phase + later.phase, tag=self.tag + later.tag)

    def strokes(self) -> IntArray:
        """Count the strokes: rows of like cycle, phase and label that follow each other.

        Returns
        -------
        IntArray, shape (n,)
            Stroke of every row, from 0. A row belongs to the stroke that led to it.
        """
        labels = list(zip(self.columns["cycle"], self.phase, self.tag, strict=True))
        change = [a != b for a, b in pairwise(labels)]
        return np.cumsum([0, *change])[: len(labels)]


def trace_of(rows: Sequence[Equilibrium]) -> Trace:
    """Turn rows into columns.

    Parameters
    ----------
    rows : sequence of Equilibrium, length n
        Rows in the order of time.

    Returns
    -------
    Trace
        The same numbers, one array a column.
    """
    numbers = [row.numbers() for row in rows]
    names = numbers[0] if numbers else units(())
    return Trace(
        columns={name: np.array([one[name] for one in numbers], dtype=np.float64) for name in names},
        phase=tuple(row.phase for row in rows),
        tag=tuple(row.tag for row in rows),
    )
