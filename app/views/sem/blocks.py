"""Blocks around the specimen: load plates, the substrate below, the gripper above."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from rigs.axes import FloatArray, IntArray
    from rigs.record import Frame

RIM: Final = 0.12
"""How far a plate reaches beyond the yarn, over the specimen's width."""

WAFER: Final = 12.0
"""How far the substrate reaches beyond the plate, over the plate's width."""

GRIPPER_REACH: Final = 0.16
"""How far the gripper's jaws reach beyond the plate, over the specimen's width."""


class Block(NamedTuple):
    """A block with faces along course, wale and pile [m], of the specimen's resin or of silicon."""

    low: FloatArray
    high: FloatArray
    printed: bool

    @property
    def corners(self) -> FloatArray:
        """Return its corners, shape (8, 3) [m]."""
        return np.array(list(product(*zip(self.low, self.high, strict=True))))


def fixtures(frame: Frame, plates: tuple[IntArray, IntArray], radius: float) -> tuple[Block, ...]:
    """Return the blocks around a specimen between plates.

    Parameters
    ----------
    frame : Frame
        Its shape.
    plates : tuple of IntArray
        Nodes in the lower and in the upper plate.
    radius : float
        Of the fibre [m].

    Returns
    -------
    tuple of Block
        Substrate, lower plate, upper plate, and the gripper's two jaws and back. Plates reach to where their
        innermost node is, the outer faces a fibre beyond the outermost.
    """
    held = [frame.nodes[nodes] for nodes in plates]
    printed = np.concatenate(held)
    low, high = printed.min(axis=0), printed.max(axis=0)
    rim = RIM * float((high - low)[:2].max())
    left, front, _ = low - radius - rim
    right, back, _ = high + radius + rim
    floor, lower_face = held[0][:, 2].min() - 2.0 * radius, held[0][:, 2].max()
    upper_face, ceiling = held[1][:, 2].min(), held[1][:, 2].max() + 2.0 * radius

    def block(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], *, printed: bool) -> Block:
        return Block(np.array([x[0], y[0], z[0]]), np.array([x[1], y[1], z[1]]), printed)

    wide, reach = right - left, GRIPPER_REACH * (right - left)
    far, thick = WAFER * wide, ceiling - upper_face
    # The jaws are in front of the plate's sides and under its rim; the back is on top of it.
    jaw = (upper_face - 0.6 * thick, ceiling + 1.2 * thick)
    under = 0.35 * rim
    return (
        block((left - far, right + far), (front - far, back + far), (floor - wide, floor), printed=False),
        block((left, right), (front, back), (floor, lower_face), printed=True),
        block((left, right), (front, back), (upper_face, ceiling), printed=True),
        block((left - reach, left - 0.02 * wide), (front + rim, back - rim), jaw, printed=False),
        block((right + 0.02 * wide, right + reach), (front + rim, back - rim), jaw, printed=False),
        block((left - reach, left + under), (front + rim, back - rim), (jaw[0], upper_face), printed=False),
        block((right - under, right + reach), (front + rim, back - rim), (jaw[0], upper_face), printed=False),
        block((left - reach, right + reach), (front + rim, back - rim), (ceiling, jaw[1]), printed=False),
    )
