"""Pins of an extensometer in a mounted specimen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from knitlab_core.knits import Pin, pin_spots
from rigs.axes import COORDINATE
from rigs.protocol.extensometer import Extensometer

if TYPE_CHECKING:
    from knitlab_core.knits import PinSpots, Specimen
    from rigs.axes import Axis, FloatArray


def pins_on(specimen: Specimen, extensometer: Extensometer | None) -> dict[Axis, PinSpots]:
    """Return both pins along each axis that an extensometer measures; none without one."""
    if extensometer is None:
        return {}
    return {axis: pin_spots(specimen, pair) for axis, pair in extensometer.pins(specimen.counts).items()}


def distance(pins: PinSpots, axis: Axis, q: FloatArray) -> float:
    """Return how far two pins are apart along their axis: what a camera sees that looks across it.

    Parameters
    ----------
    pins : PinSpots
        The two pins.
    axis : Axis
        Their axis.
    q : FloatArray, shape (N, 3) or (N, 4)
        Positions of the nodes in its first three columns, in any unit of length.
    """
    first, last = pins.places(q[:, :3])[:, COORDINATE[axis]]
    return float(last - first)


def stitch_pitch(specimen: Specimen, q: FloatArray) -> dict[Axis, float]:
    """Return the mean distance of neighbouring stitches in the inner half of a knit along each axis.

    Empty where its stitches are not known; an axis along which it has one stitch is left out.

    Parameters
    ----------
    specimen : Specimen
        The knit.
    q : FloatArray, shape (N, 3) or (N, 4)
        Positions of the nodes in its first three columns, in any unit of length.
    """
    first = Pin(row=0, loop=0)
    if specimen.cell is not None or specimen.fabric.leg(specimen.centreline, specimen.counts, first) is None:
        return {}
    half = Extensometer.inner_half(specimen.counts)
    pairs = half.pairs
    return {
        axis: distance(pins, axis, q) / (pairs[axis][1] - pairs[axis][0])
        for axis, pins in pins_on(specimen, half).items()
    }
