"""Parameters of a design: numbers between bounds, and words to choose from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigs.analysis.estimation import Bounded

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.schemas.designs import DesignFile
    from app.schemas.sweep import Scalar
    from rigs.axes import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """A parameter with some values to choose from, each a part of the coordinate from 0 to 1."""

    name: str
    values: Sequence[Scalar]
    unit: str = ""

    def number(self, z: float) -> int:
        """Return which value is chosen at a coordinate, from 0."""
        return min(int(z * len(self.values)), len(self.values) - 1)

    def value(self, z: float) -> Scalar:
        """Return the value at a coordinate."""
        return self.values[self.number(z)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Space:
    """Coordinates of all parameters of a design, each from 0 to 1."""

    parameters: Sequence[Bounded | Choice]

    def snapped(self, z: FloatArray) -> FloatArray:
        """Return coordinates (n, d) with those of choices at the middle of their part."""
        found = np.array(z, dtype=np.float64)
        for k, one in enumerate(self.parameters):
            if isinstance(one, Choice):
                found[:, k] = [(one.number(at) + 0.5) / len(one.values) for at in found[:, k].tolist()]
        return found

    def encoded(self, z: FloatArray) -> FloatArray:
        """Return coordinates (n, e) for a surrogate: a choice has a column of its own for every value, of 0 and 1."""
        columns: list[FloatArray] = []
        for k, one in enumerate(self.parameters):
            if isinstance(one, Choice):
                chosen = np.array([one.number(at) for at in z[:, k].tolist()])
                columns += [(chosen == number).astype(np.float64) for number in range(len(one.values))]
            else:
                columns.append(z[:, k])
        return np.stack(columns, axis=1)

    def rounded(self, z: FloatArray) -> FloatArray:
        """Return coordinates (d,) of the same values with four digits, within the bounds."""
        found = z.copy()
        for k, one in enumerate(self.parameters):
            if isinstance(one, Bounded):
                value = float(f"{one.value(float(z[k])):.4g}")
                found[k] = one.coordinate(min(max(value, one.low), one.high))
        return found


def space_of(file: DesignFile) -> Space:
    """Return the parameters of a design file."""
    numbers = [
        Bounded(name=one.name, low=one.low, high=one.high, start=0.5 * (one.low + one.high), unit=one.unit)
        for one in file.ranges
    ]
    words = [Choice(name=name, values=values) for name, values in file.choices.items()]
    return Space(parameters=[*numbers, *words])
