"""Curves known in closed form, as pieces of a yarn: a straight line, an arc, a helix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.knits import Centreline

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.knits.pieces import Piece


@dataclass(frozen=True, slots=True, kw_only=True)
class Straight:
    """Run along +x from a point."""

    length: float
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def position(self, s: FloatArray) -> FloatArray:
        points: FloatArray = np.stack([s, 0.0 * s, 0.0 * s], axis=-1) + np.array(self.start)
        return points

    def tangent(self, s: FloatArray) -> FloatArray:
        return np.tile([1.0, 0.0, 0.0], (s.size, 1))

    def curvature(self, s: FloatArray) -> FloatArray:
        return np.zeros((s.size, 3))

    def place(self, s: float) -> str:
        return f"straight at {s:.3g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Bend:
    """Turn by an angle in the x-y plane: to the left of the heading where `side` is 1, to the right where -1."""

    radius: float
    angle: float
    side: int = 1
    start: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0

    @property
    def length(self) -> float:
        return self.radius * self.angle

    def position(self, s: FloatArray) -> FloatArray:
        turned = self.heading + self.side * s / self.radius
        x = self.side * self.radius * (np.sin(turned) - np.sin(self.heading))
        y = -self.side * self.radius * (np.cos(turned) - np.cos(self.heading))
        return np.stack([self.start[0] + x, self.start[1] + y, 0.0 * s], axis=-1)

    def tangent(self, s: FloatArray) -> FloatArray:
        turned = self.heading + self.side * s / self.radius
        return np.stack([np.cos(turned), np.sin(turned), 0.0 * s], axis=-1)

    def curvature(self, s: FloatArray) -> FloatArray:
        turned = self.heading + self.side * s / self.radius
        return self.side / self.radius * np.stack([-np.sin(turned), np.cos(turned), 0.0 * s], axis=-1)

    def place(self, s: float) -> str:
        return f"bend at {s:.3g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Helix:
    """Wind around x at a radius, rising by `rise` per radian."""

    radius: float
    rise: float
    length: float

    @property
    def speed(self) -> float:
        return float(np.hypot(self.radius, self.rise))

    def position(self, s: FloatArray) -> FloatArray:
        t = s / self.speed
        return np.stack([self.rise * t, self.radius * np.cos(t), self.radius * np.sin(t)], axis=-1)

    def tangent(self, s: FloatArray) -> FloatArray:
        t = s / self.speed
        along = np.stack([self.rise + 0.0 * t, -self.radius * np.sin(t), self.radius * np.cos(t)], axis=-1)
        return along / self.speed

    def curvature(self, s: FloatArray) -> FloatArray:
        t = s / self.speed
        return -self.radius / self.speed**2 * np.stack([0.0 * t, np.cos(t), np.sin(t)], axis=-1)

    def place(self, s: float) -> str:
        return f"helix at {s:.3g}"


def yarn_of(*pieces: Piece) -> Centreline:
    """String pieces to a yarn without sites."""
    return Centreline(pieces=pieces, sites=())


def double_bend(radius: float = 1.0) -> Centreline:
    """Make an S of two quarter circles: curvature jumps to its opposite half-way."""
    first = Bend(radius=radius, angle=0.5 * np.pi)
    second = Bend(radius=radius, angle=0.5 * np.pi, side=-1, start=(radius, radius), heading=0.5 * np.pi)
    return yarn_of(first, second)
