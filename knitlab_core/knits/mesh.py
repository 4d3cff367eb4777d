"""Divide a yarn into edges: every boundary site a node, edges as equal as that allows."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import FloatArray, IndexArray
    from knitlab_core.knits.centreline import Centreline, SiteSet

MOST_NODES: Final = 2_000_000
_END_TOLERANCE: Final = 1e-9


class Mesh(NamedTuple):
    """Nodes of a yarn, and which of them are sites."""

    arc_lengths: FloatArray
    """(N,) arc length of each node, from 0 [loop widths]."""
    sites: Mapping[SiteSet, IndexArray]
    """Node indices of each set of sites, in the order of the centreline's."""


def yarn_mesh(centreline: Centreline, edge: float) -> Mesh:
    """Divide a yarn at its sites, and between two of them into equal edges nearest in length to ``edge``.

    Parameters
    ----------
    centreline : Centreline
        The yarn; its ends become nodes too.
    edge : float
        Wanted length of an edge [loop widths].

    Raises
    ------
    SpecificationError
        If the mesh would have more than 2 million nodes.
    """
    at_sites = _with_ends(centreline, np.sort([site.arc_length for site in centreline.sites]))
    edges = _edge_counts(np.diff(at_sites), edge)
    if edges.sum() >= MOST_NODES:
        raise SpecificationError("specimen", f"{edges.sum() + 1} nodes", f"a mesh of at most {MOST_NODES} nodes")
    return Mesh(arc_lengths=_divide(at_sites, edges), sites=_site_nodes(centreline, at_sites, edges))


def control_points(points: FloatArray) -> FloatArray:
    """Return nodes (N, 3) whose quadratic B-spline passes through points on the yarn; the ends stay.

    A spline with its nodes on the yarn cuts every bend; at 48 nodes per loop that costs 5 to 9 % of the force.
    """
    # Elimination from end to end; SciPy's would take longer to import than a knit to build.
    before, diagonal, after = [0.125] * len(points), [0.75] * len(points), [0.125] * len(points)
    diagonal[0] = diagonal[-1] = 1.0
    before[-1] = after[0] = 0.0
    nodes = np.array(points, dtype=np.float64)
    for k in range(1, len(points)):
        share = before[k] / diagonal[k - 1]
        diagonal[k] -= share * after[k - 1]
        nodes[k] -= share * nodes[k - 1]
    nodes[-1] /= diagonal[-1]
    for k in range(len(points) - 2, -1, -1):
        nodes[k] = (nodes[k] - after[k] * nodes[k + 1]) / diagonal[k]
    return nodes


def _with_ends(centreline: Centreline, at_sites: FloatArray) -> FloatArray:
    """Return arc lengths of sites in order with the yarn's ends, where these are no sites but for rounding."""
    near = _END_TOLERANCE * centreline.length
    start = [0.0] if at_sites[0] > near else []
    end = [centreline.length] if at_sites[-1] < centreline.length - near else []
    return np.concatenate([start, at_sites, end])


def _site_nodes(centreline: Centreline, at_sites: FloatArray, edges: IndexArray) -> Mapping[SiteSet, IndexArray]:
    first_of_stretch = np.concatenate([[0], np.cumsum(edges)])
    arcs: dict[SiteSet, list[float]] = {}
    for site in centreline.sites:
        arcs.setdefault(site.set, []).append(site.arc_length)
    return MappingProxyType({edge: first_of_stretch[np.searchsorted(at_sites, arc)] for edge, arc in arcs.items()})


def _edge_counts(stretches: FloatArray, wanted: float) -> IndexArray:
    """Return how many equal edges of each stretch are nearest in length to the wanted one."""
    fewer = np.maximum(np.floor(stretches / wanted), 1.0)
    long, short = stretches / fewer, stretches / (fewer + 1.0)
    counts = np.where(np.abs(long - wanted) <= np.abs(short - wanted), fewer, fewer + 1.0)
    return counts.astype(np.int64)


def _divide(ends: FloatArray, counts: IndexArray) -> FloatArray:
    """Return the ends (k + 1,) with each stretch between them divided evenly (sum(counts) + 1,)."""
    stretch = np.repeat(np.arange(counts.size), counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    inner = ends[stretch] + np.diff(ends)[stretch] * (within / counts[stretch])
    return np.append(inner, ends[-1])
