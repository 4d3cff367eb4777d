"""Reading of the record of a job that may be going on."""

from __future__ import annotations

import logging
import time
from typing import TYPE_CHECKING, Final, TypeVar

import h5py

from app.service.api.problems import ProblemError
from rigs.axes import AXES, DIRECTIONS
from rigs.record import SpecimenSize

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rigs.axes import Axis

Found = TypeVar("Found")

_TRIES: Final = 12
_PAUSE: Final = 0.025
"""Between tries to read a record [s]; a row is written in less."""

_log = logging.getLogger(__name__)


def read_record(folder: Path, what: Callable[[h5py.File], Found]) -> Found:
    """Return what is read of a job's record, which may be growing.

    Nothing locks the record, so that a test never waits for who looks at it: what is read while a row is written may be
    torn, and is read again.

    Raises
    ------
    ProblemError
        If there is none yet.
    """
    for attempt in range(_TRIES):
        try:
            with h5py.File(folder / "run" / "run.h5", "r", locking=False) as file:
                return what(file)
        except FileNotFoundError:
            break
        except (OSError, KeyError, ValueError, IndexError, RuntimeError) as error:
            _log.debug("record of %s, try %d: %s", folder.name, attempt, error)
            time.sleep(_PAUSE)
    raise ProblemError("not-ready", "record: found none yet, allowed when the test has begun")


def sections_of(file: h5py.File) -> dict[Axis, float]:
    """Return the area that carries each axis of the specimen of a record [m²]."""
    extents = {axis: float(file.attrs[f"extent_{axis}"]) for axis in DIRECTIONS}
    size = SpecimenSize(extents=extents, fibre_radius=float(file.attrs["fibre_radius"]))
    return {axis: size.section(axis) for axis in AXES}
