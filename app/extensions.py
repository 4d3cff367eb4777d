"""Extensions that installed packages bring: fabrics, rigs, machines, dialects of logs."""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points
from typing import Final

from knitlab_core.errors import SpecificationError

GROUP: Final = "knitlab.extensions"
"""Group of the entry points; each names a function without arguments that registers its parts."""


@cache
def load_extensions() -> None:
    """Register the parts of every installed extension, once a process.

    Raises
    ------
    SpecificationError
        If an extension cannot be imported, or fails while it registers.
    """
    for point in entry_points(group=GROUP):
        try:
            point.load()()
        except Exception as error:  # whatever the code of others raises is one line
            found = f"{point.value}: {type(error).__name__}: {error}".replace("\n", " ")
            raise SpecificationError(f"{GROUP}.{point.name}", found, "a function that registers its parts") from error
