"""Travel and force of a test along one axis, row by row: from a record, or from an instrument's file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigs.axes import FloatArray, IntArray
    from rigs.record import Phase


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Measurement:
    """One test along one axis, or a part of it; ``nan`` stands where something was not measured.

    Attributes
    ----------
    name : str
        What it is of: the run or file, with the repeat or the step where there are several.
    axis : str
        ``C``, ``W`` or ``P``; another word, or none, where the file does not say.
    time, travel, force : FloatArray, shape (n,)
        Time [s], change of the distance of the hooks [m] and force [N], zeroed.
    strain, stress : FloatArray, shape (n,)
        Effective strain [1] and stress [Pa].
    transverse : FloatArray, shape (n,)
        Strain across the axis [1].
    cycle : IntArray, shape (n,)
        Counter of the cycles, from 1.
    phase : tuple of Phase, length n
        What the axis did.
    sampled : bool
        Whether an instrument took the rows, with noise and at its rate; equilibria of a solver are few and smooth.
    """

    name: str
    axis: str
    time: FloatArray
    travel: FloatArray
    force: FloatArray
    strain: FloatArray
    stress: FloatArray
    transverse: FloatArray
    cycle: IntArray
    phase: tuple[Phase, ...]
    sampled: bool = True

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.phase)

    @property
    def has_strain(self) -> bool:
        """Return whether strain and stress are known anywhere."""
        return bool(np.isfinite(self.strain).any() and np.isfinite(self.stress).any())

    def chosen(self, rows: slice | IntArray) -> Measurement:
        """Return some of the rows."""
        return replace(
            self,
            **{name: getattr(self, name)[rows] for name in COLUMNS},
            cycle=self.cycle[rows],
            phase=self.phase[rows] if isinstance(rows, slice) else tuple(self.phase[row] for row in rows),
        )


COLUMNS = ("time", "travel", "force", "strain", "stress", "transverse")
"""Fields that are columns of numbers."""
