"""Weak springs of a periodic cell: from every strand to the next, against turning, and at the cell's vectors."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.equilibrium.links import SOFT, Links

SOFTER = 1e-12
"""Stiffness of the springs at the cell's vectors [E r]: it adds to the forces on the cell."""

LEAST_ENDS = 4
"""Nodes of a link in a cell that repeats along two directions or one."""

_UP, _DOWN = np.array([1.0, 1.0, 1.0]), np.array([1.0, -1.0, 1.0])


def cell_links(
    x: FloatArray,
    strands: Sequence[FloatArray],
    sizes: Sequence[int],
    cell: IndexArray,
    neighbours: Sequence[tuple[int, int]],
    stitches: int,
) -> Links:
    """Return the links of a cell.

    Parameters
    ----------
    x : (N, 3) array
        The nodes of its model as printed [r].
    strands : sequence of (n, 3) arrays
        One period of each of its strands, in any unit.
    sizes : sequence of int
        Nodes of these strands in the model, which come first; more may follow.
    cell : (D,) array
        Nodes whose positions are the cell's vectors.
    neighbours : sequence of (int, int)
        Pairs of strands that are linked. Where one of them is the other's neighbour as an image, it is all the same: an
        even stretch moves both alike.
    stitches : int
        Stitches of a strand in the cell that one link holds: it is so many times as stiff as for one.
    """
    own = np.array(sizes[: len(strands)])
    first = np.cumsum(own) - own
    middle = float(np.concatenate([nodes[:, 0] for nodes in strands]).mean())
    high, low = (
        [int(k) + _extreme(side * nodes, middle) for k, nodes in zip(first, strands, strict=True)]
        for side in (_UP, _DOWN)
    )
    soft = SOFT * stitches
    springs = [_Spring({int(node): 1.0}, SOFTER) for node in cell]
    springs += [_Spring(_evenly_apart(x, high[a], high[b], cell), soft) for a, b in neighbours]
    # A strand that is straight has no two sides to turn about; only z says that it has turned.
    turning = [(a, b) for a, b in zip(high, low, strict=True) if abs(a - b) > 1]
    springs += [_Spring(_evenly_apart(x, b, a, cell, (2,)), 0.0, soft) for a, b in turning]
    # A link has two nodes of strands, and the cell's vectors in which their distance is measured.
    ends = max(LEAST_ENDS, 2 + len(cell))
    full = [spring.filled(ends) for spring in springs]
    nodes = np.array([sorted(shares, reverse=True) for shares in full], dtype=np.int64).reshape(-1, ends)
    shares = np.array([[shares[n] for n in sorted(shares, reverse=True)] for shares in full]).reshape(-1, ends)
    stiffness = np.array([[spring.stiffness, spring.stiffness, spring.along_z] for spring in springs]).reshape(-1, 3)
    return Links(nodes, shares, (shares[:, :, None] * x[nodes]).sum(axis=1), stiffness)


class _Spring(NamedTuple):
    """A link: the shares of its nodes, its stiffness, and that along z where it is another [E r]."""

    shares: Mapping[int, float]
    stiffness: float
    across: float | None = None

    @property
    def along_z(self) -> float:
        """Return the stiffness along z."""
        return self.stiffness if self.across is None else self.across

    def filled(self, ends: int) -> dict[int, float]:
        """Return the shares of so many nodes, those of the spare ones 0."""
        spare = (node for node in range(2 * ends) if node not in self.shares)
        return {**self.shares, **{next(spare): 0.0 for _ in range(ends - len(self.shares))}}


def _evenly_apart(
    x: FloatArray, before: int, after: int, cell: IndexArray, axes: Sequence[int] = (0, 1, 2)
) -> dict[int, float]:
    """Return the shares of a spring between two nodes that is free of force in an even stretch of the cell.

    There the two keep their distance along some axes in the cell's lengths.
    """
    apart = x[after] - x[before]
    vectors = {int(node): -float(apart[axis]) / float(x[node, axis]) for axis, node in enumerate(cell) if axis in axes}
    return {after: 1.0, before: -1.0, **vectors}


def _extreme(nodes: FloatArray, middle: float) -> int:
    """Return the node (n, 3) at the apex of a head that is nearest to the middle: those of all rows are alike."""
    height = nodes[:, 1]
    apex = (
        (height >= np.roll(height, 1))
        & (height >= np.roll(height, -1))
        & (height >= height.max() - 0.05 * np.ptp(height))
    )
    return int(np.argmin(np.where(apex, np.abs(nodes[:, 0] - middle), np.inf)))
