"""Extensometer of a test: pins in stitches of the fabric, whose distance is read along each axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

from knitlab_core.errors import SpecificationError, raise_all
from knitlab_core.knits import Pin
from rigs.axes import DIRECTIONS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits import Counts
    from rigs.axes import Axis

Pair: TypeAlias = tuple[int, int]

WORDS: Final[Mapping[Axis, str]] = {"C": "course", "W": "wale", "P": "pile"}
"""What a protocol calls the pair of pins along each axis."""

_REPEATS: Final[Mapping[Axis, str]] = {"C": "stitches of a row", "W": "rows", "P": "layers"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Extensometer:
    """Pairs of pins, each along one axis through the middle of the knit.

    Parameters
    ----------
    course : (int, int) or None
        Two stitches of the middle row, counted from 0 along the course; None where the course is not measured.
    wale : (int, int) or None
        Two rows, at the middle stitch, counted from 0 along the wale.
    pile : (int, int) or None
        Two layers, at the middle stitch of the middle row, counted from 0 along the pile.
    """

    course: Pair | None = None
    wale: Pair | None = None
    pile: Pair | None = None

    @classmethod
    def inner_half(cls, counts: Counts) -> Extensometer:
        """Return pins about half of the knit apart along each axis, as far from one edge as from the other."""
        pairs = {}
        for axis, count in _counts(counts).items():
            first = count // 4
            pairs[WORDS[axis]] = None if count < 2 else (first, count - 1 - first)
        return cls(**pairs)

    @property
    def pairs(self) -> dict[Axis, Pair]:
        """Return the two stitches of each axis that is measured."""
        named = {axis: getattr(self, WORDS[axis]) for axis in DIRECTIONS}
        return {axis: pair for axis, pair in named.items() if pair is not None}

    def pins(self, counts: Counts) -> dict[Axis, tuple[Pin, Pin]]:
        """Return the two pins of each axis that is measured."""
        middle = Pin(row=counts.rows // 2, loop=counts.loops // 2, layer=counts.layers // 2)
        place = {"C": "loop", "W": "row", "P": "layer"}
        return {
            axis: (middle._replace(**{place[axis]: first}), middle._replace(**{place[axis]: last}))
            for axis, (first, last) in self.pairs.items()
        }

    def places(self, counts: Counts) -> dict[Axis, str]:
        """Return in words where the two pins of each axis are."""
        shown: dict[Axis, str] = {}
        for axis, (first, last) in self.pins(counts).items():
            layer = "" if counts.layers == 1 else f" of layer {first.layer}"
            shown[axis] = {
                "C": f"stitches {first.loop} and {last.loop} of row {first.row}{layer}",
                "W": f"rows {first.row} and {last.row} at stitch {first.loop}{layer}",
                "P": f"layers {first.layer} and {last.layer} at stitch {first.loop} of row {first.row}",
            }[axis]
        return shown

    def check(self, counts: Counts) -> None:
        """Refuse pins in stitches that a knit does not have.

        Raises
        ------
        SpecificationError
            Naming the pair.
        """
        faults = []
        if not self.pairs:
            faults.append(
                SpecificationError("extensometer", "no pins", "two stitches, rows or layers that the knit has, or off")
            )
        for axis, pair in self.pairs.items():
            count = _counts(counts)[axis]
            if not 0 <= pair[0] < pair[1] < count:
                allowed = f"two of the {count} {_REPEATS[axis]}, counted from 0, the first before the last"
                faults.append(SpecificationError(f"extensometer.{WORDS[axis]}", list(pair), allowed))
        raise_all(faults)


def _counts(counts: Counts) -> dict[Axis, int]:
    """Return how often the knit repeats along each axis."""
    return {"C": counts.loops, "W": counts.rows, "P": counts.layers}
