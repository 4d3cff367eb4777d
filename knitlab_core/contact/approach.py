"""By how much strands may have come nearer to each other, bounded by the motion of nodes."""

from math import sqrt

from knitlab_core.arrays import FloatArray
from knitlab_core.jit import inline_kernel, kernel
from knitlab_core.rods.vectors import Vector, cross, dot, norm, row, scale, sub


@inline_kernel
def _mean(x: FloatArray) -> Vector:
    """Return the mean of the rows' first three entries."""
    a, b, c = 0.0, 0.0, 0.0
    for i in range(x.shape[0]):
        a += x[i, 0]
        b += x[i, 1]
        c += x[i, 2]
    return scale(1.0 / x.shape[0], (a, b, c))


@kernel
def largest_approach(x: FloatArray, dx: FloatArray, reach: float, enough: float) -> float:
    """Bound by how much any two strands within `reach` approach when nodes move by `dx`.

    A uniform stretch brings no strands together beyond its strain, so motions
    too large to be harmless are split by least squares into dx = A x + c and a rest.

    Parameters
    ----------
    x, dx : (N, 3+) arrays
        Positions and motions [r].
    reach : float
        Distance up to which strands matter [r].
    enough : float
        A bound below this need not be sharpened [r].
    """
    n = x.shape[0]
    largest = 0.0
    for i in range(n):
        move = row(dx, i)
        largest = max(largest, dot(move, move))
    if 2.0 * sqrt(largest) <= enough:
        return 2.0 * sqrt(largest)
    middle, drift = _mean(x), _mean(dx)
    # The unit added keeps flat and straight specimens regular.
    xx, yy, zz, yz, zx, xy = float(n), float(n), float(n), 0.0, 0.0, 0.0
    px, py, pz = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(n):
        a, b, c = sub(row(x, i), middle)
        u, v, w = sub(row(dx, i), drift)
        xx += a * a
        yy += b * b
        zz += c * c
        yz += b * c
        zx += c * a
        xy += a * b
        px = (px[0] + a * u, px[1] + b * u, px[2] + c * u)
        py = (py[0] + a * v, py[1] + b * v, py[2] + c * v)
        pz = (pz[0] + a * w, pz[1] + b * w, pz[2] + c * w)
    # Cramer's rule: the moments are symmetric and positive.
    first, second, third = (xx, xy, zx), (xy, yy, yz), (zx, yz, zz)
    one, two, three = cross(second, third), cross(third, first), cross(first, second)
    inverse = 1.0 / dot(first, one)
    ax = scale(inverse, (dot(one, px), dot(two, px), dot(three, px)))
    ay = scale(inverse, (dot(one, py), dot(two, py), dot(three, py)))
    az = scale(inverse, (dot(one, pz), dot(two, pz), dot(three, pz)))
    largest = 0.0
    for i in range(n):
        at, d = sub(row(x, i), middle), sub(row(dx, i), drift)
        rest = sub(d, (dot(ax, at), dot(ay, at), dot(az, at)))
        largest = max(largest, dot(rest, rest))
    strain = norm((norm(ax), norm(ay), norm(az)))
    return 2.0 * sqrt(largest) + strain * reach
