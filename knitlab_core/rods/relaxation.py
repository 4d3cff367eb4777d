"""Linear viscoelasticity of rod strains: a Prony series with one inner strain per term.

Every strain e of a rod (axial, two curvatures, twist, unevenness, each measured from rest) has the stress of the
hereditary integral over E(t) = E [1 - Σ g (1 - exp(-t/τ))]. With h = ∫ exp(-(t - s)/τ) de(s) per term,

    stress = C [g_inf e + Σ g h],   g_inf = 1 - Σ g.

Where e runs linearly in time over a step of duration Δt, exactly

    h_new = β h + γ (e_new - e),   β = exp(-Δt/τ),   γ = (1 - β) τ/Δt,

so that the stress is linear in e_new: within a step a relaxing rod is an elastic rod of other stiffness
and other rest strains (Taylor, Pister and Goudreau 1970, doi:10.1002/nme.1620020106). Strains live on material
frames, so that turning a rod changes nothing. Tension and shear relax alike: Poisson's ratio stays.
"""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.angles import exponential
from knitlab_core.arrays import FloatArray
from knitlab_core.materials import Material
from knitlab_core.rods.frames import Frames
from knitlab_core.rods.rod import Rods, measure_strains, measure_stretch

STRAINS = 5
"""Strains of a span: axial, two curvatures, twist, unevenness."""

FIRST_STEP = 0.1
"""First step of a hold, in shortest relaxation times."""

STEP_GROWTH = 1.5
"""How much longer each step of a hold is than the one before."""

_BRIEF = 1e-4

# Up to here the mean of a decay is summed as a series, of as many terms as rounding needs.
_SERIES, _TERMS = 0.5, 16


class Relaxation(NamedTuple):
    """Shares g (M,) [1] of the stiffness that relax, and in which times τ (M,) [s]."""

    shares: FloatArray
    times: FloatArray

    @classmethod
    def of(cls, material: Material) -> Self | None:
        """Return the series of a material, None where it has none."""
        if not material.relaxation:
            return None
        terms = material.relaxation
        return cls(np.array([t.share.value for t in terms]), np.array([t.time.value for t in terms]))

    @property
    def lasting(self) -> float:
        """Share of the stiffness that never relaxes, g_inf [1]."""
        return 1.0 - float(self.shares.sum())

    def unstrained(self, nodes: int) -> FloatArray:
        """Return the history (M, N, 5) of rods whose strains, if any, are so old that they have relaxed."""
        return np.zeros((self.shares.size, nodes, STRAINS))


def rod_strains(q: FloatArray, rods: Rods, frames: Frames) -> FloatArray:
    """Measure the strains of rods from rest.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and edge angles [rad].
    rods : Rods
        Rest state.
    frames : Frames
        Frames of `q`.

    Returns
    -------
    (N, 5) array
        Axial strain of the span of an inner node, or of the half edge at a rod's end [1]; both curvatures and the
        twist of a span, integrated over it [1]; its unevenness [1]. Zero where there is none.
    """
    stretch, curvature, twist = np.zeros((len(q), 2)), np.zeros((len(q), 2)), np.zeros(len(q))
    measure_stretch(rods, frames, stretch)
    measure_strains(q, rods.is_inner, frames, curvature, twist)
    strain = np.zeros((len(q), STRAINS))
    inner = rods.is_inner
    strain[:, [0, 4]] = stretch - rods.rest_stretch
    strain[inner, 1:3] = curvature[inner] - rods.rest_curvature[inner]
    strain[inner, 3] = twist[inner] - rods.rest_twist[inner]
    return strain


def relaxed_rods(rods: Rods, relaxation: Relaxation, strain: FloatArray, history: FloatArray, duration: float) -> Rods:
    """Make the elastic rods that stand for the relaxing ones during one step.

    Parameters
    ----------
    rods : Rods
        The rods at once, with their own rest shape.
    relaxation : Relaxation
        How they relax.
    strain : (N, 5) array
        Strains where the step begins.
    history : (M, N, 5) array
        Inner strains h there.
    duration : float
        Of the step [s]; 0 for a sudden one.

    Returns
    -------
    Rods
        With stiffness k C and rest strains moved by s/k, where stress = C (k e - s).
    """
    decay, gain = _decay_and_gain(relaxation, duration)
    share = relaxation.lasting + float(np.sum(relaxation.shares * gain))
    # Sum over terms of g (γ e - β h).
    moved = _over_terms(relaxation.shares * gain, np.broadcast_to(strain, history.shape))
    moved = (moved - _over_terms(relaxation.shares * decay, history)) / share
    return rods._replace(
        stretch_stiffness=rods.stretch_stiffness * share,
        bend_stiffness=rods.bend_stiffness * share,
        twist_stiffness=rods.twist_stiffness * share,
        rest_stretch=rods.rest_stretch + moved[:, [0, 4]],
        rest_curvature=rods.rest_curvature + moved[:, 1:3],
        rest_twist=rods.rest_twist + moved[:, 3],
    )


def remember(
    relaxation: Relaxation, history: FloatArray, before: FloatArray, after: FloatArray, duration: float
) -> FloatArray:
    """Return the history (M, N, 5) after a step from strains `before` to strains `after` (N, 5)."""
    decay, gain = _decay_and_gain(relaxation, duration)
    return np.asarray(decay[:, None, None] * history + gain[:, None, None] * (after - before))


def stored_energy(rods: Rods, relaxation: Relaxation, strain: FloatArray, history: FloatArray) -> FloatArray:
    """Return the energy ½ C (g_inf e² + Σ g h²) that stretching, bending and twisting store (3,) [E r^3]."""
    square = relaxation.lasting * strain**2 + _over_terms(relaxation.shares, history**2)
    part = 0.5 * (_moduli(rods) * square).sum(axis=0)
    return np.array([part[0] + part[4], part[1] + part[2], part[3]])


def elastic_energies(rods: Rods, strain: FloatArray) -> FloatArray:
    """Return what elastic rods store at every node by stretching, bending and twisting (N, 3) [E r^3]."""
    part = 0.5 * (_moduli(rods) * strain**2)
    return np.column_stack([part[:, 0] + part[:, 4], part[:, 1] + part[:, 2], part[:, 3]])


def viscous_work(
    rods: Rods,
    relaxation: Relaxation,
    history: FloatArray,
    before: FloatArray,
    after: FloatArray,
    duration: float,
) -> float:
    """Return the work C Σ g ∫ h²/τ dt that is lost in a step [E r^3].

    Parameters
    ----------
    rods, relaxation
        The rods at once, and how they relax.
    history : (M, N, 5) array
        Inner strains h where the step begins.
    before, after : (N, 5) arrays
        Strains where it begins and ends; they run linearly in time between.
    duration : float
        Of the step [s].
    """
    x = duration / relaxation.times
    once, twice = _mean_decay(x), _mean_decay(2.0 * x)
    # ∫ h²/τ dt = a h² + 2 b h d + c d² with d = after - before; short steps by the first term of their series.
    a, b, brief = x * twice, once - twice, x < _BRIEF
    c = np.where(brief, x / 3.0, (1.0 - 2.0 * once + twice) / np.where(brief, 1.0, x))
    a, b, c = (relaxation.shares * part for part in (a, b, c))
    d = after - before
    lost = _over_terms(a, history**2) + 2.0 * _over_terms(b, history) * d + float(c.sum()) * d**2
    return float(np.sum(_moduli(rods) * lost))


def hold_steps(relaxation: Relaxation | None, duration: float) -> tuple[float, ...]:
    """Divide a hold into steps that follow what relaxes.

    Parameters
    ----------
    relaxation : Relaxation or None
        None for elastic rods, which a hold leaves as they are.
    duration : float
        Of the hold [s].

    Returns
    -------
    tuple of float
        Durations of its steps [s], each `STEP_GROWTH` times the one before, beginning with at most `FIRST_STEP`
        of the shortest relaxation time. One step for elastic rods.
    """
    if relaxation is None:
        return (duration,)
    first = FIRST_STEP * float(relaxation.times.min())
    steps = [first]
    while sum(steps) < duration * (1.0 - 1e-9):
        steps.append(STEP_GROWTH * steps[-1])
    whole = sum(steps)
    return tuple(step * (duration / whole) for step in steps)


def _decay_and_gain(relaxation: Relaxation, duration: float) -> tuple[FloatArray, FloatArray]:
    """Return β and γ (M,) of a step."""
    x = duration / relaxation.times
    return np.array([exponential(-float(one)) for one in x]), _mean_decay(x)


def _mean_decay(x: FloatArray) -> FloatArray:
    """Return the mean (1 - exp(-x))/x of the decay over a step."""
    return np.array([_mean_decay_of(float(one)) for one in x])


def _mean_decay_of(x: float) -> float:
    if x > _SERIES:
        return (1.0 - exponential(-x)) / x
    # 1 - x/2 (1 - x/3 (1 - ...)), to rounding.
    mean = 1.0
    for k in range(_TERMS, 1, -1):
        mean = 1.0 - x / k * mean
    return mean


def _over_terms(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Return the sum (N, 5) over the terms of a series; BLAS adds in an order that depends on the processor."""
    total: FloatArray = np.sum(weights[:, None, None] * values, axis=0)
    return total


def _moduli(rods: Rods) -> FloatArray:
    """Return the weights (N, 5) of the squared strains in twice the energy [E r^3]."""
    weights = np.zeros((rods.span.size, STRAINS))
    inner = rods.is_inner
    weights[:, 0] = rods.stretch_stiffness * rods.stretched
    weights[inner, 1] = weights[inner, 2] = rods.bend_stiffness[inner] / rods.span[inner]
    weights[inner, 3] = rods.twist_stiffness[inner] / rods.span[inner]
    weights[:, 4] = rods.stretch_stiffness * rods.evenness
    return weights
