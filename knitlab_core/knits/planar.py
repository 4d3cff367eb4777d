"""Planar knits: rows there and back, turn-arounds between, hooks' sites on the edges.

What stockinette, garter and rib have in common. They differ in the rows themselves and in the turns between them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.centreline import Centreline, Site, SiteSet
from knitlab_core.knits.crossing import crossing_number
from knitlab_core.knits.fabric import Clasps
from knitlab_core.knits.pieces import Piece, Turn

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.loop_shape import LoopShape

MOST_ROWS: Final = 200
HOOK_ANGLE: Final = 0.35
"""Parameter distance of a hook's site from the apex of its head or sinker [rad]."""

_SAMPLES: Final = 65


class PlanarRow(Piece, Protocol):
    """Protocol of a row of loops: loop j has its head at t = 2 pi j and its feet at pi before and after."""

    @property
    def direction(self) -> int:
        """Return +1 where the yarn runs with the course, -1 where it comes back."""

    def arc_length(self, t: FloatArray) -> FloatArray:
        """Return the arc length from the row's own start to each parameter, (n,) -> (n,) [loop widths]."""


class PlanarKnit(Protocol):
    """Protocol of the rows of a planar knit; all are equally long, and so are all turns."""

    @property
    def fibre_radius(self) -> float:
        """Return the radius of the fibre [loop widths]."""

    @property
    def shapes(self) -> tuple[LoopShape, ...]:
        """Return the shapes that its loops have, of one height: what bends are looked for in."""

    @property
    def row_spacing(self) -> float:
        """Return the wale distance of neighbouring rows [loop widths]."""

    def row(self, number: int, loops: int) -> PlanarRow:
        """Return a row, counted from 0; even ones run along +x, odd ones back."""

    def turn(self, number: int, loops: int) -> Turn:
        """Return the turn-around from a row to the next."""


def planar_line(knit: PlanarKnit, *, rows: int, loops: int) -> Centreline:
    """Return one yarn through all rows of a planar knit.

    Parameters
    ----------
    knit : PlanarKnit
        Its rows and turns.
    rows, loops : int
        Rows along the wale and loops along the course, 1 to 200 each.

    Returns
    -------
    Centreline
        The yarn [loop widths] with its sites: ``wale+`` on each head of the last row and ``wale-`` on each sinker
        of the first, 0.35 rad before and after its apex (the two half sinkers at the row's ends have one each), so
        two per loop; ``course+`` and ``course-`` on each row's ends, one per row.

    Raises
    ------
    SpecificationError
        If a count is not a whole number from 1 to 200.
    """
    check_count("specimen.rows", rows, most=MOST_ROWS)
    check_count("specimen.loops", loops, most=MOST_ROWS)
    pieces: list[PlanarRow | Turn] = []
    for row in range(rows):
        pieces.append(knit.row(row, loops))
        if row < rows - 1:
            pieces.append(knit.turn(row, loops))
    return Centreline(pieces=tuple(pieces), sites=_sites(knit, rows, loops))


def check_count(field: str, found: object, *, most: int, least: int = 1) -> None:
    """Refuse a count that is not a whole number between its bounds.

    Raises
    ------
    SpecificationError
        Naming the field.
    """
    if not isinstance(found, int) or isinstance(found, bool) or not least <= found <= most:
        raise SpecificationError(field, found, f"a whole number from {least} to {most}")


def arc_length_at(knit: PlanarKnit, loops: int, row: int, t: FloatArray) -> FloatArray:
    """Return where on the yarn row ``row`` has the parameters t, (n,) -> (n,) [loop widths]."""
    this, turn = knit.row(row, loops), knit.turn(row, loops)
    return row * (this.length + turn.length) + this.arc_length(t)


def knit_middle(knit: PlanarKnit, rows: int, loops: int) -> FloatArray:
    """Return the point (3,) midway between opposite edges of the knit [loop widths]."""
    return np.array([0.5 * (loops - 1), 0.5 * (rows - 1) * knit.row_spacing, 0.0])


def stitch_clasp(knit: PlanarKnit) -> int:
    """Return the clasp number of a head and the next row's yarn on the right of its apex, from the centreline itself.

    Every other clasp of a planar knit is this one moved or mirrored; and so is every clasp of wale loops or of pile
    loops in a volumetric knit, with the planar stitch that they are loops of.
    """
    rows = [knit.row(row, 2) for row in (0, 1)]
    head, held = (
        row.position(row.arc_length(np.linspace(*span, _SAMPLES)))
        for row, span in zip(rows, ((-np.pi, np.pi), (0.0, 2.0 * np.pi)), strict=True)
    )
    return crossing_number(head, held)


def planar_clasps(knit: PlanarKnit, line: Centreline, *, rows: int, loops: int) -> Clasps:
    """Return the clasps of a planar knit, (rows - 1, loops): of row k's head j and row k + 1's loop j."""
    half_turns = np.pi * np.arange(-1.0, 2.0 * loops)
    placed = []
    for number in range(rows):
        row = knit.row(number, loops)
        feet, apices = row.arc_length(half_turns[::2]), row.arc_length(half_turns[1::2])
        placed.append(place_loops(line, number, row.direction, feet, apices))
    return between_rows(placed, [(row, row + 1) for row in range(rows - 1)])


def place_loops(
    line: Centreline, number: int, direction: int, feet: FloatArray, apices: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where the loops of a row are on the yarn, in the order of growing t on every row.

    Parameters
    ----------
    line : Centreline
        The yarn; the row is its piece 2 ``number``.
    number : int
        When along the yarn the row is knitted, counted from 0.
    direction : {1, -1}
        Which way it runs.
    feet, apices : FloatArray
        (n + 1,) where loops begin and end and (n,) their apices, from the row's own start [loop widths].

    Returns
    -------
    tuple of FloatArray
        Feet (n + 1,) and apices (n + 2,) from the yarn's start; the first and the last apex are the middles of the
        turn-arounds, or the yarn's ends.
    """
    start = line.starts[2 * number]
    before, after = max(2 * number - 1, 0), min(2 * number + 2, len(line.pieces))
    ends = 0.5 * np.array([line.starts[before] + start, line.starts[2 * number + 1] + line.starts[after]])
    ends = ends[::direction]
    return start + feet, np.concatenate([ends[:1], start + apices, ends[1:]])


def between_rows(placed: list[tuple[FloatArray, FloatArray]], pairs: list[tuple[int, int]]) -> Clasps:
    """Return the clasps (pairs, loops) between the loops of rows, each pair the holding and the held row."""
    loops = len(placed[0][0]) - 1
    heads, held = np.zeros((len(pairs), loops, 2)), np.zeros((len(pairs), loops, 3))
    for pair, (holding, through) in enumerate(pairs):
        feet, apices = placed[holding][0], placed[through][1]
        heads[pair] = np.stack([feet[:-1], feet[1:]], axis=-1)
        held[pair] = np.stack([apices[:-2], apices[1:-1], apices[2:]], axis=-1)
    return Clasps(heads=heads, held=held)


def _sites(knit: PlanarKnit, rows: int, loops: int) -> tuple[Site, ...]:
    apices = 2.0 * np.pi * np.arange(loops)
    heads = (apices[:, None] + [-HOOK_ANGLE, HOOK_ANGLE]).ravel()
    sinkers = (apices[:, None] + [HOOK_ANGLE - np.pi, np.pi - HOOK_ANGLE]).ravel()
    of_loop = np.repeat(np.arange(loops), 2)

    def along(edge: SiteSet, row: int, t: FloatArray) -> list[Site]:
        arc_lengths = arc_length_at(knit, loops, row, t)
        return [
            Site(set=edge, row=row, loop=int(loop), arc_length=float(s))
            for loop, s in zip(of_loop, arc_lengths, strict=True)
        ]

    ends = np.array([-1.0, 2.0 * loops - 1.0]) * np.pi
    at_ends = [arc_length_at(knit, loops, row, ends) for row in range(rows)]
    left = [Site(set="course-", row=row, loop=0, arc_length=float(s[0])) for row, s in enumerate(at_ends)]
    right = [Site(set="course+", row=row, loop=loops - 1, arc_length=float(s[1])) for row, s in enumerate(at_ends)]
    return (*along("wale+", rows - 1, heads), *along("wale-", 0, sinkers), *right, *left)
