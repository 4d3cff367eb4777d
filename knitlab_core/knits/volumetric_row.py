"""Shape a row of volumetric stitches: wale loop and pile loop in turn, by arc length."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from knitlab_core.angles import cosine, sine
from knitlab_core.arrays import (  # noqa: TC001
    BoolArray,
    FloatArray,
    IndexArray,
)
from knitlab_core.knits.arclength import arc_table, derivatives

if TYPE_CHECKING:
    from knitlab_core.knits.loop_shape import LoopShape
    from knitlab_core.knits.volumetric_shape import VolumetricShape


class Spot(NamedTuple):
    """Return the loops on which some arc lengths are."""

    stitch: IndexArray
    pile: BoolArray
    """Whether each is on the stitch's pile loop."""
    t: FloatArray
    """The loop's own parameter, -pi to pi [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumetricRow:
    """Run through one row of stitches.

    Stitch j has its wale loop about ``x0 = 2 j`` and its pile loop about ``x0 + 1``. For t from -pi to pi, with the
    row's base line at ``(k w, m w_p)``:

    - wale loop: ``[x0 + (t + a sin 2t)/2pi, s (H_w/2)(1 + cos t), d (cos 2t - 1)]``
    - pile loop: ``[x0 + 1 + (t + a sin 2t)/2pi, d (cos 2t - 1), (H_p/2)(1 + cos t)]``

    Each is a loop of Eq. 1 that begins and ends on the base line with its tangent along +x, so they join C1.

    Parameters
    ----------
    stitch : VolumetricShape
        The stitch.
    row, layer : int
        Numbers k and m, from 0.
    loops : int
        Number of stitches.
    direction : {1, -1}
        +1 where the yarn runs with the course, -1 where it comes back.
    """

    stitch: VolumetricShape
    row: int
    layer: int
    loops: int
    direction: int

    @property
    def upward(self) -> int:
        """Return s: +1 where wale loops point along +y, -1 where they point along -y (every other layer)."""
        return wale_sign(self.layer)

    @property
    def length(self) -> float:
        """Return the arc length [loop widths]."""
        return self.loops * self._stitch_length

    def arc_length(self, stitch: IndexArray, *, pile: bool, t: FloatArray) -> FloatArray:
        """Return the arc length from the row's own start to parameters t of a loop of each stitch, all (n,)."""
        table = arc_table(self.stitch.pile_loop if pile else self.stitch.wale_loop)
        before = stitch * self._stitch_length + (self._wale_length if pile else 0.0)
        along: FloatArray = before + table.arc_length(t + np.pi)
        return along if self.direction > 0 else self.length - along

    def spot(self, s: FloatArray) -> Spot:
        """Return the loops and parameters at arc lengths from the row's own start, (n,)."""
        along = s if self.direction > 0 else self.length - s
        stitch = np.clip(np.floor(along / self._stitch_length), 0, self.loops - 1)
        within = along - stitch * self._stitch_length
        pile = within >= self._wale_length
        t = np.empty_like(along)
        t[~pile] = arc_table(self.stitch.wale_loop).parameter(within[~pile]) - np.pi
        t[pile] = arc_table(self.stitch.pile_loop).parameter(within[pile] - self._wale_length) - np.pi
        return Spot(stitch=stitch.astype(np.int64), pile=pile, t=t)

    def position(self, s: FloatArray) -> FloatArray:
        """Return points, (n,) -> (n, 3) [loop widths]."""
        spot, stitch = self.spot(s), self.stitch
        course = (spot.t + stitch.curvature * sine(2.0 * spot.t)) / (2.0 * np.pi)
        height = np.where(spot.pile, stitch.pile_height, stitch.wale_height)
        rise = 0.5 * height * (1.0 + cosine(spot.t))
        aside = stitch.depth * (cosine(2.0 * spot.t) - 1.0)
        position: FloatArray = self._turned(np.stack([course, rise, aside], axis=-1), spot.pile)
        position[:, 0] += 2.0 * spot.stitch + spot.pile
        position[:, 1:] += [self.row * stitch.row_spacing, self.layer * stitch.layer_spacing]
        return position

    def tangent(self, s: FloatArray) -> FloatArray:
        """Return unit tangents, (n,) -> (n, 3)."""
        first, _ = self._derivatives(s)
        tangent: FloatArray = self.direction * first / np.linalg.norm(first, axis=-1, keepdims=True)
        return tangent

    def curvature(self, s: FloatArray) -> FloatArray:
        """Return curvature vectors, (n,) -> (n, 3) [1/loop width].

        ``(gamma'' - T (T . gamma'')) / |gamma'|^2``, the same in both directions; it jumps at the feet.
        """
        first, second = self._derivatives(s)
        squared_speed = np.sum(first * first, axis=-1, keepdims=True)
        along = np.sum(first * second, axis=-1, keepdims=True) / squared_speed
        curvature: FloatArray = (second - along * first) / squared_speed
        return curvature

    def place(self, s: float) -> str:
        """Return layer, row, stitch and loop as text, counted from 0."""
        spot = self.spot(np.array([s]))
        loop = "pile" if spot.pile[0] else "wale"
        return f"layer {self.layer}, row {self.row}, stitch {spot.stitch[0]}, {loop} loop"

    @property
    def _wale_length(self) -> float:
        return arc_table(self.stitch.wale_loop).loop_length

    @property
    def _stitch_length(self) -> float:
        return self._wale_length + arc_table(self.stitch.pile_loop).loop_length

    def _derivatives(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        spot = self.spot(s)
        first, second = np.empty((s.size, 3)), np.empty((s.size, 3))
        kinds: tuple[tuple[BoolArray, LoopShape], ...]
        kinds = ((~spot.pile, self.stitch.wale_loop), (spot.pile, self.stitch.pile_loop))
        for chosen, loop in kinds:
            first[chosen], second[chosen] = derivatives(loop, spot.t[chosen])
        return self._turned(first, spot.pile), self._turned(second, spot.pile)

    def _turned(self, vectors: FloatArray, pile: BoolArray) -> FloatArray:
        """Return (course, rise, aside) of loops as (x, y, z): a wale loop rises along s y, a pile loop along z."""
        wale = vectors * [1.0, self.upward, 1.0]
        turned: FloatArray = np.where(pile[:, None], vectors[:, [0, 2, 1]], wale)
        return turned


def wale_sign(layer: int) -> int:
    """Return s of a layer: the first, third, ... are knitted along +y, the others along -y."""
    return -1 if layer % 2 else 1
