"""Routes of the shapes of a knit during its test, for the console's view."""

from typing import Annotated

import h5py
import numpy as np
from fastapi import APIRouter, Path
from fastapi.responses import Response

from app.records.vtkhdf import GROUP, count_frames, read_frame
from app.service.api.context import Here
from app.service.api.growing_record import read_record, sections_of
from app.service.api.models import JobId, problems
from app.service.api.problems import ProblemError
from app.service.api.progress import Answer
from rigs.axes import AXES
from rigs.record import PHASES

router = APIRouter(prefix="/v1/jobs/{job}/frames", tags=["files"])

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


@router.get("", summary="List the shapes of the knit through its test", responses=problems(404, 409, 422))
def frames(job: JobId, here: Here) -> FrameIndex:
    """Return time, strain and phase of every shape that was kept, and how to read the bytes of one.

    `range` is the least and largest value of each field over all shapes; `section` the area that carries each axis.
    """
    return read_record(here.store.folder(job), _index)


def _index(file: h5py.File) -> FrameIndex:
    """Return the index of a record's shapes."""
    group, count = file[GROUP], count_frames(file)
    strands = [int(size) for size in file["strands"][()]]
    fields = group["FieldData"]
    axes = [axis for axis in AXES if f"strain_{axis}" in fields]
    times, phases, cycles = (column[:count] for column in (group["Steps/Values"], fields["phase"], fields["cycle"]))
    strains = {axis: fields[f"strain_{axis}"][:count] for axis in axes}
    return FrameIndex(
        nodes=sum(strands),
        edges=sum(strands) - len(strands),
        strands=strands,
        radius=float(file.attrs["fibre_radius"]),
        section={axis: section for axis, section in sections_of(file).items() if axis in axes},
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

    return Response(read_record(here.store.folder(job), shape), media_type="application/octet-stream")
