"""Where the stiffness is stored: 4 x 4 blocks of pairs of nodes."""

from typing import NamedTuple

from knitlab_core.arrays import IndexArray


class Pattern(NamedTuple):
    """Blocks (i, j), i >= j, of the lower triangle, sorted by column then row.

    `rows`, `columns`: (B,) nodes of a block; `diagonal`, `below`, `below2`: (N,)
    block of nodes (i, i), (i, i - 1), (i, i - 2); `across`: (S, 9) blocks of a
    span pair in contact, three nodes of b by three nodes of a.
    """

    rows: IndexArray
    columns: IndexArray
    diagonal: IndexArray
    below: IndexArray
    below2: IndexArray
    across: IndexArray
