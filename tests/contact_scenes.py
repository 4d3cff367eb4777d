"""Strands in contact, shared by the tests of contact: in solver units, r = E = 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.contact.forces import contact_energy, contact_gradient, lag
from knitlab_core.contact.friction import Memory, recall
from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.contact.samples import sample_points
from knitlab_core.equilibrium.model import SAMPLE_SPACING, make_model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.arrays import FloatArray
    from knitlab_core.contact.forces import PairState
    from knitlab_core.contact.neighbours import Candidates
    from knitlab_core.equilibrium.model import Model, State

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
    strands: Sequence[FloatArray], friction: float = 0.0, *, sample_spacing: float = SAMPLE_SPACING
) -> tuple[Model, State]:
    """Make a model of unit radius and modulus."""
    return make_model(
        strands,
        radius=1.0,
        young_modulus=1.0,
        poisson_ratio=POISSON_RATIO,
        friction=friction,
        sample_spacing=sample_spacing,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """Pairs of a model as they stand between a last equilibrium and now."""

    model: Model
    base: FloatArray
    candidates: Candidates
    pairs: PairState

    def points(self, q: FloatArray) -> FloatArray:
        """Return the samples (N m, 3)."""
        return sampled(self.model, q)

    def energies(self, q: FloatArray) -> tuple[float, float]:
        """Return normal and frictional energy."""
        m = self.model
        return contact_energy(self.points(q), self.base, self.candidates, m.samples.length, m.law, self.pairs)

    def energy(self, q: FloatArray) -> float:
        """Return their sum."""
        return sum(self.energies(q))

    def gradient(self, q: FloatArray) -> FloatArray:
        """Return the gradient (N, 4)."""
        m = self.model
        out = np.zeros_like(q)
        contact_gradient(self.points(q), self.base, self.candidates, m.samples, m.law, self.pairs, out)
        return out

    def lag(self, q: FloatArray) -> int:
        """Take loads and normals from `q`."""
        return lag(self.points(q), self.candidates, self.model.samples.length, self.model.law, self.pairs)


def sampled(model: Model, q: FloatArray) -> FloatArray:
    """Return the samples (N m, 3); rows of nodes without a span are zero."""
    points = np.zeros((len(q) * len(model.samples.weights), 3))
    sample_points(q, model.samples, points)
    return points


def touch(model: Model, q: FloatArray, skin: float = 1.0) -> Touch:
    """List the pairs at `q`, which becomes the last equilibrium and gives loads and normals."""
    candidates = find_candidates(q, model.samples, model.law, skin)
    base = sampled(model, q)
    found = Touch(model=model, base=base, candidates=candidates, pairs=recall(Memory.empty(), candidates, len(base)))
    found.lag(q)
    return found
