"""Knit a volumetric knit: rows there and back, layer over layer, all of one yarn.

The way of the yarn. The last row of a layer ends at its side of the knit, and the next layer must begin close by:
right above that end, so the next layer's first row is the one above the last row, run the other way. From there on
only the rows before it are left: that layer is knitted from its last row to its first. Its wale loops point
along -y (s = -1), which is again from each row to the one knitted after it, as in the layer below. So layers are
knitted in opposite directions, as the paper has it, every turn-around is one semicircle of diameter w or w_p, and
no float crosses the knit. Whether a row runs there or back alternates along the whole yarn.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.centreline import Centreline, Site, SiteSet
from knitlab_core.knits.clearance import clear_of_itself, gentle_bend
from knitlab_core.knits.fabric import Clasps
from knitlab_core.knits.pieces import Turn
from knitlab_core.knits.planar import HOOK_ANGLE, MOST_ROWS, between_rows, check_count, place_loops
from knitlab_core.knits.volumetric_row import VolumetricRow, wale_sign

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.distance import Approach
    from knitlab_core.knits.fabric import Pin
    from knitlab_core.knits.volumetric_shape import VolumetricShape

MOST_STITCHES: Final = 125_000
_AT_HEAD: Final = (-HOOK_ANGLE, HOOK_ANGLE)
_AT_FEET: Final = (HOOK_ANGLE - np.pi, np.pi - HOOK_ANGLE)


def volumetric(stitch: VolumetricShape, *, rows: int, loops: int, layers: int) -> Centreline:
    """Return one yarn through all rows of all layers of a volumetric knit.

    Parameters
    ----------
    stitch : VolumetricShape
        The stitch.
    rows, loops, layers : int
        Rows along the wale, stitches along the course (two loops each) and layers along the pile, 1 to 200 each.

    Returns
    -------
    Centreline
        The yarn [loop widths] with its sites, two hooks per boundary loop, 0.35 rad of its parameter on either side
        of its head or inwards from its two feet, and one per end of a row:

        - ``wale+``: heads of the last row's wale loops in the layers with s = +1 (first, third, ...); in the others
          the feet of the last row's wale loops, which is the row they begin with.
        - ``wale-``: feet of the first row's wale loops where s = +1, heads of the first row's where s = -1.
        - ``pile+``: heads of all pile loops of the top layer; ``pile-``: feet of all pile loops of the bottom layer.
        - ``course+``, ``course-``: both ends of every row, where turn-arounds and the yarn begin and end.

        None of these heads and feet is held by another loop. On a wale face heads are H_w farther out than the
        feet of the layers between; every layer is equally long from its feet to its heads.

    Raises
    ------
    SpecificationError
        If a count is not a whole number from 1 to 200, or they make more than 125,000 stitches.
    """
    for name, count in (("rows", rows), ("loops", loops), ("layers", layers)):
        check_count(f"specimen.{name}", count, most=MOST_ROWS)
    if rows * loops * layers > MOST_STITCHES:
        raise SpecificationError("specimen", f"{rows * loops * layers} stitches", f"at most {MOST_STITCHES} stitches")
    in_order = [numbered_row(stitch, number, rows, loops) for number in range(rows * layers)]
    pieces: list[VolumetricRow | Turn] = [in_order[0]]
    for before, after in pairwise(in_order):
        pieces += [_turn(before, after), after]
    # Rows are at even places among the pieces.
    starts = Centreline(pieces=tuple(pieces), sites=()).starts[::2]
    return Centreline(pieces=tuple(pieces), sites=_sites(in_order, starts, rows, layers))


def row_number(row: int, layer: int, rows: int) -> int:
    """Return when along the yarn a row is knitted, counted from 0."""
    return layer * rows + (row if wale_sign(layer) > 0 else rows - 1 - row)


def numbered_row(stitch: VolumetricShape, number: int, rows: int, loops: int) -> VolumetricRow:
    """Return the row that is knitted as number 0, 1, ... of the yarn; it is piece 2 ``number``."""
    layer, within = divmod(number, rows)
    row = within if wale_sign(layer) > 0 else rows - 1 - within
    return VolumetricRow(stitch=stitch, row=row, layer=layer, loops=loops, direction=-1 if number % 2 else 1)


def volumetric_middle(stitch: VolumetricShape, rows: int, loops: int, layers: int) -> FloatArray:
    """Return the point (3,) midway between the means of opposite faces' sites [loop widths]."""
    upward = float(np.mean([wale_sign(layer) for layer in range(layers)]))
    wale = 0.5 * ((rows - 1) * stitch.row_spacing + upward * stitch.wale_height)
    return np.array([loops - 0.5, wale, 0.5 * ((layers - 1) * stitch.layer_spacing + stitch.pile_height)])


def check_volumetric_clearance(
    stitch: VolumetricShape, centreline: Centreline, *, middle: FloatArray, loop_width: float
) -> Approach:
    """Return where the strands of a volumetric knit come closest, or refuse it if its yarn overlaps itself.

    The whole yarn is searched: layers alternate and turn-arounds are at both sides, which a part would miss.

    Parameters
    ----------
    stitch : VolumetricShape
        The stitch.
    centreline : Centreline
        The knit.
    middle : FloatArray
        The point (3,) that becomes the origin [loop widths]; for the message alone.
    loop_width : float
        For the message alone [m].

    Returns
    -------
    Approach
        Distance and arc lengths [loop widths].

    Raises
    ------
    GeometryError
        Naming the two places: layer, row, stitch, arc length and position in mm from the knit's centre.
    """
    loops = max(gentle_bend(loop, loop_width) for loop in (stitch.wale_loop, stitch.pile_loop))
    bend = max(loops, 2.0 / stitch.row_spacing, 2.0 / stitch.layer_spacing)
    return clear_of_itself(centreline, bend, radius=stitch.fibre_radius, middle=middle, loop_width=loop_width)


def volumetric_clasps(
    stitch: VolumetricShape, line: Centreline, *, rows: int, loops: int, layers: int
) -> dict[str, Clasps]:
    """Return the clasps of a volumetric knit.

    Returns
    -------
    dict of str to Clasps
        ``rows``: (layers, rows - 1, loops), every wale head with the wale loop that is knitted through it, between
        rows k and k + 1 of a layer; the head is row k's where wale loops point along +y, row k + 1's where along -y.
        ``layers``: (layers - 1, rows, loops), of layer m's pile head with layer m + 1's pile loop.
    """
    placed = [_placed(line, numbered_row(stitch, number, rows, loops), number) for number in range(rows * layers)]
    wale = [
        (row_number(row if upward else row + 1, layer, rows), row_number(row + 1 if upward else row, layer, rows))
        for layer in range(layers)
        for upward in (wale_sign(layer) > 0,)
        for row in range(rows - 1)
    ]
    pile = [(row_number(row, m, rows), row_number(row, m + 1, rows)) for m in range(layers - 1) for row in range(rows)]
    between, above = between_rows(placed, wale), between_rows(placed, pile)
    return {
        "rows": Clasps(*(arcs[:, 0::2].reshape(layers, rows - 1, loops, arcs.shape[-1]) for arcs in between)),
        "layers": Clasps(*(arcs[:, 1::2].reshape(layers - 1, rows, loops, arcs.shape[-1]) for arcs in above)),
    }


def wale_leg(stitch: VolumetricShape, line: Centreline, pin: Pin, *, rows: int, loops: int) -> float:
    """Return the arc length of the middle of the leg at +x of a stitch's wale loop [loop widths]."""
    number = row_number(pin.row, pin.layer, rows)
    row = numbered_row(stitch, number, rows, loops)
    within = row.arc_length(np.array([pin.loop]), pile=False, t=np.array([0.5 * np.pi]))
    return float(line.starts[2 * number] + within[0])


def _placed(line: Centreline, row: VolumetricRow, number: int) -> tuple[FloatArray, FloatArray]:
    """Return where the loops of a row are on the yarn, wale and pile loop in turn: feet (2n + 1,), apices (2n + 2,)."""
    stitch = np.arange(row.loops)
    begin, apex, end = (
        np.stack([row.arc_length(stitch, pile=pile, t=np.full(stitch.size, t)) for pile in (False, True)], axis=1)
        for t in (-np.pi, 0.0, np.pi)
    )
    return place_loops(line, number, row.direction, np.append(begin.ravel(), end[-1, -1]), apex.ravel())


def _turn(before: VolumetricRow, after: VolumetricRow) -> Turn:
    """Return the semicircle from a row to the one knitted after it, in x-y within a layer, in x-z between two."""
    stitch, side = before.stitch, before.direction
    rises = after.layer > before.layer
    x = 2.0 * before.loops - 0.5 if side > 0 else -0.5
    y = 0.5 * (before.row + after.row) * stitch.row_spacing
    z = 0.5 * (before.layer + after.layer) * stitch.layer_spacing
    if rises:
        joins = f"from layer {before.layer} to layer {after.layer} at row {after.row}"
    else:
        joins = f"from row {before.row} to row {after.row} of layer {after.layer}"
    return Turn(
        centre=(x, y, z),
        radius=0.5 * (stitch.layer_spacing if rises else stitch.row_spacing),
        side=side,
        across=(0.0, 0.0, 1.0) if rises else (0.0, float(after.row - before.row), 0.0),
        joins=joins,
    )


def _sites(in_order: list[VolumetricRow], starts: FloatArray, rows: int, layers: int) -> tuple[Site, ...]:
    def along(face: SiteSet, row: int, layer: int, at: tuple[float, float]) -> list[Site]:
        """Return two sites on every loop of a row: on pile loops for pile faces, else on wale loops."""
        number = row_number(row, layer, rows)
        piece = in_order[number]
        stitch = np.repeat(np.arange(piece.loops), 2)
        t = np.tile(np.array(at), piece.loops)
        arcs = starts[number] + piece.arc_length(stitch, pile=face.startswith("pile"), t=t)
        return [
            Site(set=face, row=row, loop=int(loop), arc_length=float(s), layer=layer)
            for loop, s in zip(stitch, arcs, strict=True)
        ]

    def end(face: SiteSet, row: int, layer: int) -> Site:
        number = row_number(row, layer, rows)
        piece = in_order[number]
        last = (face == "course+") == (piece.direction > 0)
        arc_length = float(starts[number]) + (piece.length if last else 0.0)
        return Site(
            set=face, row=row, loop=piece.loops - 1 if face == "course+" else 0, arc_length=arc_length, layer=layer
        )

    sites: list[Site] = []
    for layer in range(layers):
        upper, lower = (_AT_HEAD, _AT_FEET) if wale_sign(layer) > 0 else (_AT_FEET, _AT_HEAD)
        sites += along("wale+", rows - 1, layer, upper) + along("wale-", 0, layer, lower)
        sites += [end(face, row, layer) for face in ("course+", "course-") for row in range(rows)]
    for row in range(rows):
        sites += along("pile+", row, layers - 1, _AT_HEAD) + along("pile-", row, 0, _AT_FEET)
    return tuple(sites)
