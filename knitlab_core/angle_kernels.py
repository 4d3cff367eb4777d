"""Sine, cosine, arc tangent and power for kernels: the formulas of `knitlab_core.angles`, compiled."""

import numpy as np

from knitlab_core import angles
from knitlab_core.angles import ARC_FROM, ARC_HIGH, ARC_LOW, PI_REST
from knitlab_core.jit import inline_kernel

_in_first_quarter = inline_kernel(angles.in_first_quarter)
_arc_from_zero = inline_kernel(angles.arc_from_zero)
_exponential_parts = inline_kernel(angles.exponential_parts)
_logarithm_of_parts = inline_kernel(angles.logarithm_of_parts)

_ROOT_TWO = 1.4142135623730951
# Of the bits of a number: its fraction, and the exponent of 1.
_FRACTION = 0xFFFFFFFFFFFFF
_ONE = 0x3FF0000000000000


@inline_kernel
def cosine_sine(x: float) -> tuple[float, float]:
    """Return cosine and sine of an angle [rad], up to a million in size."""
    n, cosine, sine = _in_first_quarter(x)
    quarter = int(n) & 3
    if quarter == 0:
        return cosine, sine
    if quarter == 1:
        return -sine, cosine
    if quarter == 2:
        return -cosine, -sine
    return sine, -cosine


@inline_kernel
def _arc(x: float) -> float:
    """Return the arc tangent of a number from 0 to infinity."""
    high, low = 0.0, 0.0
    if x >= ARC_FROM[0]:
        high, low, x = ARC_HIGH[0], ARC_LOW[0], -1.0 / x
    elif x >= ARC_FROM[1]:
        high, low, x = ARC_HIGH[1], ARC_LOW[1], (x - 1.5) / (1.0 + 1.5 * x)
    elif x >= ARC_FROM[2]:
        high, low, x = ARC_HIGH[2], ARC_LOW[2], (x - 1.0) / (x + 1.0)
    elif x >= ARC_FROM[3]:
        high, low, x = ARC_HIGH[3], ARC_LOW[3], (2.0 * x - 1.0) / (2.0 + x)
    return _arc_from_zero(x, high, low)


@inline_kernel
def arc_tangent(y: float, x: float) -> float:
    """Return the angle of the point (x, y), from -pi to pi [rad]; 0 for the origin."""
    if y == 0.0 and x >= 0.0:
        return 0.0
    angle = _arc(abs(y) / abs(x))
    if x < 0.0:
        angle = np.pi - (angle - PI_REST)
    return angle if y >= 0.0 else -angle


@inline_kernel
def power(x: float, exponent: float) -> float:
    """Return x^exponent, for normal x above 0 and results from 1e-300 to 1e300; relative error 1e-15 times its log."""
    bits = np.float64(x).view(np.int64)
    k = (bits >> 52) - 1023
    mantissa = np.int64((bits & _FRACTION) | _ONE).view(np.float64)
    if mantissa > _ROOT_TWO:
        mantissa, k = 0.5 * mantissa, k + 1
    twos, y = _exponential_parts(exponent * _logarithm_of_parts(mantissa - 1.0, float(k)))
    return y * np.int64((np.int64(twos) + 1023) << 52).view(np.float64)
