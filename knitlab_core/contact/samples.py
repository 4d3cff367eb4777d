"""Samples on smooth centrelines: the points between which contact acts.

The smooth centreline is the uniform quadratic B-spline whose control points are
the nodes. Span i belongs to inner node i and runs from the middle of edge i - 1
to the middle of edge i; it carries m samples, each a fixed material point.
"""

from typing import NamedTuple

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector


class Samples(NamedTuple):
    """Where samples lie along the strands.

    `spans`: (M,) inner nodes; `weights`: (m, 3) of a span's nodes; `length`:
    (N,) rest length a sample of span i stands for; `strand`: (N,) strand of a
    node; `arc`: (N,) rest arc length at a node; `image`: (N,) whether a node is
    an image of another (`ties`): two images are no pair.
    """

    spans: IndexArray
    weights: FloatArray
    length: FloatArray
    strand: IndexArray
    arc: FloatArray
    image: BoolArray


@inline_kernel
def sample_point(q: FloatArray, i: int, w: FloatArray, k: int) -> Vector:
    """Return the position of sample k of span i."""
    a, b, c = w[k, 0], w[k, 1], w[k, 2]
    return (
        a * q[i - 1, 0] + b * q[i, 0] + c * q[i + 1, 0],
        a * q[i - 1, 1] + b * q[i, 1] + c * q[i + 1, 1],
        a * q[i - 1, 2] + b * q[i, 2] + c * q[i + 1, 2],
    )


@kernel
def sample_points(q: FloatArray, samples: Samples, points: FloatArray) -> None:
    """Fill `points` (N m, 3) with the samples of all spans; others stay untouched."""
    m = samples.weights.shape[0]
    for i in samples.spans:
        for k in range(m):
            x = sample_point(q, i, samples.weights, k)
            for c in range(3):
                points[i * m + k, c] = x[c]
