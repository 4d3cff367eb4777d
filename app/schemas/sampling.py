"""Expansion of `sample:` into points: a design that fills the ranges of several parameters."""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from pydantic import Field

from app.schemas.base import Model
from app.schemas.document import dotted
from app.schemas.errors import Faults, ProtocolError, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.schemas.document import Document, Place

Method: TypeAlias = Literal["halton", "latin-hypercube", "random"]

MOST_SAMPLES: Final = 10_000
MOST_PARAMETERS: Final = 20
_VALUE: Final = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


class SampleModel(Model):
    """A design of points that fill the ranges of parameters."""

    points: int = Field(description="a whole number, such as 24")
    method: Method = Field(
        default="halton", description="halton, latin-hypercube or random; more points keep those of halton and random"
    )
    seed: int = Field(default=0, description="a whole number from 0")
    of: dict[str, list[str | int | float]] = Field(
        description="a mapping of names under params to the ends of their ranges, such as {h: [0.7, 0.9]}"
    )


def sampled(sample: SampleModel, params: Sequence[str], document: Document) -> list[dict[str, str | float]]:
    """Return the values of the parameters at every point of a design, rounded to four digits.

    Points of `halton` (Halton 1960, scrambled) and `random` designs begin with those of a smaller one; a
    `latin-hypercube` (McKay et al. 1979) has one point in each of as many slices of every range.

    Raises
    ------
    ProtocolError
        For a name that is no parameter, a range without two ends of one unit, or too many points.
    """
    faults = Faults()
    if not 1 <= sample.points <= MOST_SAMPLES:
        faults.found.append(
            _refusal(document, ("sample", "points"), shown(sample.points), f"a whole number from 1 to {MOST_SAMPLES}")
        )
    if not 1 <= len(sample.of) <= MOST_PARAMETERS:
        faults.found.append(
            _refusal(document, ("sample", "of"), f"{len(sample.of)} parameters", f"1 to {MOST_PARAMETERS}")
        )
    if sample.seed < 0:
        faults.found.append(_refusal(document, ("sample", "seed"), shown(sample.seed), "a whole number from 0"))
    ranges = [faults.of(partial(_range, sample, name, params, document), None) for name in sample.of]
    faults.raise_any()
    design = unit_design(sample.method, sample.points, len(sample.of), sample.seed)
    found = []
    for row in design:
        point: dict[str, str | float] = {}
        for name, share, ends in zip(sample.of, row, ranges, strict=True):
            low, high, unit = ends or (0.0, 0.0, "")
            value = float(f"{low + share * (high - low):.4g}")
            point[name] = f"{value:g} {unit}" if unit else value
        found.append(point)
    return found


def unit_design(method: Method, points: int, count: int, seed: int) -> list[list[float]]:
    """Return the points of a design in the unit cube of so many parameters."""
    from numpy.random import default_rng  # noqa: PLC0415 (only a protocol with a design needs it)
    from scipy.stats import qmc  # noqa: PLC0415

    if method == "random":
        design = default_rng(seed).random((points, count))
    elif method == "latin-hypercube":
        design = qmc.LatinHypercube(count, rng=default_rng(seed)).random(points)
    else:
        design = qmc.Halton(count, rng=default_rng(seed)).random(points)
    found: list[list[float]] = design.tolist()
    return found


def _range(sample: SampleModel, name: str, params: Sequence[str], document: Document) -> tuple[float, float, str]:
    """Return the ends of a parameter's range and their unit."""
    place: Place = ("sample", "of", name)
    if name not in params:
        expected = f"a name under params: {', '.join(params) or 'none'}{nearest(name, params)}"
        raise _refusal(document, place, repr(name), expected, key=True)
    ends = sample.of[name]
    if len(ends) != 2:
        raise _refusal(document, place, f"{len(ends)} values", "the two ends of a range, such as [0.7, 0.9]")
    first, last = (number_and_unit(end) for end in ends)
    if first is None or last is None or first[1] != last[1]:
        raise _refusal(document, place, shown(ends), "two numbers of one unit, such as [6 mm, 12 mm]")
    low, high = first[0], last[0]
    if not low < high:
        raise _refusal(document, place, shown(ends), "the smaller end first")
    return low, high, first[1]


def number_and_unit(value: object) -> tuple[float, str] | None:
    """Return the number of a value as it is written, and its unit; None if it is not a number.

    Examples
    --------
    >>> number_and_unit("6.5 mm"), number_and_unit(0.3), number_and_unit("pair")
    ((6.5, 'mm'), (0.3, ''), None)
    """
    found = None if isinstance(value, bool) else _VALUE.fullmatch(str(value))
    return None if found is None else (float(found[1]), found[2])


def _refusal(document: Document, place: Place, found: str, expected: str, *, key: bool = False) -> ProtocolError:
    """Return an error at a value, or at its key."""
    return ProtocolError(document.path, document.spot(place, key=key), dotted(place), found, expected)
