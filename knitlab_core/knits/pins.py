"""Pins in a knit: named spots of stitches, and where they are once the knit is deformed.

A pin is in the middle of a stitch's leg at +x, on the base line of its row; of a volumetric knit in that of its wale
loop. It is an arc length of the yarn, not a node: its place is read off the smooth curve that the nodes control, at
any mesh.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.arrays import FloatArray, IndexArray
    from knitlab_core.knits.fabric import Pin
    from knitlab_core.knits.specimen import Specimen


class PinSpots(NamedTuple):
    """Nodes whose weighted mean is where a pin is."""

    nodes: IndexArray
    """(n, m) nodes of each pin, three of every fibre."""
    weights: FloatArray
    """(n, m) their weights, of sum 1."""

    def places(self, nodes: FloatArray) -> FloatArray:
        """Return where the pins are, (n, 3), in a knit whose nodes (N, 3) are given, in their unit."""
        places: FloatArray = np.einsum("nm,nmk->nk", self.weights, nodes[self.nodes])
        return places


def pin_spots(specimen: Specimen, pins: Sequence[Pin]) -> PinSpots:
    """Return the nodes that say where some pins are.

    Raises
    ------
    SpecificationError
        If the stitches of the knit are not known.
    """
    fabric, unit = specimen.fabric, specimen.loop_width
    arcs = []
    for pin in pins:
        leg = fabric.leg(specimen.centreline, specimen.counts, pin)
        if leg is None:
            raise SpecificationError("extensometer", "pins in stitches", "off: the stitches of the knit are not known")
        arcs.append(unit * leg)
    nodes, weights = _on_curve(specimen.arc_lengths, np.array(arcs))
    fibres = len(specimen.strands)
    first = len(specimen.arc_lengths) * np.arange(fibres)
    every = (first[None, :, None] + nodes[:, None, :]).reshape(len(pins), -1)
    return PinSpots(nodes=every, weights=np.tile(weights, (1, fibres)) / fibres)


def _on_curve(arc_lengths: FloatArray, at: FloatArray) -> tuple[IndexArray, FloatArray]:
    """Return the three nodes (n, 3) that control a quadratic B-spline at arc lengths (n,), and their weights (n, 3).

    The span of node i goes from the middle between it and the node before to that between it and the next.
    """
    middles = 0.5 * (arc_lengths[1:] + arc_lengths[:-1])
    # At the yarn's ends the first and the last whole span go on.
    span = np.clip(np.searchsorted(middles, at, side="right"), 1, len(middles) - 1)
    t = (at - middles[span - 1]) / (middles[span] - middles[span - 1])
    weights = np.stack([0.5 * (1.0 - t) ** 2, 0.5 + t * (1.0 - t), 0.5 * t**2], axis=1)
    return span[:, None] + np.arange(-1, 2), weights
