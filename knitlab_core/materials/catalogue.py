"""Materials that have a name, each number with its source.

`the paper` stands for *Entanglement-driven responses through multiscale 3D-printed knits*.
"""

from __future__ import annotations

import difflib
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, TypeAlias, TypeVar, overload

from knitlab_core.errors import SpecificationError
from knitlab_core.materials.solids import CurvePoint, Material, RelaxationTerm
from knitlab_core.materials.values import Value
from knitlab_core.materials.yarns import MeasuredYarn

if TYPE_CHECKING:
    from collections.abc import Mapping

Substance: TypeAlias = Material | MeasuredYarn
"""What a yarn is made of: a solid material, or the yarn itself as it was measured."""

SubstanceT = TypeVar("SubstanceT", bound=Substance)

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


@overload
def material_named(name: str, field: str = "specimen.material") -> Material: ...


@overload
def material_named(name: str, field: str = "specimen.material", *, known: Mapping[str, SubstanceT]) -> SubstanceT: ...


def material_named(
    name: str, field: str = "specimen.material", *, known: Mapping[str, Substance] = MATERIALS
) -> Substance:
    """Return the material, or the yarn by measurement, of a name.

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
