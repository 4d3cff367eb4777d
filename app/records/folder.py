"""Run folders that never overwrite another run, and files that are written atomically."""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


RECORD: Final = "run.h5"
"""Name of a run's record in its folder."""

_UNFINISHED: Final = ".unfinished-"


def make_run_folder(wanted: Path) -> Path:
    """Create a folder for a run, under the next free name if the wanted one is in use.

    Parameters
    ----------
    wanted : Path
        ``runs/biaxial``; an empty folder of that name counts as free.

    Returns
    -------
    Path
        The folder: ``runs/biaxial``, else ``runs/biaxial-2`` and so on.
    """
    wanted.parent.mkdir(parents=True, exist_ok=True)
    folder, number = wanted, 1
    while True:
        try:
            folder.mkdir()
        except FileExistsError:
            if folder.is_dir() and not any(folder.iterdir()):
                return folder
            number += 1
            folder = wanted.with_name(f"{wanted.name}-{number}")
        else:
            return folder


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path; the file gets its real name when the block succeeds.

    Parameters
    ----------
    path : Path
        Path of the file. A file that is there stays until the new one is complete.

    Yields
    ------
    Path
        Temporary name in the same folder, with the same suffix.

    Raises
    ------
    OSError
        If the file cannot be written; it names the file by its real name.
    """
    try:
        with _temporary_file(path) as temporary:
            yield temporary
    except OSError as error:
        if error.filename is None or Path(os.fsdecode(error.filename)).name.startswith(_UNFINISHED):
            error.filename = str(path)
        raise


@contextmanager
def _temporary_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path in a folder; the file gets its real name when the block succeeds."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f"{_UNFINISHED}{path.stem}-", suffix=path.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        with temporary.open("r+b") as written:  # Windows syncs what may be written to
            os.fsync(written.fileno())
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def remove_unfinished(folder: Path) -> None:
    """Remove temporary files of a killed process; to be called while no process writes to the folder."""
    for path in folder.rglob(f"{_UNFINISHED}*"):
        path.unlink()


def write_whole(path: Path, chunks: Iterable[bytes]) -> Path:
    """Write a file from chunks, atomically.

    Parameters
    ----------
    path : Path
        Path of the file.
    chunks : iterable of bytes
        Its content.

    Returns
    -------
    Path
        The same path.
    """
    with whole_file(path) as temporary, temporary.open("wb") as stream:
        stream.writelines(chunks)
    return path


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
