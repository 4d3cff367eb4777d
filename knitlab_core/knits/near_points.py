"""Pairs of points that are near each other, by a grid of cells; needs nothing that takes long to import."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray, IndexArray

_ROUNDING: Final = 1e-9
_STEPS: Final = [step for step in itertools.product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]
"""The half of the 26 cells around one that makes each pair of cells come once."""


def pairs_within(points: FloatArray, reach: float) -> IndexArray:
    """Return the pairs (k, 2), the smaller index first, of points (n, 3) that are at most `reach` apart."""
    cells = np.floor((points - points.min(axis=0)) / (reach * (1.0 + _ROUNDING))).astype(np.int64) + 1
    strides = np.array([(cells[:, 1].max() + 2) * (cells[:, 2].max() + 2), cells[:, 2].max() + 2, 1])
    keys = cells @ strides
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    own = np.arange(len(points))
    found = [_near(points, order, reach, own + 1, np.searchsorted(keys, keys, side="right"))]
    for step in _STEPS:
        beside = keys + int(strides @ step)
        found.append(_near(points, order, reach, np.searchsorted(keys, beside), np.searchsorted(keys, beside, "right")))
    return np.sort(np.concatenate(found), axis=1)


def _near(points: FloatArray, order: IndexArray, reach: float, begin: IndexArray, end: IndexArray) -> IndexArray:
    """Return pairs within reach: of each point in order, and of those from `begin` to `end` in the order."""
    counts = end - begin
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts - begin, counts)
    pairs = np.stack([np.repeat(order, counts), order[place]], axis=1)
    apart = points[pairs[:, 0]] - points[pairs[:, 1]]
    near: IndexArray = pairs[np.sum(apart * apart, axis=1) <= reach * reach]
    return near
