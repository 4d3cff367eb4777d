"""Routes of the shapes of a knit during its test, for the console's view."""

import logging
import time
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Annotated, TypeVar

import h5py
import numpy as np
from fastapi import APIRouter, Path
from fastapi.responses import Response

from app.records.vtkhdf import GROUP, count_frames, read_frame
from app.service.api.context import Here
from app.service.api.models import JobId, problems
from app.service.api.problems import ProblemError
from app.service.api.progress import Answer
from rigs.axes import AXES, DIRECTIONS
from rigs.record import PHASES, SpecimenSize

router = APIRouter(prefix="/v1/jobs/{job}/frames", tags=["files"])

Found = TypeVar("Found")

_TRIES = 12
_PAUSE = 0.025
"""Between tries to read a record [s]; a row is written in less."""

_log = logging.getLogger(__name__)

# By the names of the console: where the record keeps them.
_FIELDS = {
    "axial": "CellData/axial_strain",
    "bending": "CellData/bending_strain",
    "contact": "PointData/contact_force",
}


class FrameView(Answer):
    """Time, strain and phase of a shape."""

    time: float
    strain: dict[str, float]
    cycle: int
    phase: str


class FrameIndex(Answer):
    """The shapes of a test; lengths in metres."""

    nodes: int
    edges: int
    strands: list[int]
    radius: float
    section: dict[str, float]
    range: dict[str, tuple[float, float]]
    frames: list[FrameView]


def _read(folder: FilePath, what: Callable[[h5py.File], Found]) -> Found:
    """Return the reader of a job's record, which may be growing.

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
    raise ProblemError("not-ready", "frames: found no record yet, allowed when the test has begun")


@router.get("", summary="List the shapes of the knit through its test", responses=problems(404, 409, 422))
def frames(job: JobId, here: Here) -> FrameIndex:
    """Return time, strain and phase of every shape that was kept, and how to read the bytes of one.

    `range` is the least and largest value of each field over all shapes; `section` the area that carries each axis.
    """
    return _read(here.store.folder(job), _index)


def _index(file: h5py.File) -> FrameIndex:
    """Return the index of a record's shapes."""
    group, count = file[GROUP], count_frames(file)
    strands = [int(size) for size in file["strands"][()]]
    extents = {axis: float(file.attrs[f"extent_{axis}"]) for axis in DIRECTIONS}
    size = SpecimenSize(extents=extents, fibre_radius=float(file.attrs["fibre_radius"]))
    fields = group["FieldData"]
    axes = [axis for axis in AXES if f"strain_{axis}" in fields]
    times, phases, cycles = (column[:count] for column in (group["Steps/Values"], fields["phase"], fields["cycle"]))
    strains = {axis: fields[f"strain_{axis}"][:count] for axis in axes}
    return FrameIndex(
        nodes=sum(strands),
        edges=sum(strands) - len(strands),
        strands=strands,
        radius=size.fibre_radius,
        section={axis: size.section(axis) for axis in axes},
        range={name: _range(group[place]) for name, place in _FIELDS.items()},
        frames=[
            FrameView(
                time=float(times[k]),
                strain={axis: float(strains[axis][k]) for axis in axes},
                cycle=int(cycles[k]),
                phase=PHASES[int(phases[k])],
            )
            for k in range(count)
        ],
    )


def _range(column: h5py.Dataset) -> tuple[float, float]:
    """Return the least and the largest value without broken edges; read piece by piece."""
    low, high = np.inf, -np.inf
    for begin in range(0, len(column), 1_000_000):
        values = column[begin : begin + 1_000_000]
        values = values[np.isfinite(values)]
        if values.size:
            low, high = min(low, float(values.min())), max(high, float(values.max()))
    return (low, high) if low <= high else (0.0, 0.0)


@router.get(
    "/{number}",
    summary="Fetch a shape",
    response_class=Response,
    responses={
        200: {"content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}},
        **problems(404, 409, 422),
    },
)
def frame(job: JobId, number: Annotated[int, Path(ge=0, le=10**6, examples=[0])], here: Here) -> Response:
    """Return 32-bit floats, low byte first: nodes [m], axial, bending strain of edges, contact force of nodes [N]."""

    def shape(file: h5py.File) -> bytes:
        if number >= (count := count_frames(file)):
            raise ProblemError("unknown", f"frame: found {number}, allowed 0 to {count - 1}")
        found = read_frame(file, number, ())
        parts = (found.nodes.ravel(), found.axial_strain, found.bending_strain, found.contact_force)
        return np.concatenate(parts).astype("<f4").tobytes()

    return Response(_read(here.store.folder(job), shape), media_type="application/octet-stream")
