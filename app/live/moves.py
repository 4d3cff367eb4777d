"""Steps of a live rig from numbers in SI or from texts with units."""

from __future__ import annotations

from contextlib import suppress
from numbers import Real
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from app.schemas.units import parse
from knitlab_core.errors import SpecificationError, UnitError
from rigs.protocol.steps import Ramp
from rigs.protocol.targets import Control, ForceRate, Rate, StrainRate, Target

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from app.schemas.units import Dimension
    from rigs.axes import Axis

Quantity = float | str
"""A number in SI, or a text with its unit."""

_DIMENSIONS: Final[Mapping[Control, Dimension]] = MappingProxyType(
    {"strain": "strain", "displacement": "length", "force": "force"}
)


def number_of(given: object, dimension: Dimension, field: str) -> float:
    """Return a quantity in SI.

    Raises
    ------
    SpecificationError
        If it is neither a number nor a text with its unit.

    Examples
    --------
    >>> number_of(5e-3, "length", "C"), number_of("5 mm", "length", "C")
    (0.005, 0.005)
    """
    if isinstance(given, bool) or not isinstance(given, Real):
        return parse(given, dimension, field)
    return float(given)


def rate_of(given: Rate | str, kind: Control) -> Rate:
    """Return the rate of a move to a target of a kind; a bare number is in m/s, or N/s where a force is controlled.

    Raises
    ------
    SpecificationError
        If it is no rate.

    Examples
    --------
    >>> rate_of("0.2 mm/s", "displacement"), rate_of(0.01, "force")
    (0.0002, ForceRate(value=0.01))
    """
    if isinstance(given, StrainRate | ForceRate):
        return given
    if kind == "force":
        return ForceRate(value=number_of(given, "force rate", "rate"))
    with suppress(UnitError):
        return number_of(given, "speed", "rate")
    try:
        return StrainRate(value=parse(given, "strain rate", "rate"))
    except UnitError as error:
        raise UnitError("rate", given, "a speed or a strain rate, such as 0.2 mm/s or 1e-3 1/s") from error


def ramp_of(
    kind: Control,
    levels: Mapping[str, Quantity],
    rate: Rate | str,
    driven: Sequence[Axis],
    **named: Any,  # noqa: ANN401 (until, log and tag of a ramp)
) -> Ramp:
    """Return the ramp of some axes to their levels.

    Parameters
    ----------
    kind : {'strain', 'displacement', 'force'}
        What the levels are.
    levels : Mapping
        The level of each axis that moves; one for all of them.
    rate : Rate or str
        How fast.
    driven : sequence of Axis
        The axes of the rig.
    **named
        `until`, `log` and `tag` of the ramp.

    Raises
    ------
    SpecificationError
        If an axis is not driven, or levels differ.
    """
    axes = [axis for axis in driven if axis in levels]
    unknown = [name for name in levels if name not in driven]
    have = " or ".join(f"{axis}=..." for axis in driven)
    if unknown or not axes:
        raise SpecificationError("move", ", ".join(unknown) or "no axis", f"axes of this rig: {have}")
    values = {axis: number_of(levels[axis], _DIMENSIONS[kind], axis) for axis in axes}
    if len(set(values.values())) > 1:
        found = ", ".join(f"{axis}={value:g}" for axis, value in values.items())
        raise SpecificationError(
            "move", found, "one level for all axes that move together, or one move after the other"
        )
    target = Target(kind=kind, value=values[axes[0]])
    return Ramp(axes=tuple(axes), to=target, rate=rate_of(rate, kind), **named)
