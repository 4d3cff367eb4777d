"""Quantities: a number with its unit, converted to an SI float once, where it is read.

The text is split into number and unit here, so that pint never evaluates arithmetic from a file.
"""

from __future__ import annotations

import functools
import math
import re
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from knitlab_core.errors import UnitError

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pint

Dimension: TypeAlias = Literal[
    "length",
    "speed",
    "time",
    "force",
    "frequency",
    "strain",
    "stress",
    "density",
    "strain rate",
    "force rate",
    "memory",
    "bending stiffness",
    "line force",
]

# SI unit; the unit people write; how errors describe what is allowed.
_DIMENSIONS: Final = MappingProxyType(
    {
        "length": ("m", "mm", "a length with its unit, such as 8 mm"),
        "speed": ("m/s", "mm/s", "a speed with its unit, such as 0.2 mm/s"),
        "time": ("s", "s", "a time with its unit, such as 10 s"),
        "force": ("N", "N", "a force with its unit, such as 50 mN"),
        "frequency": ("Hz", "Hz", "a frequency with its unit, such as 10 Hz"),
        "strain": ("dimensionless", "%", "a strain as a pure number or in per cent, such as 0.4 or 40 %"),
        "stress": ("Pa", "GPa", "a stress with its unit, such as 2.0 GPa"),
        "density": ("kg/m**3", "kg/m**3", "a density with its unit, such as 1180 kg/m^3"),
        "strain rate": ("1/s", "1/s", "a strain rate with its unit, such as 1e-3 1/s or 0.1 %/s"),
        "force rate": ("N/s", "N/s", "a force rate with its unit, such as 0.1 N/s"),
        "bending stiffness": (
            "N*m**2",
            "N mm^2",
            "a stiffness in bending or twisting with its unit, such as 0.045 N mm^2",
        ),
        "line force": ("N/m", "N/mm", "a force by length with its unit, such as 0.01 N/mm"),
        "memory": ("byte", "GiB", "a size of memory with its unit, such as 8 GiB"),
    }
)

# Factors to SI of the usual units; others are left to pint, which takes most of a second to load.
COMMON: Final[Mapping[Dimension, Mapping[str, float]]] = MappingProxyType(
    {
        "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9},
        "speed": {
            "m/s": 1.0,
            "mm/s": 1e-3,
            "um/s": 1e-6,
            "µm/s": 1e-6,
            "μm/s": 1e-6,
            "nm/s": 1e-9,
            "mm/min": 1e-3 / 60.0,
        },
        "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
        "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "µN": 1e-6, "μN": 1e-6, "kN": 1e3},
        "frequency": {"Hz": 1.0, "kHz": 1e3},
        "strain": {"%": 1e-2},
        "stress": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
        "density": {"kg/m^3": 1.0, "kg/m**3": 1.0},
        "strain rate": {"1/s": 1.0, "/s": 1.0, "%/s": 1e-2},
        "force rate": {"N/s": 1.0, "mN/s": 1e-3},
        "bending stiffness": {
            "N*m**2": 1.0,
            "N*m^2": 1.0,
            "N m^2": 1.0,
            "N mm^2": 1e-6,
            "N*mm^2": 1e-6,
            "N*mm**2": 1e-6,
            "mN mm^2": 1e-9,
        },
        "line force": {"N/m": 1.0, "mN/m": 1e-3, "N/mm": 1e3, "mN/mm": 1.0},
        "memory": {"MB": 1e6, "GB": 1e9, "MiB": 2.0**20, "GiB": 2.0**30},
    }
)

_NUMBER: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
_WORD: Final = r"[A-Za-zµμ%°]{1,24}(?:(?:\^|\*\*)-?\d)?"
_PRODUCT: Final = r"(?:\s*[*/]\s*|\s+(?=[A-Za-zµμ]))"
_QUANTITY: Final = re.compile(rf"\s*({_NUMBER})\s*((?:{_WORD}|1?\s*/\s*{_WORD})(?:{_PRODUCT}{_WORD}){{0,3}})\s*")
_SPACES: Final = re.compile(r"\s*([*/])\s*")


@functools.cache
def registry() -> pint.UnitRegistry[float]:
    """Return the one unit registry, loaded when it is first needed."""
    import pint  # noqa: PLC0415 (half a second that `knitlab --help` need not wait)

    return pint.UnitRegistry()


def allowed(dimension: Dimension) -> str:
    """Return the phrase that describes an allowed quantity of `dimension`."""
    return _DIMENSIONS[dimension][2]


def units_of(*dimensions: Dimension) -> list[str]:
    """Return the usual units of some dimensions, each in one spelling.

    Examples
    --------
    >>> units_of("length")
    ['m', 'cm', 'mm', 'µm', 'nm']
    """
    every = [unit for dimension in dimensions for unit in COMMON[dimension]]
    return [unit for unit in every if not re.match(r"[uμ/]|.*\*", unit)]


def parse(text: object, dimension: Dimension, field: str = "quantity") -> float:
    """Return a quantity in SI.

    Parameters
    ----------
    text : object
        A string such as ``0.2 mm/s``; for a strain a bare number too.
    dimension : str
        What it must measure.
    field : str
        Name to blame.

    Raises
    ------
    UnitError
        If it is no quantity of that dimension, or not finite.

    Examples
    --------
    >>> parse("8 mm", "length")
    0.008
    >>> parse("40 %", "strain")
    0.4
    >>> parse("8GiB", "memory") / 1024**3
    8.0
    """
    refusal = UnitError(field, text, allowed(dimension))
    if isinstance(text, int | float) and not isinstance(text, bool) and dimension == "strain":
        value = float(text)
    elif isinstance(text, str) and len(text) <= 100 and (match := _QUANTITY.fullmatch(text)):
        # Zero has one sign: the values kept of 0 and -0 would be one, that of whoever asked first.
        value = _convert(float(match[1]) + 0.0, match[2], dimension)
    else:
        raise refusal
    if not math.isfinite(value):
        raise refusal
    return value


def write(value: float, dimension: Dimension) -> str:
    """Return a quantity as text that `parse` reads back to the same float.

    Examples
    --------
    >>> write(0.008, "length")
    '8 mm'
    """
    si, usual, _ = _DIMENSIONS[dimension]
    magnitude = value * (1.0 / COMMON[dimension].get(usual, 1.0))
    # The usual unit is preferred; if it would lose the last bit, the SI unit is written.
    for text in (f"{magnitude:.12g} {usual}", f"{magnitude!r} {usual}"):
        if parse(text, dimension) == value:
            return text
    return f"{value!r} {si}"


# The jobs of a sweep contain the same few quantities thousands of times.
@functools.lru_cache(maxsize=4096)
def _convert(number: float, unit: str, dimension: Dimension) -> float:
    """Return `number` of `unit` in SI; NaN if it has another dimension."""
    common = COMMON[dimension].get(_SPACES.sub(r"\1", unit))
    return _convert_by_pint(number, unit, dimension) if common is None else number * common


def _convert_by_pint(number: float, unit: str, dimension: Dimension) -> float:
    """Return the same, of any unit there is."""
    import pint  # noqa: PLC0415 (as above)

    units = registry()
    try:
        given = units.Quantity(number, units.parse_units(f"1{unit}" if unit.startswith("/") else unit))
        quantity = given.to(_DIMENSIONS[dimension][0])
    except (pint.PintError, ValueError, AttributeError, OverflowError, ZeroDivisionError):
        return math.nan
    # For pint angles and bits are pure numbers: 600 rpm would be 62.8 Hz, 40 degrees a strain, 5 % a memory.
    base = str(given.to_base_units().units)
    if "radian" in base or ("bit" in base) != (dimension == "memory"):
        return math.nan
    return float(quantity.magnitude)
