"""Answer what is asked of a job's files, and of its log in any dialect."""

import mimetypes
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from fastapi import Path as PathParameter
from fastapi.responses import Response

from app.export import LOGS, export_log
from app.run_reader import RunReader
from app.service.api.context import Here
from app.service.api.models import FileList, FileView, JobId, problems
from app.service.api.problems import ProblemError
from app.service.api.transfer import transfer
from knitlab_core.errors import FormatError, SpecificationError

router = APIRouter(prefix="/v1/jobs/{job}", tags=["files"])

_HIDDEN = frozenset({"lock", "spec.json", "checkpoint.h5"})
_KINDS: dict[str, Literal["record", "log", "picture", "text"]] = {
    ".h5": "record",
    ".vtkhdf": "record",
    ".csv": "log",
    ".xlsx": "log",
    ".txt": "log",
    ".png": "picture",
    ".tif": "picture",
}
# A browser shows these at once; anything else it only saves, so that nothing runs as a page of this service.
_SHOWN = {".csv": "text/csv", ".txt": "text/plain", ".log": "text/plain", ".yaml": "text/plain", ".png": "image/png"}
_BYTES = {"schema": {"type": "string", "format": "binary"}}


def _files(folder: Path) -> dict[str, Path]:
    """Return the files that a job shows, by their path within it: no link, nothing hidden, nothing of the service."""
    found = {}
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        hidden = any(part.startswith(".") for part in parts) or parts[-1] in _HIDDEN
        if not hidden and path.is_file() and not path.is_symlink():
            found["/".join(parts)] = path
    return found


@router.get("/files", summary="List the files of a job", responses=problems(404, 422))
def files(job: JobId, here: Here) -> FileList:
    """Return path, size and kind of every file, also of a job that is going on."""
    listed = []
    for name, path in _files(here.store.folder(job)).items():
        listed.append(FileView(name=name, size=path.stat().st_size, kind=_KINDS.get(path.suffix, "text")))
    return FileList(files=listed)


@router.get(
    "/files/{name:path}",
    summary="Fetch a file of a job",
    response_class=Response,
    responses={
        200: {"description": "The file", "content": {"application/octet-stream": _BYTES}},
        206: {"description": "The ranges asked for", "content": {"application/octet-stream": _BYTES}},
        **problems(404, 416, 422),
    },
)
def file(
    job: JobId,
    name: Annotated[str, PathParameter(max_length=1000, examples=["run/biaxial_small.csv"])],
    here: Here,
    request: Request,
) -> Response:
    """Return a file, whole or the ranges that `Range` asks for."""
    # Looked up among the files that are there: a path that leads elsewhere is none of them.
    path = _files(here.store.folder(job)).get(name)
    if path is None:
        raise ProblemError("unknown", "name: found none of the files of this job; GET .../files lists them")
    return transfer(request, path.open("rb"), path.name, _SHOWN.get(path.suffix, "application/octet-stream"))


@router.get(
    "/log",
    summary="Fetch the log of a job in a dialect",
    response_class=Response,
    responses={
        200: {"description": "The log", "content": {"text/csv": {"schema": {"type": "string"}}}},
        **problems(404, 409, 422),
    },
)
def log(
    job: JobId,
    here: Here,
    request: Request,
    dialect: Annotated[str | None, Query(max_length=64, description="Nothing is the machine's own.")] = None,
) -> Response:
    """Return the log in the dialect of an instrument, made anew from the record."""
    if dialect is not None and dialect not in LOGS:
        detail = f"dialect: found none of that name, allowed {', '.join(LOGS)}"
        raise ProblemError("invalid-request", detail, errors=[{"parameter": "dialect", "detail": detail}])
    try:
        run = RunReader(here.store.folder(job) / "run" / "run.h5")
    except (FileNotFoundError, FormatError) as error:
        raise ProblemError("not-ready", "log: found no record yet, allowed when the test has been run") from error
    with TemporaryDirectory(prefix="knitlab-log-") as folder:
        path = _exported(run, Path(folder), dialect)
        media = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
        # The open file outlives its folder, and goes with the answer.
        return transfer(request, path.open("rb"), path.name, media)


def _exported(run: RunReader, folder: Path, dialect: str | None) -> Path:
    """Write the log of a run.

    Raises
    ------
    ProblemError
        If it was not sampled yet, or not by this dialect's machine.
    """
    name = dialect or next((name for name, log in LOGS.items() if log.machine in run.samples), next(iter(LOGS)))
    sample = str(run.provenance.get("name", "test"))
    try:
        return export_log(run, folder / Path(LOGS[name].place.format(sample=sample)).name, name)
    except SpecificationError as error:
        detail = f"log: found samples of {', '.join(run.samples) or 'nothing'}, allowed those of {LOGS[name].machine}"
        raise ProblemError("not-ready", detail) from error
