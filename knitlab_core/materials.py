"""Name the materials of yarns, each number with its source.

`the paper` stands for *Entanglement-driven responses through multiscale 3D-printed knits*.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """Hold one number of the real world, and say where it comes from.

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
class Material:
    """Describe a linearly elastic, isotropic yarn material.

    Parameters
    ----------
    name : str
        The name that protocols use.
    young_modulus : Value
        Young's modulus E [Pa].
    poisson_ratio : Value
        Poisson's ratio ν [1].
    strength : Value or None
        Ultimate tensile strength [Pa]; None where it must be given to speak of rupture.
    density : Value or None
        Mass density [kg/m³].
    note : str
        What a user should know before trusting the numbers.

    Raises
    ------
    SpecificationError
        For a modulus, strength or density not above zero, or a ratio outside (-1, 0.5].
    """

    name: str
    young_modulus: Value
    poisson_ratio: Value
    strength: Value | None = None
    density: Value | None = None
    note: str = ""

    def __post_init__(self) -> None:
        """Refuse numbers that no elastic solid can have."""
        above_zero = {"young_modulus": self.young_modulus, "strength": self.strength, "density": self.density}
        for field, entry in above_zero.items():
            if entry is not None and not 0.0 < entry.value < float("inf"):
                raise SpecificationError(f"material.{field}", entry.value, f"a number above 0 {entry.unit}")
        if not -1.0 < self.poisson_ratio.value <= 0.5:
            raise SpecificationError("material.poisson_ratio", self.poisson_ratio.value, "above -1, at most 0.5")

    @property
    def shear_modulus(self) -> float:
        """Return G = E / 2(1 + ν) [Pa]."""
        return self.young_modulus.value / (2.0 * (1.0 + self.poisson_ratio.value))


_PAPER: Final = "the paper, main text"
_ACRYLATE: Final = "usual for glassy acrylate resins; not published for this one"

_TABLE: Final = (
    Material(
        name="RGD8530-DM",
        young_modulus=Value(value=0.82e9, unit="Pa", source=_PAPER),
        poisson_ratio=Value(value=0.37, unit="1", source=_ACRYLATE, assumed=True),
        strength=Value(value=29e6, unit="Pa", source="low end of 29-38 MPa, quoted but unverified", assumed=True),
        note="Material-jetted digital material. Its creep is left out.",
    ),
    Material(
        name="VeroUltraWhite",
        young_modulus=Value(value=2.0e9, unit="Pa", source=_PAPER),
        poisson_ratio=Value(value=0.37, unit="1", source=_ACRYLATE, assumed=True),
        strength=Value(
            value=40e6,
            unit="Pa",
            source="low end of 40-55 MPa at 15-20 % elongation, manufacturer's range for Vero in PMC10406103, Table 2",
            assumed=True,
        ),
        density=Value(value=1180.0, unit="kg/m**3", source="approximate, for the cured resin", assumed=True),
        note="Material-jetted. Its creep is left out.",
    ),
    Material(
        name="IP-Dip",
        young_modulus=Value(value=3.0e9, unit="Pa", source=_PAPER),
        poisson_ratio=Value(value=0.35, unit="1", source=_ACRYLATE, assumed=True),
        note="Two-photon print. Others report 1-2.1 GPa (doi:10.1117/1.JOM.2.3.033501). Rupture needs a strength.",
    ),
    Material(
        name="cotton-2-ply",
        young_modulus=Value(value=0.85e9, unit="Pa", source="middle of 0.6-1.1 GPa along the yarn", assumed=True),
        poisson_ratio=Value(value=0.3, unit="1", source="a round number: twisted yarn is not isotropic", assumed=True),
        note="Machine-knitted, straight at rest; breaks below 10 % elongation.",
    ),
)

MATERIALS: Final[Mapping[str, Material]] = MappingProxyType({material.name: material for material in _TABLE})
"""The materials knitlab knows by name."""

DEFAULT_FRICTION: Final = Value(
    value=0.3, unit="1", source="not published for printed resins; 0.2-0.5 is usual for polymers", assumed=True
)
"""Coulomb coefficient of yarn on yarn, where a specimen does not give one."""


def material_named(name: str, field: str = "specimen.material") -> Material:
    """Return the material of a name.

    Parameters
    ----------
    name : str
        One of the keys of `MATERIALS`.
    field : str
        Field to blame for an unknown name.

    Raises
    ------
    SpecificationError
        For an unknown name; it lists the known ones and the nearest.

    Examples
    --------
    >>> print(material_named("RGD8530-DM").young_modulus)
    8.2e+08 Pa
    """
    if name in MATERIALS:
        return MATERIALS[name]
    lower = {known.lower(): known for known in MATERIALS}
    near = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=0.4)
    hint = f" (did you mean {lower[near[0]]}?)" if near else ""
    raise SpecificationError(field, name, f"one of {', '.join(MATERIALS)}{hint}")
