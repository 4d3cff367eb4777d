"""Turn nodes into the smooth tube that contact sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rigs.record import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tube:
    """Hold a tube and the value that colours it.

    Attributes
    ----------
    points : FloatArray, shape (n, 3)
        Centreline [mm].
    values : FloatArray, shape (n,)
        What the colour shows, in the unit of the colour bar.
    radius : float
        Radius [mm].
    """

    points: FloatArray
    values: FloatArray
    radius: float


def smooth_curve(nodes: FloatArray, per_span: int = 4) -> FloatArray:
    """Sample the uniform quadratic B-spline whose control points are the nodes.

    Span i is c(t) = ½(1-t)² x₋ + (½ + t(1-t)) x + ½t² x₊ with the neighbours x₋ and x₊ of node i. Its two ends
    are joined to the first and the last node by straight lines.

    Parameters
    ----------
    nodes : FloatArray, shape (N, d)
        Control points, three or more.
    per_span : int
        Points on each span.

    Returns
    -------
    FloatArray, shape ((N - 2) per_span + 3, d)
        Points of the curve, in the unit of the nodes.
    """
    t = (np.arange(per_span) / per_span)[None, :, None]
    before, here, after = nodes[:-2, None], nodes[1:-1, None], nodes[2:, None]
    spans = 0.5 * (1 - t) ** 2 * before + (0.5 + t * (1 - t)) * here + 0.5 * t**2 * after
    last = 0.5 * (nodes[-2] + nodes[-1])
    return np.concatenate([nodes[:1], spans.reshape(-1, nodes.shape[1]), [last], nodes[-1:]])


def tube(nodes: FloatArray, values: FloatArray, radius: float, per_span: int = 4) -> Tube:
    """Make the tube of a yarn.

    Parameters
    ----------
    nodes : FloatArray, shape (N, 3)
        Node positions [m].
    values : FloatArray, shape (N - 1,) or (N,)
        One value per edge, shown as running linearly between the edges' middles, or one per node.
    radius : float
        Radius of the yarn [m].
    per_span : int
        Points per node.

    Returns
    -------
    Tube
        In mm.
    """
    if len(values) == len(nodes):
        shown = smooth_curve(values[:, None], per_span)[:, 0]
    else:
        steps = np.arange((len(nodes) - 2) * per_span + 1) / per_span
        shown = np.interp(steps, np.arange(len(values)), values)
        shown = np.concatenate([shown[:1], shown, shown[-1:]])
    return Tube(points=1e3 * smooth_curve(nodes, per_span), values=shown, radius=1e3 * radius)
