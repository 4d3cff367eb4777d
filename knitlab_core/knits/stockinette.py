"""Knit planar stockinette: rows there and back, turn-arounds between, hooks' sites on the edges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.centreline import Centreline, Site, SiteSet
from knitlab_core.knits.pieces import Row, Turn

if TYPE_CHECKING:
    from knitlab_core.knits.stitch import FloatArray, Stitch

MOST_ROWS: Final = 200
HOOK_ANGLE: Final = 0.35
"""Parameter distance of a hook's site from the apex of its head or sinker [rad]."""


def stockinette(stitch: Stitch, *, rows: int, loops: int) -> Centreline:
    """Lay one yarn through all rows of a planar stockinette.

    Row k is Eq. 1 of the paper lifted by k w (`Row`), even rows run along +x, odd ones back; semicircles
    join them (`Turn`). The first row's first foot stands at (-1/2, -h, d).

    Parameters
    ----------
    stitch : Stitch
        The loop.
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
    pieces: list[Row | Turn] = []
    for row in range(rows):
        pieces.append(Row(stitch=stitch, row=row, loops=loops))
        if row < rows - 1:
            pieces.append(turn_after(stitch, row, loops))
    return Centreline(pieces=tuple(pieces), sites=_sites(stitch, rows, loops))


def check_count(field: str, found: object, *, most: int, least: int = 1) -> None:
    """Refuse a count that is not a whole number between its bounds.

    Raises
    ------
    SpecificationError
        Naming the field.
    """
    if not isinstance(found, int) or isinstance(found, bool) or not least <= found <= most:
        raise SpecificationError(field, found, f"a whole number from {least} to {most}")


def turn_after(stitch: Stitch, row: int, loops: int) -> Turn:
    """Return the turn-around from a row to the next: diameter w, in the plane z = d of the feet."""
    side = -1 if row % 2 else 1
    return Turn(
        centre=(loops - 0.5 if side > 0 else -0.5, (row + 0.5) * stitch.row_spacing - stitch.height, stitch.depth),
        radius=0.5 * stitch.row_spacing,
        side=side,
        across=(0.0, 1.0, 0.0),
        joins=f"from row {row} to row {row + 1}",
    )


def arc_length_at(stitch: Stitch, loops: int, row: int, t: FloatArray) -> FloatArray:
    """Return where on the yarn row ``row`` has the parameters t, (n,) -> (n,) [loop widths]."""
    this, turn = Row(stitch=stitch, row=row, loops=loops), turn_after(stitch, row, loops)
    return row * (this.length + turn.length) + this.arc_length(t)


def knit_middle(stitch: Stitch, rows: int, loops: int) -> FloatArray:
    """Return the point (3,) midway between opposite edges of the knit [loop widths]."""
    return np.array([0.5 * (loops - 1), 0.5 * (rows - 1) * stitch.row_spacing, 0.0])


def _sites(stitch: Stitch, rows: int, loops: int) -> tuple[Site, ...]:
    apices = 2.0 * np.pi * np.arange(loops)
    heads = (apices[:, None] + [-HOOK_ANGLE, HOOK_ANGLE]).ravel()
    sinkers = (apices[:, None] + [HOOK_ANGLE - np.pi, np.pi - HOOK_ANGLE]).ravel()
    of_loop = np.repeat(np.arange(loops), 2)

    def along(edge: SiteSet, row: int, t: FloatArray) -> list[Site]:
        arc_lengths = arc_length_at(stitch, loops, row, t)
        return [
            Site(set=edge, row=row, loop=int(loop), arc_length=float(s))
            for loop, s in zip(of_loop, arc_lengths, strict=True)
        ]

    ends = np.array([-1.0, 2.0 * loops - 1.0]) * np.pi
    at_ends = [arc_length_at(stitch, loops, row, ends) for row in range(rows)]
    left = [Site(set="course-", row=row, loop=0, arc_length=float(s[0])) for row, s in enumerate(at_ends)]
    right = [Site(set="course+", row=row, loop=loops - 1, arc_length=float(s[1])) for row, s in enumerate(at_ends)]
    return (*along("wale+", rows - 1, heads), *along("wale-", 0, sinkers), *right, *left)
