"""A measured file over the test of a job: curves and scores, as `knitlab compare` has them."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from app.service.api.problems import ProblemError
from app.views.overlay import groups_of
from knitlab_core.errors import FormatError, SpecificationError
from rigs.analysis.comparison import comparison_table, quantities

if TYPE_CHECKING:
    from rigs.analysis.alignment import Alignment
    from rigs.analysis.comparison import Across, Along, Group
    from rigs.axes import FloatArray
    from rigs.readers.mapping import FileMapping

MOST_POINTS: Final = 2000
"""Points of a curve that an answer holds."""

MOST_TESTS: Final = 24
"""Curves of tests, axes and repeats together, that an answer holds; further repeats are in their band alone."""


def compared(
    content: bytes, name: str, record: Path, mapping: FileMapping, how: Alignment, axis: str | None
) -> dict[str, Any]:
    """Return a comparison as plain data, SI units.

    Parameters
    ----------
    content : bytes
        The measured file, a text.
    name : str
        What it is called.
    record : Path
        The record of the job.
    mapping, how, axis
        As in `app.views.overlay.compare`.

    Raises
    ------
    ProblemError
        If the file is no table that can be read, with its line; if both cannot be laid over each other; or if the test
        has no rows yet.
    """
    with TemporaryDirectory(prefix="knitlab-measured-") as folder:
        # Its suffix says that it is text: nothing else is ever tried.
        path = Path(folder) / "measured.csv"
        path.write_bytes(content)
        try:
            groups = groups_of([path, record], mapping, how, axis)
            across, along = quantities(groups)
            table = comparison_table(groups, across, along)
        except FormatError as error:
            raise _refusal(error, path, name) from error
        except SpecificationError as error:
            if str(error.field) == str(record):
                raise ProblemError("not-ready", "record: found no rows yet, allowed when the test has begun") from error
            parameter = error.field.removeprefix("--").replace("-", "_")
            detail = f"{parameter}: found {error.found}, allowed {error.expected}".replace(path.name, name)
            raise ProblemError(
                "invalid-request", detail, errors=[{"parameter": parameter, "detail": detail}]
            ) from error
    return {
        "across": across,
        "along": along,
        "curves": [curve for group in groups for curve in _curves(group, across, along, name)],
        "scores": [
            {
                "name": _called(str(test), name),
                "axis": axis,
                "cycle": cycle,
                "figure": figure,
                "value": float(value),
                "unit": unit,
                "low": _known(low),
                "high": _known(high),
            }
            for test, axis, cycle, figure, value, unit, low, high in table.rows()
        ],
    }


def _refusal(error: FormatError, path: Path, name: str) -> ProblemError:
    """Return the problem of a file that cannot be read, with its line; of a record that is not there yet."""
    if Path(error.path) != path:
        return ProblemError("not-ready", "record: found none that is whole, allowed when the test has begun")
    detail = f"{name}, line {error.line}: expected {error.expected}".replace(str(path), name)
    return ProblemError("invalid-request", detail, errors=[{"detail": detail, "line": error.line}])


def _called(test: str, name: str) -> str:
    return test.replace("measured.csv", name)


def _known(value: Any) -> float | None:  # noqa: ANN401 (a cell of a table)
    return float(value) if np.isfinite(float(value)) else None


def _curves(group: Group, across: Across, along: Along, name: str) -> list[dict[str, Any]]:
    """Return the curves of a group: of repeats their band about its mean, of one test its loading and unloading."""
    said = {"name": _called(group.name, name), "axis": group.axis, "measured": group.measured}
    if len(group.tests) > 1:
        band = group.band(across, along)
        parts = [("mean", band.mean), ("low", band.low), ("high", band.high)]
        repeats = group.curves(across, along)[:MOST_TESTS]
        return [
            *({**said, "part": part, **_points(band.x, values)} for part, values in parts),
            *({**said, "part": "repeat", **_points(x, y)} for x, y in repeats),
        ]
    (one,) = group.tests
    back = one.test.chosen(slice(int(np.argmax(one.test.travel)), None))
    return [
        {**said, "part": part, **_points(getattr(test, across), getattr(test, along))}
        for part, test in (("loading", one.loading), ("unloading", back))
        if len(test) > 1
    ]


def _points(x: FloatArray, y: FloatArray) -> dict[str, list[float]]:
    """Return the points of a curve that are known, at most `MOST_POINTS` of them."""
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if len(known) > MOST_POINTS:
        known = known[np.linspace(0, len(known) - 1, MOST_POINTS).round().astype(int)]
    return {"x": x[known].tolist(), "y": y[known].tolist()}
