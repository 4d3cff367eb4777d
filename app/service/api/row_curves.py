"""Curves of a test from its rows, thinned to what can be seen of them."""

from __future__ import annotations

import json
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigs.axes import Axis, FloatArray

MOST_POINTS: Final = 4000
"""Points of a curve that an answer holds, about."""


def row_curves(rows: Path, sections: Mapping[Axis, float]) -> dict[str, Any]:
    """Return time, cycle and, by axis, strain [1], force [N] and stress [Pa] of the rows of a test as columns.

    Parameters
    ----------
    rows : Path
        File of the rows, one JSON text a line; it need not be there yet.
    sections : Mapping
        Area that carries each axis [m²].
    """
    found = _read(rows)
    axes = list(found[0]["force"]) if found else []
    force = {axis: np.array([row["force"][axis] for row in found]) for axis in axes}
    kept = thinned(list(force.values()), MOST_POINTS)
    return {
        "rows": len(found),
        "section": {axis: sections[axis] for axis in axes},
        "time": [found[k]["time"] for k in kept],
        "cycle": [found[k]["cycle"] for k in kept],
        "strain": {axis: [found[k]["strain"][axis] for k in kept] for axis in axes},
        "force": {axis: force[axis][kept].tolist() for axis in axes},
        "stress": {axis: (force[axis][kept] / sections[axis]).tolist() for axis in axes},
    }


def _read(rows: Path) -> list[dict[str, Any]]:
    """Return the rows that are written whole."""
    with suppress(FileNotFoundError), rows.open("rb") as file:
        return [json.loads(line) for line in file if line.endswith(b"\n")]
    return []


def thinned(columns: list[FloatArray], most: int) -> list[int]:
    """Return which points of columns of one length are kept.

    Of few all; of many the first of every stretch of neighbours, its lowest and highest of each column, and the last.
    """
    count = len(columns[0]) if columns else 0
    if count <= most:
        return list(range(count))
    stretch = -(-count * (1 + 2 * len(columns)) // most)
    kept = {count - 1}
    for begin in range(0, count, stretch):
        kept.add(begin)
        for column in columns:
            part = column[begin : begin + stretch]
            kept |= {begin + int(np.argmin(part)), begin + int(np.argmax(part))}
    return sorted(kept)
