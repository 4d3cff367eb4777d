"""Say which loop each node of a volumetric specimen is on, straight from its centreline's pieces."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from knitlab_core.knits.volumetric_row import VolumetricRow

if TYPE_CHECKING:
    from knitlab_core.knits import Specimen

Array = np.ndarray


class Places(NamedTuple):
    """Layer and row (-1 on a turn-around), stitch, whether on a pile loop, and its parameter, each (N,)."""

    layer: Array
    row: Array
    stitch: Array
    pile: Array
    t: Array


def places(knit: Specimen) -> Places:
    s, starts = knit.arc_lengths / knit.loop_width, knit.centreline.starts
    layer, row, stitch = np.full((3, s.size), -1)
    found = Places(layer, row, stitch, np.zeros(s.size, dtype=np.bool_), np.zeros(s.size))
    for number, piece in enumerate(knit.centreline.pieces):
        if isinstance(piece, VolumetricRow):
            here = (s >= starts[number] - 1e-9) & (s <= starts[number + 1] + 1e-9)
            spot = piece.spot(s[here] - starts[number])
            found.layer[here], found.row[here] = piece.layer, piece.row
            found.stitch[here], found.pile[here], found.t[here] = spot
    return found
