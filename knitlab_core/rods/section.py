"""Section of a yarn of fibres, or of one by measurement: factors on the stiffness of a solid round rod.

A rod touches others at its contact radius, which is the solver's unit of length. Its own stiffness is that of
a solid round section of this radius times the factors here. Hertz's law keeps the solid's modulus and that radius:
a crossing is so much stiffer than a loop that half of it, or twice, moves the forces by per cents only.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from knitlab_core.knits.fibres import Yarn
    from knitlab_core.materials import MeasuredYarn
    from knitlab_core.rods.rod import Rods


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """Stiffnesses of a section relative to a solid round rod of the contact radius.

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
    """Return the section of a yarn seen as one rod, against a solid one of the contact radius rho.

    For n fibres of radius r at the distance R, with b from 0 (loose) to 1 (glued),
    ``EA = n E pi r^2``, ``EI = n E (pi r^4 / 4 + b pi r^2 R^2 / 2)`` and ``GJ = n G (pi r^4 / 2 + b pi r^2 R^2)``:
    the fibres' own and Steiner's part. Two fibres have two bending stiffnesses; a twisted yarn feels their mean,
    which this is. In torsion glued fibres may warp, so theirs is an upper bound. The fibres' slope against the
    yarn, omega R, is neglected.

    Parameters
    ----------
    yarn : Yarn
        The fibres; its ``contact_radius`` is rho.
    """
    ratio = yarn.fibre_radius / yarn.contact_radius
    steiner = 1.0 + 2.0 * yarn.bonding * (yarn.winding_radius / yarn.fibre_radius) ** 2
    bend = yarn.fibres * ratio**4 * steiner
    return Section(area=yarn.fibres * ratio**2, bend=bend, twist=bend)


def measured_section(yarn: MeasuredYarn) -> Section:
    """Return the section of a yarn by measurement, against a solid one of its radius, reference modulus and ν = 0."""
    modulus, radius = yarn.reference_modulus, yarn.radius.value
    area, inertia = pi * radius**2, 0.25 * pi * radius**4
    return Section(
        area=yarn.axial.value / (modulus * area),
        bend=yarn.bending.value / (modulus * inertia),
        twist=yarn.twisting.value / (modulus * inertia),
    )


def with_section(rods: Rods, section: Section) -> Rods:
    """Return solid round rods of unit radius with the stiffness of a section instead."""
    return rods._replace(
        easing=section.area / section.bend * rods.easing,
        stretch_stiffness=section.area * rods.stretch_stiffness,
        bend_stiffness=section.bend * rods.bend_stiffness,
        twist_stiffness=section.twist * rods.twist_stiffness,
    )
