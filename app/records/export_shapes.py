"""The shapes of a run under a name that visualisation programs open by themselves."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING, Literal, TypeAlias

from app.file_names import file_stem
from app.records.folder import whole_file
from app.records.reader import read_run
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from pathlib import Path

Kind: TypeAlias = Literal["link", "copy"]


def export_shapes(place: Path, kind: Kind, out: Path | None = None) -> Path:
    """Write the record of a run as ``NAME.vtkhdf``, which ParaView and `pyvista.read` open by its name.

    Parameters
    ----------
    place : Path
        Folder of the run, or its ``run.h5``.
    kind : 'link' or 'copy'
        Another name of the same file (a hard link, which takes no room), or a copy of its own.
    out : Path or None
        Folder of the file; None for beside the record.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    FileNotFoundError, FormatError
        If there is no record of a run.
    SpecificationError
        If it has no shapes, or its file system has no links.
    """
    run = read_run(place)
    if not run.frames():
        raise SpecificationError("run.shapes", "none", "a run with a shape or more")
    folder = run.path.parent if out is None else out
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{file_stem(str(run.provenance.get('name', 'knitlab')))}.vtkhdf"
    if kind == "copy":
        with whole_file(path) as temporary:
            shutil.copyfile(run.path, temporary)
        return path
    path.unlink(missing_ok=True)
    try:
        path.hardlink_to(run.path)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise SpecificationError(
            "shapes", f"link, {reason}", f"copy, or a folder on the file system of {run.path}"
        ) from error
    return path
