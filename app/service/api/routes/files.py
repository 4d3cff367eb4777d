"""Routes of a job's files, and of its log in any dialect."""

import mimetypes
import os
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from fastapi import Path as PathParameter
from fastapi.responses import Response

from app.records.export import export_log
from app.records.lock import LOCK
from app.records.reader import RunReader
from app.schemas import loads
from app.service.api.context import Here
from app.service.api.models import FileList, FileView, JobId, problems
from app.service.api.problems import ProblemError
from app.service.api.transfer import transfer
from app.service.jobs import JobSpec
from knitlab_core.errors import FormatError, SpecificationError
from rigs.logs.catalogue import LOGS, defaults
from rigs.protocol.catalogue import CATALOGUE

router = APIRouter(prefix="/v1/jobs/{job}", tags=["files"])

_HIDDEN = frozenset({"lock", "spec.json", "checkpoint.h5", LOCK})
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
    """Return the visible files of a job by their path within it: no links, nothing hidden, none of the service.

    A job that runs makes and removes files all the while; a folder that has gone is passed over.
    """
    found = {}
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(one for one in folders if not one.startswith("."))
        for path in (Path(place, name) for name in sorted(names)):
            hidden = path.name.startswith(".") or path.name in _HIDDEN
            if not hidden and path.is_file() and not path.is_symlink():
                found[path.relative_to(folder).as_posix()] = path
    return found


@router.get("/files", summary="List the files of a job", responses=problems(404, 422))
def files(job: JobId, here: Here) -> FileList:
    """Return path, size and kind of every file, also of a job that is going on."""
    listed = []
    for name, path in _files(here.store.folder(job)).items():
        with suppress(FileNotFoundError):
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
    """Return a file, whole or the ranges of `Range`."""
    # Looked up among the listed files, so that no path can lead outside the folder.
    path = _files(here.store.folder(job)).get(name)
    try:
        stream = None if path is None else path.open("rb")
    except FileNotFoundError:
        stream = None
    if path is None or stream is None:
        raise ProblemError("unknown", "name: found none of the files of this job; GET .../files lists them")
    return transfer(request, stream, path.name, _SHOWN.get(path.suffix, "application/octet-stream"))


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
    locale: Annotated[Literal["en", "de", "fr"], Query(description="Marks of numbers and dates.")] = "en",
) -> Response:
    """Return the log in the dialect of an instrument, computed from the record."""
    if dialect is not None and dialect not in LOGS:
        detail = f"dialect: found none of that name, allowed {', '.join(LOGS)}"
        raise ProblemError("invalid-request", detail, errors=[{"parameter": "dialect", "detail": detail}])
    if dialect is not None:
        _require_machines(here.store.spec(job), dialect)
    try:
        run = RunReader(here.store.folder(job) / "run" / "run.h5")
    except (FileNotFoundError, FormatError) as error:
        raise ProblemError("not-ready", "log: found no record yet, allowed when the test has been run") from error
    with TemporaryDirectory(prefix="knitlab-log-") as folder:
        path = _exported(run, Path(folder), dialect, locale)
        media = mimetypes.guess_type(path.name)[0] or "application/octet-stream"
        # The open file is read to its end even if its folder is deleted.
        return transfer(request, path.open("rb"), path.name, media)


def _require_machines(spec: JobSpec, dialect: str) -> None:
    """Refuse a dialect that the log of a job cannot have.

    Raises
    ------
    ProblemError
        With those that its machines' logs may have.
    """
    rig = loads(spec.protocol, name=spec.name, materials=spec.materials).protocol.rig
    machines = {drive.machine for drive in CATALOGUE[rig].drives.values()}
    allowed = [name for name, log in LOGS.items() if set(log.machines) <= machines]
    if dialect not in allowed:
        detail = f"dialect: found {dialect}, allowed on {rig}: {', '.join(allowed)}"
        raise ProblemError("invalid-request", detail, errors=[{"parameter": "dialect", "detail": detail}])


def _exported(run: RunReader, folder: Path, dialect: str | None, locale: str) -> Path:
    """Write the log of a run.

    Raises
    ------
    ProblemError
        If it was not sampled yet.
    """
    name = dialect or next(iter([*defaults(run.logs), *LOGS]))
    try:
        return export_log(run, folder, name, locale=locale)
    except SpecificationError as error:
        raise ProblemError("not-ready", "log: found no samples, allowed when the test has been run") from error
