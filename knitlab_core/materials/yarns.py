"""Yarn by what is measured on it, instead of by the elastic constants of a solid."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError
from knitlab_core.materials.values import Value

if TYPE_CHECKING:
    from collections.abc import Iterator

LARGEST_FRICTION: Final = 2.0
SMALLEST_EXPONENT: Final = 2.0
"""Below, two yarns that begin to touch would be infinitely stiff."""

LARGEST_EXPONENT: Final = 6.0

LARGEST_CORE: Final = 0.9
"""Radius of the core over the outer one: contact of thinner shells would need samples nearer to each other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredYarn:
    """Yarn whose stiffnesses, radius and compression are measured one by one; linearly elastic along its length.

    Parameters
    ----------
    name : str
        The name that protocols use.
    bending : Value
        Bending stiffness EI, as of a cantilever that droops [N m^2].
    axial : Value
        Axial stiffness EA, force over strain [N].
    twisting : Value
        Torsional stiffness GJ, moment over twist by length [N m^2].
    radius : Value
        Outer radius: two yarns begin to touch at twice this distance [m].
    core : Value
        Radius to which no force can compress it [m].
    exponent : Value
        How softly the force of compression begins and how steeply it grows towards the core, 2 to 6 [1]; see
        `knitlab_core.contact.compression`.
    rigidity : Value
        Force by length that compresses it between plates to halfway between radius and core [N/m].
    friction : Value or None
        Coulomb's coefficient of yarn on yarn [1]; None where none is known.
    note : str
        Limits of the numbers, for users.

    Raises
    ------
    SpecificationError
        For a number out of its range, a core beyond nine tenths of the radius, and stiffnesses that no section within
        the radius has: with fibres along the yarn EI = 1/2 ∫ E ρ^2 dA <= 1/2 EA radius^2, reached by a thin tube; and
        GJ = ∫ G ρ^2 dA <= 1/2 EA radius^2 where G <= E / 2, as in every isotropic fibre that narrows when pulled.
    """

    name: str
    bending: Value
    axial: Value
    twisting: Value
    radius: Value
    core: Value
    exponent: Value
    rigidity: Value
    friction: Value | None = None
    note: str = ""

    def __post_init__(self) -> None:
        """Refuse numbers that no yarn can have."""
        for field, number in self.numbers():
            enough = number.value >= 0.0 if field == "friction" else number.value > 0.0
            if not (enough and number.value < float("inf")):
                unit = "" if number.unit == "1" else f" {number.unit}"
                allowed = f"a coefficient from 0 to {LARGEST_FRICTION:g}" if field == "friction" else "a number above 0"
                within = "compression." * (field in {"exponent", "rigidity"})
                raise SpecificationError(f"yarn.{within}{field}", f"{number.value:g}{unit}", f"{allowed}{unit}")
        if self.friction is not None and self.friction.value > LARGEST_FRICTION:
            allowed = f"a coefficient from 0 to {LARGEST_FRICTION:g}"
            raise SpecificationError("yarn.friction", self.friction.value, allowed)
        core, most = self.core.value, LARGEST_CORE * self.radius.value
        if core > most:
            allowed = f"{1e3 * most:.4g} mm or less, {LARGEST_CORE:g} of the radius"
            raise SpecificationError("yarn.core", f"{1e3 * core:.4g} mm", allowed)
        if not SMALLEST_EXPONENT <= self.exponent.value <= LARGEST_EXPONENT:
            allowed = f"from {SMALLEST_EXPONENT:g} to {LARGEST_EXPONENT:g}"
            raise SpecificationError("yarn.compression.exponent", self.exponent.value, allowed)
        most = 0.5 * self.axial.value * self.radius.value**2
        for field, number in (("bending", self.bending), ("twisting", self.twisting)):
            if number.value > most:
                allowed = f"{1e6 * most:.4g} N mm^2 or less: half of axial times radius squared, as of a thin tube"
                raise SpecificationError(f"yarn.{field}", f"{1e6 * number.value:.4g} N mm^2", allowed)

    def numbers(self) -> Iterator[tuple[str, Value]]:
        """Yield every number that is known, by the name of its field."""
        for one in fields(self):
            value = getattr(self, one.name)
            if isinstance(value, Value):
                yield one.name, value

    @property
    def reference_modulus(self) -> float:
        """Return Young's modulus of a solid round rod with this radius and bending stiffness [Pa].

        It scales the solver's forces, and is no property of the yarn.
        """
        return 4.0 * self.bending.value / (pi * self.radius.value**4)
