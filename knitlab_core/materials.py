"""Materials of yarns, each number with its source.

`the paper` stands for *Entanglement-driven responses through multiscale 3D-printed knits*.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """A measured or assumed number with its source.

    Parameters
    ----------
    value : float
        The number, in SI.
    unit : str
        Its SI unit: ``Pa``, ``kg/m**3``; ``1`` for a pure number.
    source : str
        Where it was found, or why it was chosen.
    assumed : bool
        Whether it is a choice rather than a figure of its source.
    """

    value: float
    unit: str
    source: str
    assumed: bool = False

    def __str__(self) -> str:
        """Return the number, its unit and, where it is a choice, the word `assumed`."""
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.value:g}{unit}{' (assumed)' if self.assumed else ''}"


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


_PAPER: Final = "the paper, main text"
_ACRYLATE: Final = "usual for glassy acrylate resins; not published for this one"
_VERO: Final = "40-55 MPa at 15-20 % elongation, manufacturer's range for Vero in PMC10406103, Table 2"
_DIGITAL: Final = "29-38 MPa at 15-25 % elongation, quoted for this digital material but unverified"
_MICROFIBRES: Final = "microfibres of a two-photon dimethacrylate yield at 2-4 % (doi:10.1002/smsc.202500228)"


def _curve(source: str, *points: tuple[float, float]) -> tuple[CurvePoint, ...]:
    """Return a yield curve through points of strain [1] and stress [Pa] whose shape is a choice."""
    return tuple(
        CurvePoint(
            strain=Value(value=strain, unit="1", source=source, assumed=True),
            stress=Value(value=stress, unit="Pa", source=source, assumed=True),
        )
        for strain, stress in points
    )


def _series(source: str, *terms: tuple[float, float]) -> tuple[RelaxationTerm, ...]:
    """Return a Prony series of shares [1] and times [s] that is a choice."""
    return tuple(
        RelaxationTerm(
            share=Value(value=share, unit="1", source=source, assumed=True),
            time=Value(value=time, unit="s", source=source, assumed=True),
        )
        for share, time in terms
    )


_TABLE: Final = (
    Material(
        name="RGD8530-DM",
        young_modulus=Value(value=0.82e9, unit="Pa", source=_PAPER),
        poisson_ratio=Value(value=0.37, unit="1", source=_ACRYLATE, assumed=True),
        strength=Value(value=29e6, unit="Pa", source=f"low end of {_DIGITAL}", assumed=True),
        elongation_at_break=Value(value=0.15, unit="1", source=f"low end of {_DIGITAL}", assumed=True),
        relaxation=_series(
            "chosen so that a knit's loops come near the paper's; none is published for this resin",
            (0.12, 10.0),
            (0.15, 50.0),
            (0.10, 300.0),
        ),
        yield_curve=_curve(
            f"rounded, as glassy acrylates are, from 1 % up to strength and elongation: low ends of {_DIGITAL}",
            (0.01, 8.2e6),
            (0.03, 18e6),
            (0.06, 25e6),
            (0.15, 29e6),
        ),
        note="Material-jetted digital material. Ductile: an elastic fibre carries too much beyond 1 % (`yield: on`).",
    ),
    Material(
        name="VeroUltraWhite",
        young_modulus=Value(value=2.0e9, unit="Pa", source=_PAPER),
        poisson_ratio=Value(value=0.37, unit="1", source=_ACRYLATE, assumed=True),
        strength=Value(value=40e6, unit="Pa", source=f"low end of {_VERO}", assumed=True),
        elongation_at_break=Value(value=0.15, unit="1", source=f"low end of {_VERO}", assumed=True),
        density=Value(value=1180.0, unit="kg/m**3", source="approximate, for the cured resin", assumed=True),
        relaxation=_series(
            "two thirds of what is assumed of RGD8530-DM, which has a soft resin in it; none is published",
            (0.08, 10.0),
            (0.10, 50.0),
            (0.07, 300.0),
        ),
        yield_curve=_curve(
            f"rounded, as glassy acrylates are, from 1 % up to the low end of {_VERO}",
            (0.01, 20e6),
            (0.02, 33e6),
            (0.04, 39e6),
            (0.15, 40e6),
        ),
        note="Material-jetted. It yields near 2 %, long before it breaks: use `yield: on` beyond.",
    ),
    Material(
        name="IP-Dip",
        young_modulus=Value(value=3.0e9, unit="Pa", source=_PAPER),
        poisson_ratio=Value(value=0.35, unit="1", source=_ACRYLATE, assumed=True),
        elongation_at_break=Value(
            value=0.10,
            unit="1",
            source="a round number; two-photon fibres range from brittle to soft and plastic with their processing "
            "(doi:10.1039/C9RA02350J)",
            assumed=True,
        ),
        relaxation=_series(
            "half of what is assumed of RGD8530-DM, for a denser network; none is published",
            (0.06, 10.0),
            (0.07, 50.0),
            (0.05, 300.0),
        ),
        yield_curve=_curve(
            f"{_MICROFIBRES}; rounded beyond, up to the breaking strain",
            (0.02, 60e6),
            (0.05, 80e6),
            (0.10, 88e6),
        ),
        note="Two-photon print. Others report 1-2.1 GPa (doi:10.1117/1.JOM.2.3.033501).",
    ),
    Material(
        name="cotton-2-ply",
        young_modulus=Value(value=0.85e9, unit="Pa", source="middle of 0.6-1.1 GPa along the yarn", assumed=True),
        poisson_ratio=Value(value=0.3, unit="1", source="a round number: twisted yarn is not isotropic", assumed=True),
        elongation_at_break=Value(
            value=0.10, unit="1", source="upper end: machine-knitted cotton breaks below 10 %", assumed=True
        ),
        note="Machine-knitted, straight at rest; breaks below 10 % elongation.",
    ),
)

MATERIALS: Final[Mapping[str, Material]] = MappingProxyType({material.name: material for material in _TABLE})
"""The materials that have a name."""

DEFAULT_FRICTION: Final = Value(
    value=0.3, unit="1", source="not published for printed resins; 0.2-0.5 is usual for polymers", assumed=True
)
"""Coulomb coefficient of yarn on yarn, where a specimen does not give one."""


def material_named(name: str, field: str = "specimen.material", known: Mapping[str, Material] = MATERIALS) -> Material:
    """Return the material of a name.

    Parameters
    ----------
    name : str
        One of the keys of `known`.
    field : str
        Field to blame for an unknown name.
    known : Mapping
        The materials to choose from: the catalogue, or the catalogue and a user's own.

    Raises
    ------
    SpecificationError
        For an unknown name; it lists the known ones and the nearest.

    Examples
    --------
    >>> print(material_named("RGD8530-DM").young_modulus)
    8.2e+08 Pa
    """
    if name in known:
        return known[name]
    lower = {other.lower(): other for other in known}
    near = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=0.4)
    hint = f" (did you mean {lower[near[0]]}?)" if near else ""
    raise SpecificationError(field, name, f"one of {', '.join(known)}{hint}")
