"""Sine, cosine, arc tangent, exponential and logarithm with the same bits on every processor.

Those of the C library and of NumPy choose their code by processor, and a last bit decides now and then on which side
of a bifurcation a knit goes on. These use additions, multiplications and divisions in a fixed order, which NumPy and
compiled code round alike: `knitlab_core.angle_kernels` compiles the same formulas, and building a knit needs no
compiler.

References
----------
Polynomials and reductions of fdlibm 5.3 (k_sin.c, k_cos.c, s_atan.c, e_exp.c, e_log.c), errors below one unit in the
last place: Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved. Developed at SunSoft, a Sun Microsystems,
Inc. business. Permission to use, copy, modify, and distribute this software is freely granted, provided that this
notice is preserved.
"""

import math
from typing import TypeVar

import numpy as np

from knitlab_core.arrays import FloatArray

NumberT = TypeVar("NumberT", float, FloatArray)

TWO_OVER_PI = 0.6366197723675814
# pi/2 in two parts of 33 bits and a rest.
HALF_PI_1 = 1.57079632673412561417e00
HALF_PI_2 = 6.07710050630396597660e-11
HALF_PI_REST = 2.02226624879595063154e-21
PI_REST = 1.2246467991473531772e-16

S1, S2, S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S4, S5, S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
C1, C2, C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C4, C5, C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11

A0, A2, A4 = 3.33333333333329318027e-01, 1.42857142725034663711e-01, 9.09088713343650656196e-02
A6, A8, A10 = 6.66107313738753120669e-02, 4.97687799461593236017e-02, 1.62858201153657823623e-02
A1, A3, A5 = -1.99999999998764832476e-01, -1.11111104054623557880e-01, -7.69187620504482999495e-02
A7, A9 = -5.83357013379057348645e-02, -3.65315727442169155270e-02

# Where the arc tangent is taken from another angle than 0, and that angle in two parts [rad].
ARC_FROM = (2.4375, 1.1875, 0.6875, 0.4375)
ARC_HIGH = 1.57079632679489655800e00, 9.82793723247329054082e-01, 7.85398163397448278999e-01, 4.63647609000806093515e-01
ARC_LOW = 6.12323399573676603587e-17, 1.39033110312309984516e-17, 3.06161699786838301793e-17, 2.26987774529616870924e-17

ONE_OVER_LN2 = 1.4426950408889634
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
P1, P2, P3 = 1.66666666666666019037e-01, -2.77777777770155933842e-03, 6.61375632143793436117e-05
P4, P5 = -1.65339022054652515390e-06, 4.13813679705723846039e-08

L1, L2, L3 = 6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01
L4, L5, L6 = 2.222219843214978396e-01, 1.818357216161805012e-01, 1.531383769920937332e-01
L7 = 1.479819860511658591e-01


def in_first_quarter(x: NumberT) -> tuple[NumberT, NumberT, NumberT]:
    """Return how many quarters of a turn are in an angle [rad], to the nearest, and cosine and sine of the rest."""
    n = np.rint(x * TWO_OVER_PI)
    t = x - n * HALF_PI_1
    w = n * HALF_PI_2
    r = t - w
    w = n * HALF_PI_REST - ((t - r) - w)
    y = r - w
    rest = (r - y) - w
    z = y * y
    v = z * y
    p = S2 + z * (S3 + z * (S4 + z * (S5 + z * S6)))
    sine = y - ((z * (0.5 * rest - v * p) - rest) - v * S1)
    zz = z * z
    p = z * (C1 + z * (C2 + z * C3)) + zz * zz * (C4 + z * (C5 + z * C6))
    half = 0.5 * z
    near = 1.0 - half
    return n, near + (((1.0 - near) - half) + (z * p - y * rest)), sine


def arc_from_zero(x: NumberT, high: NumberT, low: NumberT) -> NumberT:
    """Return the arc tangent of a number of up to 0.4375 in size, and an angle in two parts added to it [rad]."""
    z = x * x
    w = z * z
    even = z * (A0 + w * (A2 + w * (A4 + w * (A6 + w * (A8 + w * A10)))))
    odd = w * (A1 + w * (A3 + w * (A5 + w * (A7 + w * A9))))
    return high - ((x * (even + odd) - low) - x)


def cosines_sines(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return cosines and sines of angles [rad], in arrays of their shape."""
    n, cosines, sines = in_first_quarter(np.asarray(x, dtype=np.float64))
    quarter = n.astype(np.int64) & 3
    odd, behind, below = (quarter & 1) == 1, (quarter == 1) | (quarter == 2), quarter >= 2
    turned, beside = np.where(odd, sines, cosines), np.where(odd, cosines, sines)
    return np.where(behind, -turned, turned), np.where(below, -beside, beside)


def cosine(x: FloatArray) -> FloatArray:
    """Return the cosines of angles [rad].

    Examples
    --------
    >>> cosine(np.array([0.0, np.pi]))
    array([ 1., -1.])
    """
    return cosines_sines(x)[0]


def sine(x: FloatArray) -> FloatArray:
    """Return the sines of angles [rad].

    Examples
    --------
    >>> float(sine(np.array(np.pi / 6.0)))
    0.49999999999999994
    """
    return cosines_sines(x)[1]


def arc_tangents(y: FloatArray, x: FloatArray) -> FloatArray:
    """Return the angles of points (x, y) in two arrays of one shape [rad]."""
    y, x = np.asarray(y, dtype=np.float64), np.asarray(x, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        slope = np.abs(y) / np.abs(x)
        pieces = [slope >= least for least in ARC_FROM]
        high, low = np.select(pieces, ARC_HIGH, 0.0), np.select(pieces, ARC_LOW, 0.0)
        moved = -1.0 / slope, (slope - 1.5) / (1.0 + 1.5 * slope), (slope - 1.0) / (slope + 1.0)
        near = np.select(pieces, [*moved, (2.0 * slope - 1.0) / (2.0 + slope)], slope)
        angle = arc_from_zero(near, high, low)
    angle = np.where(x < 0.0, np.pi - (angle - PI_REST), angle)
    return np.where((y == 0.0) & (x >= 0.0), 0.0, np.where(y >= 0.0, angle, -angle))


def exponential_parts(x: NumberT) -> tuple[NumberT, NumberT]:
    """Return k, whole, and y near 1 with exp(x) = 2^k y."""
    k = np.rint(x * ONE_OVER_LN2)
    high, low = x - k * LN2_HIGH, k * LN2_LOW
    r = high - low
    t = r * r
    c = r - t * (P1 + t * (P2 + t * (P3 + t * (P4 + t * P5))))
    return k, 1.0 - ((low - (r * c) / (2.0 - c)) - high)


def logarithm_of_parts(f: NumberT, k: NumberT) -> NumberT:
    """Return the logarithm of 2^k (1 + f), with 1 + f from sqrt(1/2) to sqrt(2)."""
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    rest = z * (L1 + w * (L3 + w * (L5 + w * L7))) + w * (L2 + w * (L4 + w * L6))
    half = 0.5 * f * f
    return k * LN2_HIGH - ((half - (s * (half + rest) + k * LN2_LOW)) - f)


def exponential(x: float) -> float:
    """Return exp(x); 0 where that is below the smallest normal number.

    Examples
    --------
    >>> round(exponential(1.0), 12), exponential(-800.0)
    (2.718281828459, 0.0)
    """
    if x < -708.0:
        return 0.0
    k, y = exponential_parts(x)
    return math.ldexp(float(y), int(k))
