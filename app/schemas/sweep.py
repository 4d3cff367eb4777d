"""Expansion of `sweep:` into points: all combinations of the values of its parameters; `sample:` has its own file."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final, TypeAlias

from app.file_names import MOST_BYTES, file_stem
from app.schemas.document import dotted
from app.schemas.errors import Faults, ProtocolError, nearest, shown
from app.schemas.sampling import sampled

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from app.schemas.document import Document, Place
    from app.schemas.models import ProtocolModel

Scalar: TypeAlias = str | int | float | bool

MOST_POINTS: Final = 10_000
#: A number with or without a unit, in whose name a sign that is not safe can become _ without a loss.
_NUMBER: Final = re.compile(r"[+-]?\.?\d[\w.+-]*\s*[\w%°/*^ .-]*\Z")
_UNSAFE: Final = re.compile(r"[^\w.+-]+")


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One point of a sweep: its parameter values, and the label that names its folder."""

    label: str
    values: Mapping[str, Scalar]


def points_of(model: ProtocolModel, document: Document) -> tuple[Point, ...]:
    """Return the points of a sweep in order, the last name running fastest, or those of a design; none without either.

    Raises
    ------
    ProtocolError
        For a name that is no parameter, a list without values or with one twice, or too many points.
    """
    sweep, sample = model.sweep, model.sample
    if sample is not None and sweep:
        raise _refusal(document, ("sample",), "sweep and sample", "one of the two", key=True)
    if sample is not None:
        points = sampled(sample, list(model.params), document)
        return tuple(Point(label=label_of(values), values=values) for values in points)
    return grid_of(sweep, list(model.params), document) if sweep else ()


def grid_of(sweep: Mapping[str, Sequence[Scalar]], params: Sequence[str], document: Document) -> tuple[Point, ...]:
    """Return the points of all combinations of the values of some parameters.

    Raises
    ------
    ProtocolError
        For a name that is no parameter, a list without values or with one twice, or too many points.
    """
    faults = Faults()
    for name, values in sweep.items():
        faults.of(partial(_check, name, values, params, document), None)
    faults.raise_any()
    count = math.prod(len(values) for values in sweep.values())
    if count > MOST_POINTS:
        raise _refusal(document, ("sweep",), f"{count} points", f"{MOST_POINTS} points or fewer")
    return tuple(Point(label=label_of(values), values=values) for values in combinations(sweep))


def combinations(values: Mapping[str, Sequence[Scalar]]) -> Iterator[dict[str, Scalar]]:
    """Yield every combination of the values of some parameters, the last name running fastest."""
    for chosen in itertools.product(*values.values()):
        yield dict(zip(values, chosen, strict=True))


def _check(name: str, values: Sequence[Scalar], params: Sequence[str], document: Document) -> None:
    """Raise unless a parameter may take each of some values, and each names a folder of its own."""
    place: Place = ("sweep", name)
    if name not in params:
        expected = f"a name under params: {', '.join(params) or 'none'}{nearest(name, params)}"
        raise _refusal(document, place, repr(name), expected, key=True)
    if not values:
        raise _refusal(document, place, "an empty list", "one value or more")
    faults, words = Faults(), dict[str, str]()
    for number, value in enumerate(values):
        word, spot = _word(value), (*place, number)
        # Windows and macOS take names that differ in capitals alone for one.
        same = words.get(word.casefold())
        words.setdefault(word.casefold(), word)
        if isinstance(value, str) and "${" in value:
            faults.found.append(_refusal(document, spot, shown(value), "a number or a text without ${"))
        elif same is not None:
            once = "each value once" if same == word else "values that differ by more than their capitals"
            faults.found.append(_refusal(document, spot, shown(value), once))
    faults.raise_any()


def label_of(values: Mapping[str, Scalar]) -> str:
    """Return the label and folder name of a point, from its own values alone.

    Examples
    --------
    >>> label_of({"pre": 0.1, "rate": "0.2 mm/s"}), label_of({"knit": "mine (2)"})
    ('pre=0.1,rate=0.2_mm_s', 'knit=mine_2-1589dcaa')
    """
    label = ",".join(f"{name}={_word(value)}" for name, value in values.items())
    # Each word is a safe name, but together they may be too long.
    return label if len(label.encode()) <= MOST_BYTES else file_stem(label)


def _word(value: Scalar) -> str:
    """Return a value as it appears in the name of a folder."""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return _UNSAFE.sub("_", text) if _NUMBER.match(text) else file_stem(text)


def _refusal(document: Document, place: Place, found: str, expected: str, *, key: bool = False) -> ProtocolError:
    """Return an error at a value, or at its key."""
    return ProtocolError(document.path, document.spot(place, key=key), dotted(place), found, expected)
