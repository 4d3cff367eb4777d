"""Shape of one loop: five numbers, in loop widths.

The centreline of one loop is the paper's Eq. 1,
``gamma(t) = [l/2pi (t + a sin 2t), h cos t, d cos 2t]``, with the loop width ``l`` as the unit of length; stitches
whose yarn changes sides elsewhere have another multiple of t in the last coordinate (`LoopShape.wave`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final, TypeGuard

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping

LARGEST: Final[Mapping[str, float]] = MappingProxyType(
    {"curvature": 5.0, "height": 10.0, "depth": 10.0, "row_spacing": 10.0, "fibre_radius": 0.5}
)
"""Largest value of each number of a stitch [loop widths]; the smallest is anything above 0."""


def is_positive(value: object) -> TypeGuard[float]:
    """Return whether a value is a finite number above 0; a truth value is no number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < math.inf


def check_number(name: str, value: object, *, most: float) -> None:
    """Refuse a number of a stitch that is not finite, not positive or too large.

    Raises
    ------
    SpecificationError
        Naming the number.
    """
    if not is_positive(value) or value > most:
        raise SpecificationError(f"stitch.{name}", value, f"a number above 0 and at most {most:g}, in loop widths")


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopShape:
    """Shape of one loop, and the distance of its rows.

    Parameters
    ----------
    curvature : float
        ``a``: how far a loop bulges over its neck [1]; it has a neck at all from 1/2 on.
    height : float
        ``h``: half of a loop's extent along the wale [loop widths].
    depth : float
        ``d``: half of its extent out of the plane [loop widths].
    row_spacing : float
        ``w``: wale distance of neighbouring rows [loop widths].
    fibre_radius : float
        ``r``: radius of the fibre [loop widths].

    Raises
    ------
    SpecificationError
        If a number is not finite, not positive or beyond `LARGEST`.

    References
    ----------
    Cline et al., "Entanglement-driven responses through multiscale 3D-printed knits", Eq. 1. The paper
    leaves the row spacing out; it is a number of its own here.
    """

    curvature: float
    height: float
    depth: float
    row_spacing: float
    fibre_radius: float

    wave: ClassVar[float] = 2.0
    """Multiple of t in the coordinate out of the plane: ``d cos(wave t)``."""

    locking_error: ClassVar[float] = 0.013
    """By how much the estimate of its locking strain is off, rms [1]."""

    def __post_init__(self) -> None:
        for name, most in LARGEST.items():
            check_number(name, getattr(self, name), most=most)


def locking_strain(stitch: LoopShape, yarn_per_loop: float, fibre_radius: float | None = None) -> float:
    """Estimate the biaxial strain at which a loop has used up its yarn.

    ``[1.005 L - (11.67 r + 1.076 d m/2 - 0.179 (a - 1.5) - 0.075)] / (1 + 2 w) - 1``, a fit over 162 designs
    with an error of 0.013 rms: near it the yarn itself must stretch and forces rise steeply. The fit is of
    stockinette, whose wave m is 2; what yarn spends on changing sides goes with the number of changes.

    Parameters
    ----------
    stitch : LoopShape
        The loop.
    yarn_per_loop : float
        Yarn length of one loop without turn-arounds, L [loop widths].
    fibre_radius : float, optional
        Radius of the yarn where strands cross, the stitch's own unless given, r [loop widths].

    Returns
    -------
    float
        Strain, the same along course and wale [1].
    """
    radius = stitch.fibre_radius if fibre_radius is None else fibre_radius
    taken_by_crossings = (
        11.67 * radius + 1.076 * (0.5 * stitch.wave) * stitch.depth - 0.179 * (stitch.curvature - 1.5) - 0.075
    )
    return (1.005 * yarn_per_loop - taken_by_crossings) / (1.0 + 2.0 * stitch.row_spacing) - 1.0
