"""Energy, forces, stiffness and loads of the bonds between fused strands (see `bonds`).

`placed` holds samples and edges now, with turns since printing; all bonds that are given are whole.
"""

from math import sqrt

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.bonds import Bonds
from knitlab_core.contact.forces import add_pair
from knitlab_core.contact.slip import Placed, add_slip_curvature, add_slip_slope, carried_along, opened
from knitlab_core.contact.stiffness import add_square, scatter_square
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector, add, combine, cross, dot, norm, row, scale, sub
from knitlab_core.sparse.blocks import Pattern


@inline_kernel
def _disagreement(p: int, j: int, m: int, placed: Placed, bonds: Bonds) -> Vector:
    """Return w0, w1 or w2 of bond p."""
    a, b, arm = bonds.a[p], bonds.b[p], row(bonds.arms[p], j)
    if j == 0:
        return opened(a, b, m, placed, arm)
    return scale(0.5, sub(carried_along(a // m, a % m, m, placed, arm), carried_along(b // m, b % m, m, placed, arm)))


@inline_kernel
def _ways(p: int, j: int, bonds: Bonds) -> tuple[float, Vector, Vector]:
    """Return s, va and vb with w = s (xa - xb) - (Ra va + Rb vb) / 2, the form of a slip."""
    arm = row(bonds.arms[p], j)
    return (1.0, arm, arm) if j == 0 else (0.0, scale(-1.0, arm), arm)


@kernel
def bond_energy(placed: Placed, bonds: Bonds, m: int) -> float:
    """Return the energy stored in bonds [E r^3]; `m` samples a span."""
    energy = 0.0
    for p in range(bonds.a.size):
        for j in range(3):
            w = _disagreement(p, j, m, placed, bonds)
            energy += 0.5 * bonds.stiffness[p] * dot(w, w)
    return energy


@kernel
def bond_gradient(placed: Placed, bonds: Bonds, weights: FloatArray, gradient: FloatArray) -> None:
    """Add the bonds' forces to `gradient` (N, 4) [E r^2, E r^3]; `weights` (m, 3) are those of the samples."""
    m = weights.shape[0]
    slope = np.zeros((6, 4))
    for p in range(bonds.a.size):
        a, b = bonds.a[p], bonds.b[p]
        slope[:] = 0.0
        for j in range(3):
            s, va, vb = _ways(p, j, bonds)
            w = _disagreement(p, j, m, placed, bonds)
            add_slip_slope(w, s, a // m, a % m, weights, placed, va, slope, 0)
            add_slip_slope(w, -s, b // m, b % m, weights, placed, vb, slope, 3)
        add_pair(bonds.stiffness[p], slope, a // m, b // m, gradient)


@kernel
def bond_hessian(
    placed: Placed, bonds: Bonds, weights: FloatArray, exact: float, pattern: Pattern, blocks: FloatArray
) -> None:
    """Add the Hessian of the bonds to the node blocks.

    Parameters
    ----------
    placed : Placed
        Samples and edges in the present configuration, with turns since printing.
    bonds : Bonds
        The whole bonds.
    weights : (m, 3) array
        Weights of a span's nodes at its samples.
    exact : float
        Weight of the second derivatives of w: 0 is Gauss-Newton.
    pattern : Pattern
        Where blocks are stored; `across` is that of the bonds' span pairs.
    blocks : (B, 4, 4) array
        Block (i, j), i >= j.
    """
    m = weights.shape[0]
    square, slope = np.zeros((24, 24)), np.zeros((6, 4))
    flat = slope.reshape(24)
    for p in range(bonds.a.size):
        a, b, k = bonds.a[p], bonds.b[p], bonds.stiffness[p]
        square[:] = 0.0
        for j in range(3):
            s, va, vb = _ways(p, j, bonds)
            for c in range(3):
                e = (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)
                slope[:] = 0.0
                add_slip_slope(e, s, a // m, a % m, weights, placed, va, slope, 0)
                add_slip_slope(e, -s, b // m, b % m, weights, placed, vb, slope, 3)
                add_square(k, flat, square)
            if exact > 0.0:
                pull = scale(exact * k, _disagreement(p, j, m, placed, bonds))
                add_slip_curvature(pull, a // m, a % m, m, placed, va, square, 0)
                add_slip_curvature(pull, b // m, b % m, m, placed, vb, square, 12)
        scatter_square(a // m, b // m, p, square, pattern, blocks)


@inline_kernel
def _middle(p: int, j: int, m: int, placed: Placed, bonds: Bonds) -> Vector:
    """Return a printed arm as both strands carry it on average."""
    a, b, arm = bonds.a[p], bonds.b[p], row(bonds.arms[p], j)
    return scale(0.5, add(carried_along(a // m, a % m, m, placed, arm), carried_along(b // m, b % m, m, placed, arm)))


@kernel
def bond_loads(placed: Placed, bonds: Bonds, m: int, load: FloatArray) -> None:
    """Fill the share (B,) of its strength that each bond bears; the criterion is that of `BondLaw`."""
    size = bonds.radius
    area, section = np.pi * size * size, 0.25 * np.pi * size * size * size
    for p in range(bonds.a.size):
        k = bonds.stiffness[p]
        n = _middle(p, 0, m, placed, bonds)
        n = scale(1.0 / norm(n), n)
        force = scale(k, _disagreement(p, 0, m, placed, bonds))
        pull = dot(force, n)
        moment = (0.0, 0.0, 0.0)
        for j in range(1, 3):
            # Half the arm: springs of an even disc act at the root mean square of their place, a / 2.
            lever = scale(0.5 * k, _middle(p, j, m, placed, bonds))
            moment = add(moment, cross(lever, _disagreement(p, j, m, placed, bonds)))
        torque = dot(moment, n)
        tension = pull / area + norm(combine(1.0, moment, -torque, n)) / section
        shear = norm(combine(1.0, force, -pull, n)) / area + 0.5 * abs(torque) / section
        pulled, sheared = max(tension, 0.0) / bonds.strength, shear / bonds.shear_strength
        load[p] = sqrt(pulled * pulled + sheared * sheared)
