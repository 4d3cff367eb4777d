"""Give a rod the section of a yarn of fibres: factors on the stiffness of a solid round rod.

A rod touches others at its contact radius, which is the solver's unit of length. Its own stiffness is that of
a solid round section of this radius times the factors here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from knitlab_core.knits.fibres import Yarn


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """Hold stiffnesses relative to a solid round rod of the contact radius.

    Parameters
    ----------
    area, bend, twist : float
        Factors on EA, EI and GJ [1].
    """

    area: float = 1.0
    bend: float = 1.0
    twist: float = 1.0


SOLID: Final = Section()
"""One solid round fibre."""


def yarn_section(yarn: Yarn) -> Section:
    """Return the section of a yarn whose contact radius is the bundle's outer radius, rho = R + r.

    Against pi rho^2, pi rho^4 / 4 and pi rho^4 / 2 stand n pi r^2, and between n pi r^4 / 4 and Steiner's
    n (pi r^4 / 4 + pi r^2 R^2 / 2) for bending, n pi r^4 / 2 and n (pi r^4 / 2 + pi r^2 R^2) for twisting:
    ``1 + 2 bonding (R/r)^2`` times the loose one in both. Two fibres have two bending stiffnesses; a twisted
    yarn feels their mean, which this is. Glued fibres are an upper bound in torsion, as they may warp; the
    fibres' slope against the yarn, omega R, is neglected.

    Parameters
    ----------
    yarn : Yarn
        The fibres; ``yarn.bonding`` goes from loose (0) to glued (1).
    """
    ratio = yarn.fibre_radius / yarn.outer_radius
    loose = yarn.fibres * ratio**4
    # One fibre has nothing to be glued to, however it winds.
    bonding = yarn.bonding if yarn.fibres > 1 else 0.0
    steiner = 1.0 + 2.0 * bonding * (yarn.winding_radius / yarn.fibre_radius) ** 2
    return Section(area=yarn.fibres * ratio**2, bend=loose * steiner, twist=loose * steiner)
