"""Answer with the shapes of a knit through its test, as the console's view of it wants them."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Annotated

import h5py
import numpy as np
from fastapi import APIRouter, Path
from fastapi.responses import Response

from app.service.api.context import Here
from app.service.api.models import Answer, JobId, problems
from app.service.api.problems import ProblemError
from app.vtkhdf import GROUP, count_frames, read_frame
from rigs.record import PHASES
from rigs.steps import AXES

router = APIRouter(prefix="/v1/jobs/{job}/frames", tags=["files"])

# By the names of the console: where the record keeps them.
_FIELDS = {
    "axial": "CellData/axial_strain",
    "bending": "CellData/bending_strain",
    "contact": "PointData/contact_force",
}


class FrameView(Answer):
    """Say what a shape is of."""

    time: float
    strain: dict[str, float]
    cycle: int
    phase: str


class FrameIndex(Answer):
    """Describe the shapes of a test; lengths in metres."""

    nodes: int
    edges: int
    strands: list[int]
    radius: float
    section: dict[str, float]
    range: dict[str, tuple[float, float]]
    frames: list[FrameView]


@contextmanager
def _record(folder: FilePath) -> Iterator[h5py.File]:
    """Open the record of a job's test, which may be going on.

    Raises
    ------
    ProblemError
        If there is none yet, or it is being written just now.
    """
    try:
        with h5py.File(folder / "run" / "run.h5", "r", locking=False) as file:
            yield file
    except (OSError, KeyError, ValueError) as error:
        raise ProblemError("not-ready", "frames: found no record yet, allowed when the test has begun") from error


@router.get("", summary="List the shapes of the knit through its test", responses=problems(404, 409, 422))
def frames(job: JobId, here: Here) -> FrameIndex:
    """Return time, strain and phase of every shape that was kept, and how to read the bytes of one.

    `range` is the least and largest value of each field over all shapes; `section` the area that carries each axis.
    """
    with _record(here.store.folder(job)) as file:
        group, count = file[GROUP], count_frames(file)
        strands = [int(size) for size in file["strands"][()]]
        extents = {axis: float(file.attrs[f"extent_{axis}"]) for axis in AXES}
        fields = group["FieldData"]
        axes = [axis for axis in AXES if f"strain_{axis}" in fields]
        times, phases, cycles = (column[:count] for column in (group["Steps/Values"], fields["phase"], fields["cycle"]))
        strains = {axis: fields[f"strain_{axis}"][:count] for axis in axes}
        return FrameIndex(
            nodes=sum(strands),
            edges=sum(strands) - len(strands),
            strands=strands,
            radius=float(file.attrs["fibre_radius"]),
            section={axis: float(np.prod([extents[other] for other in AXES if other != axis])) for axis in axes},
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
    """Return the least and the largest value, broken edges left out; read piece by piece."""
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
    with _record(here.store.folder(job)) as file:
        if number >= (count := count_frames(file)):
            raise ProblemError("unknown", f"frame: found {number}, allowed 0 to {count - 1}")
        shape = read_frame(file, number, ())
    parts = (shape.nodes.ravel(), shape.axial_strain, shape.bending_strain, shape.contact_force)
    return Response(np.concatenate(parts).astype("<f4").tobytes(), media_type="application/octet-stream")
