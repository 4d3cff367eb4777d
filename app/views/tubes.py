"""Smooth tubes through the nodes, as contact sees them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigs.axes import FloatArray, IntArray

FEWEST_POINTS: Final = 3
Window = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tube:
    """A tube and the values that colour it.

    Attributes
    ----------
    points : FloatArray, shape (n, 3)
        Centreline [mm].
    values : FloatArray, shape (n,)
        What the colour shows, in the unit of the colour bar.
    radius : float
        Radius [mm].
    sizes : IntArray
        Points of every piece (k,); pieces follow each other in the points.
    """

    points: FloatArray
    values: FloatArray
    radius: float
    sizes: IntArray


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


def tube(
    nodes: FloatArray, values: FloatArray, radius: float, per_span: int = 4, *, strands: Sequence[int] | None = None
) -> Tube:
    """Make the tubes of a yarn's strands.

    Parameters
    ----------
    nodes : FloatArray, shape (N, 3)
        Node positions, strand by strand [m].
    values : FloatArray, shape (N - number of strands,) or (N,)
        One value per edge, shown as running linearly between the edges' middles, or one per node. No tube is drawn
        along an edge without a value (nan), where a fibre is broken.
    radius : float
        Radius of a strand [m].
    per_span : int
        Points per node.
    strands : sequence of int
        Nodes of every strand; one strand unless given.

    Returns
    -------
    Tube
        In mm.
    """
    sizes = [len(nodes)] if strands is None else list(strands)
    per_node = len(values) == len(nodes)
    ends = np.cumsum(sizes)
    edge_ends = ends if per_node else ends - np.arange(1, len(sizes) + 1)
    pieces = [
        piece
        for line, colour in zip(np.split(nodes, ends[:-1]), np.split(values, edge_ends[:-1]), strict=True)
        for piece in _unbroken(line, colour)
    ]
    drawn = [(smooth_curve(line, per_span), _shown(line, colour, per_span)) for line, colour in pieces]
    return Tube(
        points=1e3 * np.concatenate([points for points, _ in drawn]),
        values=np.concatenate([shown for _, shown in drawn]),
        radius=1e3 * radius,
        sizes=np.array([len(points) for points, _ in drawn]),
    )


def _unbroken(nodes: FloatArray, values: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the pieces of a strand between broken edges that are long enough for a curve."""
    cuts = np.flatnonzero(np.isnan(values))
    for first, last in zip([-1, *cuts], [*cuts, len(nodes) - 1], strict=True):
        line = nodes[first + 1 : last + 1]
        if len(line) >= FEWEST_POINTS:
            yield line, values[first + 1 : last + 1 - (len(values) < len(nodes))]


def _shown(nodes: FloatArray, values: FloatArray, per_span: int) -> FloatArray:
    """Return the values (m,) at the points of a strand's curve."""
    if len(values) == len(nodes):
        return smooth_curve(values[:, None], per_span)[:, 0]
    steps = np.arange((len(nodes) - 2) * per_span + 1) / per_span
    shown = np.interp(steps, np.arange(len(values)), values)
    return np.concatenate([shown[:1], shown, shown[-1:]])


def fit_window(tubes: Sequence[Tube], margin: float = 0.04) -> Window:
    """Return the smallest window x₀, x₁, y₀, y₁ [mm] that shows every tube, with a margin (share of its size)."""
    low = np.min([one.points.min(axis=0) - one.radius for one in tubes], axis=0)[:2]
    high = np.max([one.points.max(axis=0) + one.radius for one in tubes], axis=0)[:2]
    room = margin * float((high - low).max())
    return (float(low[0] - room), float(high[0] + room), float(low[1] - room), float(high[1] + room))
