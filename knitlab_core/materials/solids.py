"""Solid yarn materials: elastic constants, strength, relaxation and yield."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

from knitlab_core.errors import SpecificationError
from knitlab_core.materials.values import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxationTerm:
    """One term of a Prony series: share of the stiffness that relaxes, and its time.

    Parameters
    ----------
    share : Value
        Share g of Young's modulus that is lost in the end [1].
    time : Value
        Relaxation time τ [s].
    """

    share: Value
    time: Value


@dataclass(frozen=True, slots=True, kw_only=True)
class CurvePoint:
    """One point of a curve of stress over strain, as pulled for the first time.

    Parameters
    ----------
    strain : Value
        Strain [1].
    stress : Value
        Stress [Pa].
    """

    strain: Value
    stress: Value


class YieldElement(NamedTuple):
    """One element of a material that yields: its share of Young's modulus, and the strain at which it flows [1]."""

    share: float
    strain: float


FIRST_POINT: Final = 0.01
"""How far the first point of a yield curve may be off the line of Young's modulus [1]; it is put on that line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """Isotropic yarn material: linearly elastic, unless relaxation or yield are given and switched on.

    Parameters
    ----------
    name : str
        The name that protocols use.
    young_modulus : Value
        Young's modulus E [Pa]; with a relaxation, the modulus at once.
    poisson_ratio : Value
        Poisson's ratio ν [1].
    strength : Value or None
        Ultimate tensile strength [Pa].
    elongation_at_break : Value or None
        Strain at which a straight specimen breaks [1]; without it and a strength there is no rupture.
    density : Value or None
        Mass density [kg/m³].
    relaxation : tuple of RelaxationTerm
        Prony series E(t) = E [1 - Σ g (1 - exp(-t/τ))]; empty where none is known.
    yield_curve : tuple of CurvePoint
        Stress over strain as pulled for the first time, joined by straight lines: from zero to the first point, on the
        line of Young's modulus, where yield begins, and beyond the last at its stress. Empty where none is known.
    note : str
        Limits of the numbers, for users.

    Raises
    ------
    SpecificationError
        For a modulus, strength, elongation, density or relaxation time not above zero, a ratio outside (-1, 0.5],
        shares that leave no stiffness, or a yield curve that begins off the line of Young's modulus, falls, or bends
        upwards.
    """

    name: str
    young_modulus: Value
    poisson_ratio: Value
    strength: Value | None = None
    elongation_at_break: Value | None = None
    density: Value | None = None
    relaxation: tuple[RelaxationTerm, ...] = ()
    yield_curve: tuple[CurvePoint, ...] = ()
    note: str = ""

    def __post_init__(self) -> None:
        """Refuse numbers that no elastic solid can have."""
        above_zero = {
            "young_modulus": self.young_modulus,
            "strength": self.strength,
            "elongation_at_break": self.elongation_at_break,
            "density": self.density,
        }
        for number, term in enumerate(self.relaxation):
            above_zero[f"relaxation[{number}].share"] = term.share
            above_zero[f"relaxation[{number}].time"] = term.time
        for number, point in enumerate(self.yield_curve):
            above_zero[f"yield_curve[{number}].strain"] = point.strain
            above_zero[f"yield_curve[{number}].stress"] = point.stress
        for field, entry in above_zero.items():
            if entry is not None and not 0.0 < entry.value < float("inf"):
                unit = "" if entry.unit == "1" else f" {entry.unit}"
                raise SpecificationError(f"material.{field}", entry.value, f"a number above 0{unit}")
        lost = sum(term.share.value for term in self.relaxation)
        if not lost < 1.0:
            raise SpecificationError("material.relaxation", lost, "shares of less than 1 in all")
        if not -1.0 < self.poisson_ratio.value <= 0.5:
            raise SpecificationError("material.poisson_ratio", self.poisson_ratio.value, "above -1, at most 0.5")
        self._require_curve()

    def _require_curve(self) -> None:
        """Refuse a yield curve that no material of elements in parallel has."""
        if not self.yield_curve:
            return
        first, modulus = self.yield_curve[0], self.young_modulus.value
        wanted = modulus * first.strain.value
        if abs(first.stress.value - wanted) > FIRST_POINT * wanted:
            expected = f"{wanted:.4g} Pa, Young's modulus times its strain: there yield begins"
            raise SpecificationError("material.yield_curve[0].stress", f"{first.stress.value:.4g} Pa", expected)
        slope, before = modulus, (first.strain.value, wanted)
        for number, point in enumerate(self.yield_curve[1:], 1):
            here = (point.strain.value, point.stress.value)
            field = f"material.yield_curve[{number}]"
            if here[0] <= before[0]:
                raise SpecificationError(f"{field}.strain", here[0], f"above {before[0]:g}: strains rise")
            if here[1] < before[1]:
                raise SpecificationError(f"{field}.stress", f"{here[1]:.4g} Pa", f"{before[1]:.4g} Pa or more")
            steeper, slope = slope, (here[1] - before[1]) / (here[0] - before[0])
            if slope > steeper:
                most = before[1] + steeper * (here[0] - before[0])
                expected = f"{most:.4g} Pa or less: the curve may not bend upwards"
                raise SpecificationError(f"{field}.stress", f"{here[1]:.4g} Pa", expected)
            before = here

    @property
    def yield_elements(self) -> tuple[YieldElement, ...]:
        """Return the elements in parallel that follow the yield curve (Besseling 1958); the rest stays elastic."""
        modulus, elements, slope = self.young_modulus.value, [], 1.0
        at = [point.strain.value for point in self.yield_curve]
        stress = [point.stress.value / modulus for point in self.yield_curve]
        if at:
            stress[0] = at[0]
        for k, strain in enumerate(at):
            last = k + 1 == len(at)
            beyond = 0.0 if last else (stress[k + 1] - stress[k]) / (at[k + 1] - strain)
            elements.append(YieldElement(slope - beyond, strain))
            slope = beyond
        return tuple(element for element in elements if element.share > 0.0)

    @property
    def breaking_strain(self) -> Value | None:
        """Return the fibre strain at which it breaks [1], None where nothing is known of it.

        The elongation at break is such a strain itself and comes first. Without it the strength over Young's
        modulus is taken, the strain at which a brittle solid that stays linear to its end carries its strength.
        """
        if self.elongation_at_break is not None or self.strength is None:
            return self.elongation_at_break
        return Value(
            value=self.strength.value / self.young_modulus.value,
            unit="1",
            source=f"strength over Young's modulus, as of a brittle linear solid; strength: {self.strength.source}",
            assumed=self.strength.assumed or self.young_modulus.assumed,
        )
