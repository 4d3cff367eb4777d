"""Fused points: bonds where strands were printed so near that they grew together, until they break.

A bond is a round neck of radius a between the surfaces of two strands. Each strand carries along the neck's
middle and its cross-section, by the rotation R of its own material frame since printing. What the two disagree
by is w0 = xa - xb - (Ra + Rb) r0 / 2 in place and w1, w2 = a (Ra - Rb) e1,2 / 2 in direction, with r0 the printed
line between the centrelines and e1, e2 across it. The bond stores k (w0^2 + w1^2 + w2^2) / 2: a disc of even
springs (stiffness k against pull and shear, k a^2 / 4 against tilt, k a^2 / 2 against twist), without stress as
printed, and blind to rigid motion.

The stiffness is that of a neck of length g, the printed gap, between two half-spaces,
k = E A / (g + pi (1 - nu^2) a), A = pi a^2: E a / (1 - nu^2) where strands touch (Johnson 1985, section 3.5,
a bonded or flat punch of radius a on a like solid), E A / g for a long neck. Shear is taken to be as stiff as
pull; on half-spaces it is 2 (1 - nu) / (2 - nu) = 0.77 of it (Mindlin 1949).
"""

from itertools import product
from math import inf, pi, sqrt
from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.contact.law import ContactLaw
from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.contact.samples import Samples, sample_points
from knitlab_core.contact.slip import material_frames
from knitlab_core.rods.frames import Frames
from knitlab_core.units import Scales

ONE_CROSSING = 2.0
"""Arc length on both strands within which two closest points are the same crossing [r]."""

_TIE = 1e-9


class Bonds(NamedTuple):
    """Every bond as printed, in the solver's units.

    `span_a`, `span_b`: (B,) inner nodes, a < b; `a`, `b`: (B,) samples i m + k;
    `arms`: (B, 3, 3) printed line r0 from b to a, and a e1, a e2 across it [r];
    `stiffness`: (B,) k [E r]; `frames`: (N, 3, 3) printed material frames; `radius`: of a neck [r];
    `strength`, `shear_strength`: [E]; `locate`: see `BondLaw`.
    """

    span_a: IndexArray
    span_b: IndexArray
    a: IndexArray
    b: IndexArray
    arms: FloatArray
    stiffness: FloatArray
    frames: FloatArray
    radius: float
    strength: float
    shear_strength: float
    locate: float

    def held(self, hold: FloatArray) -> Self:
        """Return the bonds that hold at all, with the share (B,) of their stiffness that is left."""
        chosen = hold > 0.0
        return self._replace(
            span_a=self.span_a[chosen],
            span_b=self.span_b[chosen],
            a=self.a[chosen],
            b=self.b[chosen],
            arms=self.arms[chosen],
            stiffness=hold[chosen] * self.stiffness[chosen],
        )


class BondState(NamedTuple):
    """State of the bonds at an equilibrium.

    `hold`: (B,) 1 for whole bonds, 0 for broken ones, between only while a break is followed; `load`: (B,) share
    of its strength that a bond bears, 0 for broken ones; `energy`: stored in bonds; `released`: energy lost by
    breaking since the start, that of the bonds and what the strands lose as they snap back [E r^3].
    """

    hold: FloatArray
    load: FloatArray
    energy: float
    released: float

    @classmethod
    def printed(cls, count: int) -> Self:
        """Return the state as printed: all whole, none loaded."""
        return cls(np.ones(count), np.zeros(count), 0.0, 0.0)

    @property
    def whole(self) -> BoolArray:
        """Return which bonds (B,) are not broken."""
        return self.hold > 0.0


def find_bonds(
    q: FloatArray,
    frames: Frames,
    has_edge: BoolArray,
    samples: Samples,
    contact: ContactLaw,
    law: BondLaw,
    scales: Scales,
    poisson_ratio: float,
) -> Bonds:
    """Find the fused points of a printed configuration: one where two strands come closest, if near enough.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and angles as printed.
    frames : Frames
        Its reference frames.
    has_edge : (N,) bool array
        True where an edge runs from node i to node i + 1.
    samples, contact, law
        Contact samples and contact law, and the law of the bonds.
    scales : Scales
        What one solver unit is in SI.
    poisson_ratio : float
        For the compliance of the strands about a neck.
    """
    radius = law.patch_radius / scales.length
    m = len(samples.weights)
    points = np.zeros((len(q) * m, 3))
    sample_points(q, samples, points)
    candidates = find_candidates(q, samples, contact, law.fuse_gap / scales.length)
    a, b = _closest_pairs(candidates.a, candidates.b, points, samples, max(2.0 * radius, ONE_CROSSING))
    arm = points[a] - points[b]
    distance = np.linalg.norm(arm, axis=1)
    gap = np.maximum(distance - contact.distance, 0.0)
    printed = np.zeros((len(q), 3, 3))
    material_frames(q, has_edge, frames, printed)
    shear_strength = law.strength / sqrt(3.0) if law.shear_strength is None else law.shear_strength
    return Bonds(
        span_a=a // m,
        span_b=b // m,
        a=a,
        b=b,
        arms=np.stack([arm, *_across(arm / distance[:, None], radius)], axis=1),
        stiffness=pi * radius**2 / (gap + pi * (1.0 - poisson_ratio**2) * radius),
        frames=printed,
        radius=radius,
        strength=law.strength / scales.young_modulus,
        shear_strength=shear_strength / scales.young_modulus,
        locate=law.locate,
    )


def _across(normal: FloatArray, length: float) -> tuple[FloatArray, FloatArray]:
    """Return two vectors (B, 3) of a length across unit vectors (B, 3) and each other."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    first *= length / np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)


def _closest_pairs(
    a: IndexArray, b: IndexArray, points: FloatArray, samples: Samples, apart: float
) -> tuple[IndexArray, IndexArray]:
    """Keep the sample pairs nearer than those around them; of several within `apart` on both strands the nearest."""
    m = len(samples.weights)
    inner = np.zeros(len(samples.length), dtype=np.bool_)
    inner[samples.spans] = True

    def distance(first: IndexArray, second: IndexArray) -> FloatArray:
        apart = np.linalg.norm(points[first] - points[second], axis=1)
        return np.where(inner[first // m] & inner[second // m], apart, inf)

    own = distance(a, b)
    lowest = np.ones(a.size, dtype=np.bool_)
    for i, j in product((-1, 0, 1), repeat=2):
        # Pairs of one strand that are excluded from contact count here: next to them is no closest point.
        lowest &= own <= distance(a + i, b + j) + _TIE
    a, b, own = a[lowest], b[lowest], own[lowest]
    order = np.lexsort((b, a, np.round(own / _TIE)))
    a, b = a[order], b[order]
    every = np.arange(len(points))
    place = samples.arc[every // m] + ((every % m + 0.5) / m - 0.5) * samples.length[every // m] * m
    # Strands lie end to end in `arc`: told apart by more than any crossing is wide.
    place += 2.0 * apart * samples.strand[every // m]
    kept: list[int] = []
    for p in range(a.size):
        near = (np.abs(place[a[kept]] - place[a[p]]) < apart) & (np.abs(place[b[kept]] - place[b[p]]) < apart)
        if not near.any():
            kept.append(p)
    chosen = np.array(kept, dtype=np.int64)
    chosen = chosen[np.lexsort((b[chosen], a[chosen]))]
    return a[chosen], b[chosen]
