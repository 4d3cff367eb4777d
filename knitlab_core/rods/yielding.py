"""Section of a fibre that yields: what plastic flow takes from the energy, forces and stiffness of an elastic one.

A round section is integrated over points, each in uniaxial stress. A point is elements in parallel (Besseling 1958;
Iwan 1967, doi:10.1115/1.3607751): element k has the share s_k of Young's modulus and flows where its elastic strain
reaches the limit y_k; the rest of the modulus stays elastic. Such a point follows a piecewise linear, concave curve of
stress over strain, and unloads by Masing's rule, as kinematic hardening does. Over a step from plastic strain p the
strain e has the incremental potential

    s [H(e - p; y)],   H(x; y) = x^2 / 2 up to |x| = y, y |x| - y^2 / 2 beyond,

which is Huber's function, convex, and whose second derivative is the consistent tangent (Simo and Hughes 1998, ch. 1).
All here is written as relief: what an elastic section has and this one lacks, so that a section which nowhere yields
costs nothing. Axial strain and both curvatures act on the same points; twist has its own, by the shear strain along
the radius, and von Mises' shear limit: the two do not soften each other.
With a Prony series the plastic section is the lasting part of the stiffness, beside viscous parts that do not yield
(as in Abaqus' parallel rheological framework): the yield is that of the relaxed stress.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from knitlab_core.angles import cosines_sines
from knitlab_core.arrays import BoolArray, FloatArray  # noqa: TC001 (kernels read them)
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.rod import Rods  # noqa: TC001 (kernels read it)

if TYPE_CHECKING:
    from knitlab_core.materials import Material
    from knitlab_core.rods.section import Section

RINGS: Final = 5
"""Rings of points in a section, by Gauss's rule in the squared radius; also points along the radius for twist."""

PER_RING: Final = 11
"""Points in a ring, an odd number; each ring is turned by a fifth of a point's angle against the one inside it.

The moment of an elastic, perfectly plastic section then errs by at most 0.48 % at any curvature in any direction;
4 rings of 16 err by 0.77 %, 48 points on a spiral by 2.3 %.
"""

_INNER, _OUTER = (sqrt(5.0 + sign * 2.0 * sqrt(10.0 / 7.0)) / 3.0 for sign in (-1.0, 1.0))
_HEAVY, _LIGHT = ((322.0 + sign * 13.0 * sqrt(70.0)) / 900.0 for sign in (1.0, -1.0))
GAUSS: Final = np.array([-_OUTER, -_INNER, 0.0, _INNER, _OUTER])
GAUSS_WEIGHTS: Final = np.array([_LIGHT, _HEAVY, 128.0 / 225.0, _HEAVY, _LIGHT])
"""Gauss's rule of five points on [-1, 1], in closed form: an eigenvalue solver's last bits depend on the processor."""

POINTS: Final = RINGS * PER_RING
"""Points of a section for axial strain and bending."""


class Yielding(NamedTuple):
    """How sections yield, scaled by r and E.

    `y`, `z`: (P,) places of the points across the curvatures' axes [r]; `weight`: (P,) area [r^2]; `radius`: (R,) of
    the points for twist [r]; `shear_weight`: (R,) area times G / E [r^2]. `share`: (K,) shares of the modulus that
    yield; `limit`, `shear_limit`: (K,) elastic strains from which each does [1]. `reach`: largest radius of a point
    for bending [r].
    """

    y: FloatArray
    z: FloatArray
    weight: FloatArray
    radius: FloatArray
    shear_weight: FloatArray
    share: FloatArray
    limit: FloatArray
    shear_limit: FloatArray
    reach: float

    def unstrained(self, nodes: int) -> FloatArray:
        """Return the plastic strains (N, K, P + R) of sections that never yielded."""
        return np.zeros((nodes, self.share.size, self.y.size + self.radius.size))


def make_yielding(material: Material, section: Section, lasting: float) -> Yielding | None:
    """Return how the sections of a material's rods yield; None for one without a yield curve.

    Parameters
    ----------
    material : Material
        Its yield curve, Young's modulus and Poisson's ratio count.
    section : Section
        Of the rods; one of fibres is represented by a round section with its stiffnesses.
    lasting : float
        Share of the stiffness that does not relax [1].
    """
    elements = material.yield_elements
    if not elements:
        return None
    poisson = material.poisson_ratio.value
    share = lasting * np.array([element.share for element in elements])
    limit = np.array([element.strain for element in elements])
    # Von Mises: tau = sigma / sqrt(3), and gamma = tau / G.
    shear_limit = limit * (2.0 * (1.0 + poisson) / sqrt(3.0))
    rings, areas = np.sqrt(0.5 * (GAUSS + 1.0)), 0.5 * np.pi * GAUSS_WEIGHTS
    turn = 2.0 * np.pi / PER_RING * (np.arange(PER_RING)[None, :] + np.arange(RINGS)[:, None] / RINGS)
    cosines, sines = cosines_sines(turn)
    wide, deep = sqrt(section.bend / section.area), sqrt(section.twist / section.area)
    return Yielding(
        y=wide * (rings[:, None] * cosines).ravel(),
        z=wide * (rings[:, None] * sines).ravel(),
        weight=section.area * np.repeat(areas / PER_RING, PER_RING),
        radius=deep * rings,
        shear_weight=section.area * areas / (2.0 * (1.0 + poisson)),
        share=share,
        limit=limit,
        shear_limit=shear_limit,
        reach=wide * float(rings[-1]),
    )


def cut_plastic(plastic: FloatArray, law: Yielding, edge: int) -> FloatArray:
    """Return plastic strains (N, K, P + R) after a cut: new ends keep the mean of theirs, without bending or twist."""
    cut, points = plastic.copy(), law.y.size
    for node in (edge, edge + 1):
        mean = np.sum(plastic[node, :, :points] * law.weight, axis=1) / law.weight.sum()
        cut[node, :, :points], cut[node, :, points:] = mean[:, None], 0.0
    return cut


@inline_kernel
def relief(strain: float, plastic: float, limit: float) -> tuple[float, float, float]:
    """Return f, f' and f'' over strain of what one element lacks of an elastic one, per unit modulus.

    f = e^2 / 2 - H(e - p; y); without flow in the step f' is the plastic strain itself.
    """
    elastic = strain - plastic
    held = min(max(elastic, -limit), limit)
    return 0.5 * strain * strain - held * (elastic - 0.5 * held), strain - held, 1.0 if held != elastic else 0.0


@inline_kernel
def section_relief(
    i: int, axial: float, k1: float, k2: float, law: Yielding, plastic: FloatArray, new: BoolArray
) -> tuple[float, float, float, float]:
    """Return what the section of node i lacks of energy, axial force and both moments, per unit length.

    Parameters
    ----------
    i : int
        Node.
    axial, k1, k2 : float
        Axial strain [1] and curvatures [1/r] from rest.
    law, plastic, new
        As in `relieve`; an element that never yielded, and cannot at these strains, is passed over.
    """
    energy, force, m1, m2 = 0.0, 0.0, 0.0, 0.0
    most = abs(axial) + law.reach * sqrt(k1 * k1 + k2 * k2)
    for k in range(law.share.size):
        limit, share = law.limit[k], law.share[k]
        if new[i, k] and most <= limit:
            continue
        for p in range(law.y.size):
            y, z = law.y[p], law.z[p]
            f, slope, _ = relief(axial + k1 * y + k2 * z, plastic[i, k, p], limit)
            weight = share * law.weight[p]
            energy += weight * f
            pull = weight * slope
            force += pull
            m1 += pull * y
            m2 += pull * z
    return energy, force, m1, m2


@inline_kernel
def section_softening(
    i: int, axial: float, k1: float, k2: float, law: Yielding, plastic: FloatArray, new: BoolArray
) -> tuple[float, float, float, float, float, float]:
    """Return the second derivatives of that energy: by (a, a), (a, k1), (a, k2), (k1, k1), (k1, k2), (k2, k2)."""
    aa, a1, a2, r11, r12, r22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    most = abs(axial) + law.reach * sqrt(k1 * k1 + k2 * k2)
    for k in range(law.share.size):
        limit, share = law.limit[k], law.share[k]
        if new[i, k] and most <= limit:
            continue
        for p in range(law.y.size):
            y, z = law.y[p], law.z[p]
            _, _, curve = relief(axial + k1 * y + k2 * z, plastic[i, k, p], limit)
            c = share * law.weight[p] * curve
            aa += c
            a1 += c * y
            a2 += c * z
            r11 += c * y * y
            r12 += c * y * z
            r22 += c * z * z
    return aa, a1, a2, r11, r12, r22


@inline_kernel
def torsion_relief(
    i: int, twist: float, law: Yielding, plastic: FloatArray, new: BoolArray
) -> tuple[float, float, float]:
    """Return what twisting lacks of energy, torque and stiffness per unit length, at a twist [1/r] of node i."""
    energy, torque, stiffness = 0.0, 0.0, 0.0
    first = law.y.size
    most = abs(twist) * law.radius[law.radius.size - 1]
    for k in range(law.share.size):
        if new[i, k] and most <= law.shear_limit[k]:
            continue
        for p in range(law.radius.size):
            rho = law.radius[p]
            f, slope, curve = relief(rho * twist, plastic[i, k, first + p], law.shear_limit[k])
            weight = law.share[k] * law.shear_weight[p]
            energy += weight * f
            torque += weight * rho * slope
            stiffness += weight * rho * rho * curve
    return energy, torque, stiffness


@kernel
def relieve(
    strain: FloatArray, moved: FloatArray, law: Yielding, plastic: FloatArray, new: BoolArray, rods: Rods
) -> float:
    """Move the rest strains of rods so that, as elastic rods, they have the forces of yielding ones.

    Parameters
    ----------
    strain : (N, 5) array
        Strains from rest as made; see `relaxation.rod_strains`.
    moved : (N, 5) array
        How far the rest strains of the step's elastic rods are from those as made.
    law : Yielding
        How sections yield.
    plastic : (N, K, P + R) array
        Plastic strains where the step began.
    new : (N, K) bool array
        Elements of sections that never yielded at any point.
    rods : Rods
        Stiffness of the step; rest strains `rest_stretch` (first column), `rest_curvature` and `rest_twist` are
        increased from what they are.

    Returns
    -------
    float
        Energy that yielding rods have beyond these elastic ones [E r^3]; constants apart.
    """
    beyond = 0.0
    for i in range(strain.shape[0]):
        length, ea = rods.stretched[i], rods.stretch_stiffness[i]
        if length == 0.0 or ea == 0.0:
            continue
        axial, k1, k2, twist = strain[i, 0], 0.0, 0.0, 0.0
        if rods.is_inner[i]:
            k1, k2, twist = strain[i, 1] / length, strain[i, 2] / length, strain[i, 3] / length
        energy, force, m1, m2 = section_relief(i, axial, k1, k2, law, plastic, new)
        e0 = force / ea
        rods.rest_stretch[i, 0] += e0
        beyond += length * (force * (axial - moved[i, 0] - 0.5 * e0) - energy)
        if rods.is_inner[i]:
            c1, c2 = length * m1 / rods.bend_stiffness[i], length * m2 / rods.bend_stiffness[i]
            rods.rest_curvature[i, 0] += c1
            rods.rest_curvature[i, 1] += c2
            beyond += m1 * (strain[i, 1] - moved[i, 1] - 0.5 * c1) + m2 * (strain[i, 2] - moved[i, 2] - 0.5 * c2)
            energy, torque, _ = torsion_relief(i, twist, law, plastic, new)
            c3 = length * torque / rods.twist_stiffness[i]
            rods.rest_twist[i] += c3
            beyond += torque * (strain[i, 3] - moved[i, 3] - 0.5 * c3) - length * energy
    return beyond


@kernel
def flow(strain: FloatArray, law: Yielding, rods: Rods, plastic: FloatArray, relieved: FloatArray) -> float:
    """Accept strains (N, 5): advance the plastic strains (N, K, P + R) in place; return the plastic work [E r^3].

    `relieved` (N, 2) is filled with the energy [E r^3] that is not stored, against elastic rods of the same strains:
    of stretching and bending together, and of twisting.
    """
    work = 0.0
    first = law.y.size
    for i in range(strain.shape[0]):
        relieved[i, 0], relieved[i, 1] = 0.0, 0.0
        length = rods.stretched[i]
        if length == 0.0 or rods.stretch_stiffness[i] == 0.0:
            continue
        axial, k1, k2, twist = strain[i, 0], 0.0, 0.0, 0.0
        if rods.is_inner[i]:
            k1, k2, twist = strain[i, 1] / length, strain[i, 2] / length, strain[i, 3] / length
        for k in range(law.share.size):
            for p in range(first + law.radius.size):
                if p < first:
                    e, limit = axial + k1 * law.y[p] + k2 * law.z[p], law.limit[k]
                    weight = length * law.share[k] * law.weight[p]
                else:
                    e, limit = twist * law.radius[p - first], law.shear_limit[k]
                    weight = length * law.share[k] * law.shear_weight[p - first]
                elastic = e - plastic[i, k, p]
                held = min(max(elastic, -limit), limit)
                work += weight * limit * abs(elastic - held)
                plastic[i, k, p] = e - held if held != elastic else plastic[i, k, p]
                relieved[i, 0 if p < first else 1] += 0.5 * weight * (e * e - held * held)
    return work
