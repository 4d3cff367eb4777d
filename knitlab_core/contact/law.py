"""Normal contact law: a line potential whose double integral is Hertz's force.

Two samples that stand for lengths wa and wb of two centrelines and overlap by p
store wa wb psi(p). For cylinders crossed at right angles the double integral
collapses to F(delta) = 2 pi (D - delta) psi(delta), so that
psi(p) = E* / (3 pi sqrt(r)) p^(3/2) / (1 - p / D), with E* = E / (2 (1 - nu^2)),
is Hertz's F = 4/3 E* sqrt(r) delta^(3/2) exactly. Around touch the power 3/2 is
replaced by a cubic that begins a little before (see `pair_potential`).
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel


class ContactLaw(NamedTuple):
    """Constants of contact and friction, scaled by r and E.

    `coefficient`: of psi; `distance`: of two centrelines that touch; `onset`:
    gap at which the force begins, and overlap from which it is Hertz's; `reach`:
    distance plus onset; `overlap_limit`: where the barrier is infinite; `friction`: coefficient mu; `slip`: elastic
    slip before sliding; `exclusion`: arc length within which samples of one
    strand are not paired.
    """

    coefficient: float
    distance: float
    onset: float
    reach: float
    overlap_limit: float
    friction: float
    slip: float
    exclusion: float


def make_law(poisson_ratio: float, friction: float, *, onset: float = 0.04, slip: float = 0.02) -> ContactLaw:
    """Make the contact law of like fibres of unit radius and modulus."""
    effective_modulus = 0.5 / (1.0 - poisson_ratio**2)
    return ContactLaw(
        coefficient=effective_modulus / (3.0 * np.pi),
        distance=2.0,
        onset=onset,
        reach=2.0 + onset,
        overlap_limit=1.0,
        friction=friction,
        slip=slip,
        exclusion=np.pi,
    )


@inline_kernel
def pair_potential(p: float, law: ContactLaw) -> tuple[float, float, float]:
    """Return psi, psi' and psi'' at overlap p > -onset.

    psi = c f(p) b(p) with f = p^(3/2) from p = onset on and the cubic
    (p + onset)^3 / (4 onset)^(3/2) below, which meets it in value and slope, and
    b = 1 / (1 - p / D) / (1 - (p / p_max)^4): exact Hertz, and a barrier.
    """
    s = law.onset
    if p < s:
        g = 1.0 / (4.0 * s * sqrt(4.0 * s))
        t = p + s
        f, f1, f2 = g * t * t * t, 3.0 * g * t * t, 6.0 * g * t
    else:
        root = sqrt(p)
        f, f1, f2 = p * root, 1.5 * root, 0.75 / root
    u = 1.0 / (law.distance - p)
    x = p / law.overlap_limit
    v = 1.0 / (1.0 - x * x * x * x)
    v1 = 4.0 * x * x * x / law.overlap_limit
    v2 = 12.0 * x * x / (law.overlap_limit * law.overlap_limit)
    # b = D u v, and (log b)' = u + v v1.
    b = law.distance * u * v
    h = u + v * v1
    b1 = b * h
    b2 = b * (h * h + u * u + v * v2 + v * v * v1 * v1)
    c = law.coefficient
    return c * f * b, c * (f1 * b + f * b1), c * (f2 * b + 2.0 * f1 * b1 + f * b2)


def sample_weights(m: int) -> FloatArray:
    """Weights (m, 3) of a span's three nodes at its m midpoint-rule samples.

    Uniform quadratic B-spline: (1 - u)^2 / 2, 1/2 + u (1 - u), u^2 / 2.
    """
    u = (np.arange(m) + 0.5) / m
    return np.column_stack([0.5 * (1 - u) ** 2, 0.5 + u * (1 - u), 0.5 * u**2])
