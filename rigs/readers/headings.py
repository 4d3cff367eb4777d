"""What the headings of instruments' files mean: a quantity, an axis and a unit."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from rigs.axes import AXES
from rigs.logs.units import UNITS

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

Quantity: TypeAlias = Literal[
    "time", "travel", "distance", "force", "strain", "stress", "width", "cycle", "phase", "segment", "repeat", "other"
]

DIMENSIONS: Final[Mapping[Quantity, str]] = {
    "time": "time",
    "travel": "length",
    "distance": "length",
    "width": "length",
    "force": "force",
    "strain": "strain",
    "stress": "stress",
}
"""Which units a quantity may have; others have none."""

FACTORS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"h": 3600.0, "hr": 3600.0, "msec": 1e-3, "secs": 1.0, "seconds": 1.0, "minutes": 60.0},
    "length": {"cm": 1e-2, "µm": 1e-6, "μm": 1e-6, "micron": 1e-6, "microns": 1e-6, "in": 0.0254, "inch": 0.0254},
    "force": {"µN": 1e-6, "μN": 1e-6, "cN": 1e-2, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.4482216152605},
    "stress": {"GPa": 1e9, "N/mm²": 1e6, "N/mm2": 1e6, "N/mm^2": 1e6, "N/m²": 1.0, "psi": 6894.757293168},
    "strain": {"1": 1.0, "-": 1.0, "m/m": 1.0, "mm/mm": 1.0, "strain": 1.0, "in/in": 1.0},
}
"""Factors to SI of units that only others write."""

_BEFORE: Final = r"(.*[\W_])?"
_AFTER: Final = r"([\W_].*)?"

_WORDS: Final[tuple[tuple[str, Quantity], ...]] = (
    (r"maximum .*|.* at (maximum|break|peak).*|raw .*|biaxial-hook\.time", "other"),
    (r"total cycle count|cycle( (count|number))?|cycles|zyklus(zähler)?|循环计数", "cycle"),
    (r"segment id", "segment"),
    (r"repeat|repetition|specimen( number)?|probe", "repeat"),
    (rf"{_BEFORE}(time|zeit|prüfzeit|temps|czas|godzina|时间)( 1| measurement)?", "time"),
    (rf"{_BEFORE}([xy]|current )?(size|distance|grip separation|einspannlänge)", "distance"),
    (rf"{_BEFORE}(transverse|lateral|width|breite){_AFTER}", "width"),
    (rf"{_BEFORE}(stress|(zug|druck|biege)?spannung|contrainte|(拉伸|压缩)?应力){_AFTER}", "stress"),
    (rf"{_BEFORE}(strain|(zug|biege)?dehnung|stauchung|déformation|(拉伸|压缩)?应变){_AFTER}", "strain"),
    (rf"{_BEFORE}[xy]?(force|load|(standard|zug|druck)?kraft|last|charge|载荷|力){_AFTER}", "force"),
    (rf"{_BEFORE}[xy]?(extension|displacement|travel|crosshead|position){_AFTER}", "travel"),
    (
        rf"{_BEFORE}((standard|traversen)?weg|verlängerung|déplacement|allongement|przemieszczenie|位移){_AFTER}",
        "travel",
    ),
)
_QUANTITIES: Final = tuple((re.compile(pattern), quantity) for pattern, quantity in _WORDS)
_UNIT: Final = r"[%A-Za-zµμ°²/^0-9-]{1,8}"
_WITH_UNIT: Final = (
    re.compile(rf"(.+?)\s*[\[(]\s*({_UNIT})\s*[\])]"),
    re.compile(rf"(.+?)\s+(?:/|in)\s+({_UNIT})"),
    re.compile(rf"(.+?)[_ ,]\s*({_UNIT})"),
)
_AXIS: Final = re.compile(rf"[_ ]({'|'.join(AXES)})$")
_BELOW: Final = re.compile(rf"[\[(]?\s*({_UNIT})?\s*[\])]?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading:
    """Meaning of a heading.

    Attributes
    ----------
    text : str
        As it stands in the file.
    quantity : Quantity
        What the column holds; ``other`` for what is not analysed.
    axis : str
        ``C``, ``W``, ``P``, ``WC`` of a shear, or none where the heading does not say.
    unit : str
        Its unit as the file writes it; empty where it does not.
    """

    text: str
    quantity: Quantity
    axis: str = ""
    unit: str = ""


def factor_to_si(quantity: Quantity, unit: str) -> float | None:
    """Return how many SI units a unit is; 1 where a quantity has none, None if the unit is not one of the quantity.

    Examples
    --------
    >>> factor_to_si("force", "mN"), factor_to_si("strain", "%"), factor_to_si("travel", "N")
    (0.001, 0.01, None)
    """
    if quantity not in DIMENSIONS:
        return 1.0
    dimension = DIMENSIONS[quantity]
    name = unit.lower() if quantity == "time" else unit
    if name in UNITS[dimension]:
        return 1.0 / UNITS[dimension][name]
    return FACTORS[dimension].get(name)


def meaning(text: str) -> Heading:
    """Return what a heading means.

    Examples
    --------
    >>> heading = meaning("XForce_mN")
    >>> heading.quantity, heading.axis, heading.unit
    ('force', 'C', 'mN')
    >>> meaning("Tensile strain (Strain 1)").quantity, meaning("Kraft [kN]").unit, meaning("remark").quantity
    ('strain', 'kN', 'other')
    """
    plain = text.strip().strip('"')
    for pattern in _WITH_UNIT:
        if match := pattern.fullmatch(plain):
            quantity = _quantity(match[1])
            if quantity in DIMENSIONS and factor_to_si(quantity, match[2]) is not None:
                return Heading(text=text, quantity=quantity, axis=_axis(match[1]), unit=match[2])
    return Heading(text=text, quantity=_quantity(plain), axis=_axis(plain))


def unit_below(text: str) -> str | None:
    """Return the unit in a field below a heading, ``(mm)`` or ``mm``, empty where it is blank; None if it is none."""
    match = _BELOW.fullmatch(text.strip())
    return None if match is None else match[1] or ""


def by_unit(heading: Heading, unit: str, taken: Collection[Quantity]) -> Heading:
    """Return what a heading in an unknown language means by its unit, unless another column has that quantity."""
    if heading.quantity != "other" or heading.text.casefold().startswith(("maximum ", "raw ")):
        return replace(heading, unit=unit or heading.unit)
    for quantity in ("time", "travel", "force", "stress", "strain"):
        if unit and quantity not in taken and factor_to_si(quantity, unit) is not None:
            return replace(heading, quantity=quantity, unit=unit)
    return replace(heading, unit=unit)


def is_force(unit: str) -> bool:
    """Return whether a unit is one of force."""
    return factor_to_si("force", unit) is not None


def _quantity(name: str) -> Quantity:
    plain = name.strip().casefold().replace("_", " ")
    return next((quantity for pattern, quantity in _QUANTITIES if pattern.fullmatch(plain)), "other")


def _axis(name: str) -> str:
    """Return the axis that a heading names: x is the course, y the wale; the triaxial rig's frame pulls the pile."""
    plain = name.strip().rpartition(".")
    if plain[0] == "uniaxial-frame" or plain[2].startswith("Corrected "):
        return "P"
    if match := re.match(r"([XY])[A-Z_ ]", plain[2]):
        return {"X": "C", "Y": "W"}[match[1]]
    match = _AXIS.search(name.strip())
    return match[1] if match else ""
