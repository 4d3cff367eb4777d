"""Normal contact laws: a line potential whose double integral is Hertz's force, or that of a yarn that is compressed.

Two samples that stand for lengths wa and wb of two centrelines and overlap by p
store wa wb psi(p). For cylinders crossed at right angles the double integral
collapses to F(delta) = 2 pi (D - delta) psi(delta), so that
psi(p) = E* / (3 pi sqrt(r)) p^(3/2) / (1 - p / D), with E* = E / (2 (1 - nu^2)),
is Hertz's F = 4/3 E* sqrt(r) delta^(3/2) exactly. Around touch the power 3/2 is
replaced by a polynomial that begins a little before, but never where strands were
printed: those feel nothing (see `pair_potential` and `law_as_printed`).

A yarn by measurement has psi(p) = c [p / (w - p)]^n instead, with w the overlap at which cores meet: soft where yarns
begin to touch, c halfway to the core, and without bound there.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from knitlab_core.angle_kernels import power
from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel


class ContactLaw(NamedTuple):
    """Constants of contact and friction, scaled by r and E.

    `coefficient`: of psi, for a yarn psi halfway to the core; `exponent`: n of a yarn, 0 for Hertz's law;
    `distance`: of two centrelines that touch; `onset`:
    gap at which the force begins, from 0 to `rounding`; `rounding`: overlap from which it is Hertz's; `rise`: what is
    between, see there; `reach`: distance plus onset; `overlap_limit`: where the barrier is infinite; `friction`:
    coefficient mu; `slip`: elastic slip before sliding; `exclusion`: arc length within which samples of one strand
    are not paired.
    """

    coefficient: float
    distance: float
    onset: float
    rounding: float
    rise: tuple[float, float, float, float]
    reach: float
    overlap_limit: float
    friction: float
    slip: float
    exclusion: float
    exponent: float = 0.0


def make_law(poisson_ratio: float, friction: float, *, onset: float = 0.04, slip: float = 0.02) -> ContactLaw:
    """Make the contact law of like fibres of unit radius and modulus."""
    effective_modulus = 0.5 / (1.0 - poisson_ratio**2)
    return ContactLaw(
        coefficient=effective_modulus / (3.0 * np.pi),
        distance=2.0,
        onset=onset,
        rounding=onset,
        rise=rise(onset, onset),
        reach=2.0 + onset,
        overlap_limit=1.0,
        friction=friction,
        slip=slip,
        exclusion=np.pi,
    )


def make_yarn_law(
    coefficient: float, exponent: float, core: float, friction: float, *, slip: float = 0.02
) -> ContactLaw:
    """Make the contact law of like yarns of unit radius that are compressed down to a core.

    Parameters
    ----------
    coefficient : float
        psi halfway to the core [E r].
    exponent : float
        n: psi grows as (1 - p / w)^(-n) near the core; 2 or more, so that psi'' is finite [1].
    core : float
        Radius to which a yarn can be compressed [r].
    friction, slip : float
        Coulomb's coefficient [1], and elastic slip before sliding [r].
    """
    return ContactLaw(
        coefficient=coefficient,
        distance=2.0,
        onset=0.0,
        rounding=0.0,
        rise=(0.0, 0.0, 0.0, 0.0),
        reach=2.0,
        overlap_limit=2.0 * (1.0 - core),
        friction=friction,
        slip=slip,
        exclusion=np.pi,
        exponent=exponent,
    )


def law_as_printed(law: ContactLaw, least: float) -> ContactLaw:
    """Return the law with which strands feel nothing as printed, however near each other.

    The force begins at the printed gap where that is narrower than the onset. Samples of a coarse mesh may overlap
    where the yarn does not: then strands touch at the distance they were printed at.

    Parameters
    ----------
    law : ContactLaw
        Of strands printed far apart.
    least : float
        Least distance of two samples as printed [r].
    """
    if least >= law.reach:
        return law
    distance = min(law.distance, least)
    if law.exponent > 0.0:  # cores stay as they are
        limit = law.overlap_limit - (law.distance - distance)
        return law._replace(distance=distance, reach=distance, overlap_limit=limit)
    onset = least - distance
    return law._replace(distance=distance, onset=onset, rise=rise(onset, law.rounding), reach=least)


def scaled_law(law: ContactLaw, size: float, force: float = 1.0) -> ContactLaw:
    """Return a contact law with its distances multiplied by one factor and its potential by another [1]."""
    return law._replace(
        coefficient=force * law.coefficient,
        distance=size * law.distance,
        reach=size * law.distance + law.onset,
        overlap_limit=size * law.overlap_limit,
    )


def rise(onset: float, rounding: float) -> tuple[float, float, float, float]:
    """Return the coefficients of x^3 to x^6, x = p + onset, with which f rises to Hertz's p^(3/2) at p = rounding.

    With g the onset, s the rounding, a = g / s and t = x / (s + g), f = s^(3/2) t^3 (a + (1 - a)(5 - 15/2 t +
    9/2 t^2 - t^3)). It begins without stiffness, meets p^(3/2) in value and slope, and is convex between: f'' is
    3 s^(3/2) / (s + g)^2 times 2 a t + 10 (1 - a) t (1 - t)^3. At a = 1 it is a cubic; at a = 0 its largest
    stiffness is 2.1 times the cubic's, where p^(3/2) itself has infinite stiffness.
    """
    width = rounding + onset
    narrow = 2.0 * rounding / width
    cubic = 1.0 / (4.0 * rounding * sqrt(4.0 * rounding)) * (narrow * narrow * narrow)
    late = cubic * (1.0 - onset / rounding)
    return cubic + 4.0 * late, -7.5 * late / width, 4.5 * late / width**2, -late / width**3


@inline_kernel
def compressed(p: float, coefficient: float, exponent: float, limit: float) -> tuple[float, float, float]:
    """Return psi, psi' and psi'' of a yarn at overlap p from 0 to below the limit w, at which cores meet."""
    if p <= 0.0:
        return 0.0, 0.0, 0.0
    x = p / limit
    z = 1.0 / (1.0 - x)
    # psi = c (x z)^n; its slope in x is n c (x z)^(n - 1) z^2.
    before = coefficient * power(x * z, exponent - 2.0)
    first = exponent * z * z / limit
    second = first * z * z / limit
    return before * x * x * z * z, before * first * x * z, before * second * (exponent - 1.0 + 2.0 * x)


@inline_kernel
def pair_potential(p: float, law: ContactLaw) -> tuple[float, float, float]:
    """Return psi, psi' and psi'' at overlap p > -onset.

    psi = c f(p) b(p) with f = p^(3/2) from p = `rounding` on and the polynomial of `rise` below, and
    b = 1 / (1 - p / D) / (1 - (p / p_max)^4): exact Hertz, and a barrier. Of a yarn it is `compressed`.
    """
    if law.exponent > 0.0:
        return compressed(p, law.coefficient, law.exponent, law.overlap_limit)
    s = law.rounding
    if p < s:
        x = p + law.onset
        c3, c4, c5, c6 = law.rise
        f = (c3 + x * (c4 + x * (c5 + x * c6))) * x * x * x
        f1 = (3.0 * c3 + x * (4.0 * c4 + x * (5.0 * c5 + x * (6.0 * c6)))) * x * x
        f2 = (6.0 * c3 + x * (12.0 * c4 + x * (20.0 * c5 + x * (30.0 * c6)))) * x
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
