"""Equilibria of a test that may be running: each row is read once."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from pathlib import Path

MOST: Final = 200
"""Rows handed out at a time: what a slow reader makes the service hold."""


class NewRows:
    """Reader of the rows of a job's file from a number on.

    Parameters
    ----------
    path : Path
        The file, one JSON text a line; it need not be there yet.
    since : int
        Number of the first row to hand out.

    Attributes
    ----------
    number : int
        Number of the row that comes next.
    """

    def __init__(self, path: Path, since: int) -> None:
        self.path, self.number = path, since
        self._line, self._offset = 0, 0

    def read(self) -> list[dict[str, Any]]:
        """Return the rows written since, at most `MOST`."""
        found: list[dict[str, Any]] = []
        try:
            with self.path.open("rb") as file:
                if file.seek(0, 2) < self._offset:
                    # A job that went on from its checkpoint writes the rows after it again, the same ones.
                    self._line = self._offset = 0
                file.seek(self._offset)
                while len(found) < MOST and (line := file.readline()).endswith(b"\n"):
                    if self._line >= self.number:
                        found.append(json.loads(line))
                    self._line, self._offset = self._line + 1, self._offset + len(line)
        except FileNotFoundError:
            return []
        self.number += len(found)
        return found
