"""Random stiffnesses in 4 x 4 node blocks, and the same as dense matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from knitlab_core.contact.pairs import Candidates
from knitlab_core.equilibrium.pattern import make_pattern

if TYPE_CHECKING:
    from knitlab_core.sparse.blocks import Pattern

FloatArray = NDArray[np.float64]


def touching(*spans: tuple[int, int]) -> Candidates:
    """Let span a touch span b with one sample pair, for each (a, b) of inner nodes."""
    a, b = np.array(sorted(spans), dtype=np.int64).reshape(-1, 2).T
    return Candidates(a, b, np.arange(len(a) + 1), a.copy(), b.copy())


def random_pattern(n: int, contacts: int, seed: int) -> Pattern:
    """Make the pattern of one rod of n nodes with contacts between random spans."""
    rng = np.random.default_rng(seed)
    pairs = {(int(a), int(b)) for a, b in np.sort(rng.integers(1, n - 1, (contacts, 2))) if b - a >= 3}
    return make_pattern(n, touching(*pairs))


def lattice(size: tuple[int, int, int]) -> tuple[Pattern, FloatArray]:
    """Make the pattern of a strand to and fro through a box, touching itself everywhere, and its nodes' places."""
    nx, ny, nz = size
    z, y, x = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    x = np.where((y + z * ny) % 2 == 0, x, nx - 1 - x)
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    number = {tuple(place): i for i, place in enumerate(places.tolist())}
    inner = range(1, len(places) - 1)
    pairs = set()
    for i in inner:
        for axis in range(3):
            beside = places[i].copy()
            beside[axis] += 1
            j = number.get(tuple(beside.tolist()), 0)
            if j in inner and abs(i - j) >= 3:
                pairs.add((min(i, j), max(i, j)))
    return make_pattern(len(places), touching(*pairs)), places.astype(np.float64)


def random_blocks(pattern: Pattern, seed: int, diagonal: float = 40.0) -> FloatArray:
    """Fill the pattern with random numbers, diagonal blocks symmetric and heavy."""
    blocks = np.random.default_rng(seed).normal(size=(pattern.rows.size, 4, 4))
    own = pattern.diagonal
    blocks[own] = blocks[own] + blocks[own].transpose(0, 2, 1) + diagonal * np.eye(4)
    return blocks


def dense(pattern: Pattern, blocks: FloatArray) -> FloatArray:
    """Return the full symmetric matrix (4 N, 4 N)."""
    n = pattern.diagonal.size
    full = np.zeros((n, 4, n, 4))
    for i, j, block in zip(pattern.rows, pattern.columns, blocks, strict=True):
        full[i, :, j, :] = block
        full[j, :, i, :] = block.T
    return full.reshape(4 * n, 4 * n)
