"""Weak springs that hold what nothing else holds: strands of a periodic cell that do not touch yet.

Until its loops touch, a strand of a cell can move and turn freely between the others: nothing says where it is, and
friction would depend on where rounding has left it. Springs softer than a loop put it where an even stretch of the
cell would; there they exert no force.
"""

from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray, IndexArray
from knitlab_core.rods.frames import Frames
from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.sums import inner

SOFT = 1e-7
"""Stiffness of a link [E r]: a tenth of that of a loop that bends."""


class Links(NamedTuple):
    """Linear springs: 1/2 sum_c k_c s_c^2 with s = sum_n share_n x_n - rest.

    `nodes`: (K, E) falling numbers; `shares`: (K, E); `rest`: (K, 3) [r]; `stiffness`: (K, 3) along x, y, z [E r].
    """

    nodes: IndexArray
    shares: FloatArray
    rest: FloatArray
    stiffness: FloatArray

    @property
    def ends(self) -> int:
        """Return the number E of nodes of a link."""
        return int(self.nodes.shape[1])

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Return the pairs of a link's nodes whose blocks it adds stiffness to."""
        return [(x, y) for y in range(self.ends) for x in range(y + 1)]

    def keys(self, n: int) -> IndexArray:
        """Return column n + row of the blocks of n nodes in which they add stiffness."""
        return np.concatenate([self.nodes[:, y] * n + self.nodes[:, x] for x, y in self.pairs])


class LinkTerm:
    """Energy of links.

    Parameters
    ----------
    links : Links
        The springs.
    """

    _places: IndexArray

    def __init__(self, links: Links) -> None:
        self._links = links
        self._stretch = np.zeros_like(links.rest)

    def fits(self, pattern: Pattern) -> bool:
        """Take a pattern, which has the blocks of all links."""
        n = pattern.diagonal.size
        self._places = np.searchsorted(pattern.columns * n + pattern.rows, self._links.keys(n))
        return True

    def place(self, q: FloatArray, _: Frames) -> None:
        """Take a configuration."""
        nodes, shares = self._links.nodes, self._links.shares
        stretch = -self._links.rest
        for k in range(self._links.ends):
            stretch = stretch + shares[:, k, None] * q[nodes[:, k], :3]
        self._stretch = stretch

    def energy(self) -> float:
        """Return the energy [E r^3]."""
        return 0.5 * inner(self._links.stiffness * self._stretch, self._stretch)

    def add_gradient(self, gradient: FloatArray) -> None:
        """Add the springs' forces to a gradient (N, 4)."""
        force = self._links.stiffness * self._stretch
        for k in range(self._links.ends):
            np.add.at(gradient[:, :3], self._links.nodes[:, k], self._links.shares[:, k, None] * force)

    def add_hessian(self, _: float, blocks: FloatArray) -> None:
        """Add the springs' stiffness."""
        shares, pairs = self._links.shares, self._links.pairs
        weight = np.concatenate([shares[:, x] * shares[:, y] for x, y in pairs])
        stiffness = np.tile(self._links.stiffness, (len(pairs), 1))
        for c in range(3):
            np.add.at(blocks[:, c, c], self._places, weight * stiffness[:, c])
