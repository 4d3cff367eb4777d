"""Unfold `sweep:` into points: one value of every parameter that is swept, all of them with all others."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

from app.schemas.document import dotted
from app.schemas.errors import ProtocolError, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Document, Place
    from app.schemas.models import ProtocolModel

Scalar: TypeAlias = str | int | float | bool

MOST_POINTS: Final = 10_000
_UNSAFE: Final = re.compile(r"[^A-Za-z0-9.+-]+")


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """Hold the values of one point of a sweep, and the label that names its folder."""

    label: str
    values: Mapping[str, Scalar]


def points_of(model: ProtocolModel, document: Document) -> tuple[Point, ...]:
    """Return the points of a sweep in order, the last name running fastest; none without a sweep.

    Raises
    ------
    ProtocolError
        For a name that is no parameter, a list without values or with one twice, or too many points.
    """
    sweep = model.sweep
    if not sweep:
        return ()
    for name, values in sweep.items():
        place: Place = ("sweep", name)
        if name not in model.params:
            known = ", ".join(model.params) or "none"
            expected = f"a name under params: {known}{nearest(name, model.params)}"
            raise _refusal(document, place, repr(name), expected, key=True)
        if not values:
            raise _refusal(document, place, "an empty list", "one value or more")
        for number, value in enumerate(values):
            if isinstance(value, str) and "${" in value:
                raise _refusal(document, (*place, number), shown(value), "a number or a text without ${")
            if _word(value) in map(_word, values[:number]):
                raise _refusal(document, (*place, number), shown(value), "each value once")
    count = math.prod(len(values) for values in sweep.values())
    if count > MOST_POINTS:
        raise _refusal(document, ("sweep",), f"{count} points", f"{MOST_POINTS} points or fewer")
    return tuple(
        Point(label=label_of(dict(zip(sweep, values, strict=True))), values=dict(zip(sweep, values, strict=True)))
        for values in itertools.product(*sweep.values())
    )


def label_of(values: Mapping[str, Scalar]) -> str:
    """Return what a point is called.

    Examples
    --------
    >>> label_of({"pre": 0.1, "rate": "0.2 mm/s"})
    'pre=0.1,rate=0.2_mm_s'
    """
    return ",".join(f"{name}={_word(value)}" for name, value in values.items())


def _word(value: Scalar) -> str:
    """Return a value as it may stand in the name of a folder."""
    return _UNSAFE.sub("_", str(value).lower() if isinstance(value, bool) else str(value))


def _refusal(document: Document, place: Place, found: str, expected: str, *, key: bool = False) -> ProtocolError:
    """Return an error at a value, or at its key."""
    return ProtocolError(document.path, document.spot(place, key=key), dotted(place), found, expected)
