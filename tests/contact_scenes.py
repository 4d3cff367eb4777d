"""Strands in contact, shared by the tests of contact: in solver units, r = E = 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.contact.forces import (
    contact_energy,
    contact_gradient,
    elastic_slip,
    friction_energy,
    friction_gradient,
    lag,
)
from knitlab_core.contact.friction import Memory, recall, settle
from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.contact.samples import sample_points
from knitlab_core.contact.slip import Placed, material_frames, opened, place_edges
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.strands import SAMPLE_SPACING
from knitlab_core.rods.frames import follow

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.arrays import FloatArray
    from knitlab_core.contact.forces import PairState
    from knitlab_core.contact.pairs import Candidates
    from knitlab_core.equilibrium.model import Model, State
    from knitlab_core.rods.frames import Frames

POISSON_RATIO: Final = 0.37
EDGE: Final = 2.0
"""Edge length of a knit of 48 nodes a loop [r], nearly."""

EFFECTIVE_MODULUS: Final = 0.5 / (1.0 - POISSON_RATIO**2)


def hertz(indentation: float) -> float:
    """Return Hertz's force [E r^2] of like cylinders crossed at right angles (Johnson 1985, eq. 4.23)."""
    return float(4.0 / 3.0 * EFFECTIVE_MODULUS * indentation**1.5)


def straight(centre: Sequence[float], direction: Sequence[float], length: float, edge: float = EDGE) -> FloatArray:
    """Return the nodes (n, 3) of a straight strand."""
    n = round(length / edge) + 1
    along = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    steps = np.arange(n) - (n - 1) / 2
    return np.add(centre, np.outer(steps * edge, along))


def unit_model(
    strands: Sequence[FloatArray],
    friction: float = 0.0,
    *,
    sample_spacing: float = SAMPLE_SPACING,
    printed: bool = False,
) -> tuple[Model, State]:
    """Make a model of unit radius and modulus."""
    return make_model(
        strands,
        radius=1.0,
        young_modulus=1.0,
        poisson_ratio=POISSON_RATIO,
        friction=friction,
        sample_spacing=sample_spacing,
        printed=printed,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """Pairs of a model as they stand between a last equilibrium and now.

    `frames` are those of the last equilibrium, `base` its samples and `base_frames` (N, 3, 3) its material frames.
    """

    model: Model
    base: FloatArray
    frames: Frames
    base_frames: FloatArray
    candidates: Candidates
    pairs: PairState

    def follow(self, q: FloatArray, source: Frames | None = None) -> Frames:
        """Return the frames at `q`, carried there from `source`, by default from the last equilibrium."""
        source = self.frames if source is None else source
        target = source.copy()
        follow(q, self.model.rods.has_edge, source, target)
        return target

    def placed(self, q: FloatArray, source: Frames | None = None) -> Placed:
        """Return samples and edges at `q`."""
        found = Placed.zeros(len(q), len(self.base))
        sample_points(q, self.model.samples, found.points)
        place_edges(q, self.model.rods.has_edge, self.follow(q, source), self.base_frames, found)
        return found

    def energies(self, q: FloatArray, source: Frames | None = None) -> tuple[float, float]:
        """Return normal and frictional energy."""
        m = self.model
        placed = self.placed(q, source)
        normal = contact_energy(placed.points, self.candidates, m.samples.length, m.law)
        return normal, friction_energy(placed, self.candidates, m.law, self.pairs)

    def energy(self, q: FloatArray, source: Frames | None = None) -> float:
        """Return their sum."""
        return sum(self.energies(q, source))

    def gradient(self, q: FloatArray, source: Frames | None = None) -> FloatArray:
        """Return the gradient (N, 4)."""
        m = self.model
        out = np.zeros_like(q)
        placed = self.placed(q, source)
        contact_gradient(placed.points, self.candidates, m.samples, m.law, out)
        friction_gradient(placed, self.candidates, m.samples, m.law, self.pairs, out)
        return out

    def openings(self, q: FloatArray, source: Frames | None = None) -> FloatArray:
        """Return what has opened between every pair's points (P, 3) since its anchor."""
        placed, m = self.placed(q, source), len(self.model.samples.weights)
        pairs = zip(self.candidates.a, self.candidates.b, self.pairs.anchor, strict=True)
        return np.array([opened(int(a), int(b), m, placed, tuple(anchor)) for a, b, anchor in pairs])

    def slips(self, q: FloatArray, source: Frames | None = None) -> FloatArray:
        """Return the elastic slip (P, 3) of every pair."""
        placed, m = self.placed(q, source), len(self.model.samples.weights)
        pairs = zip(self.candidates.a, self.candidates.b, strict=True)
        return np.array([elastic_slip(p, int(a), int(b), m, placed, self.pairs) for p, (a, b) in enumerate(pairs)])

    def lag(self, q: FloatArray) -> int:
        """Take loads and normals from `q`."""
        m = self.model
        return lag(self.placed(q), self.candidates, m.samples.length, m.law, self.pairs)

    def settle(self, q: FloatArray) -> tuple[Memory, float]:
        """Accept `q`, whose loads are lagged, as an equilibrium; return friction's memory and work."""
        return settle(self.placed(q), self.base, self.candidates, self.model.law, self.pairs)


def sampled(model: Model, q: FloatArray) -> FloatArray:
    """Return the samples (N m, 3); rows of nodes without a span are zero."""
    points = np.zeros((len(q) * len(model.samples.weights), 3))
    sample_points(q, model.samples, points)
    return points


def touch(
    model: Model, state: State, *, memory: Memory | None = None, q: FloatArray | None = None, skin: float = 1.0
) -> Touch:
    """List the pairs at a state or at another place `q`, which becomes the last equilibrium; recall its memory.

    With no memory given the place also gives loads and normals.
    """
    has_edge = model.rods.has_edge
    frames = state.frames.copy()
    q = state.q if q is None else q
    follow(q, has_edge, state.frames, frames)
    base_frames = np.zeros((len(q), 3, 3))
    material_frames(q, has_edge, frames, base_frames)
    candidates = find_candidates(q, model.samples, model.law, skin)
    base = sampled(model, q)
    found = Touch(
        model=model,
        base=base,
        frames=frames,
        base_frames=base_frames,
        candidates=candidates,
        pairs=recall(Memory.empty() if memory is None else memory, candidates, base),
    )
    if memory is None:
        found.lag(q)
    return found
