"""Seals of complete files: a digest of all bytes after the last one, which HDF5 ignores.

A program that opens a sealed HDF5 file to change it cuts the seal off as it closes the file. So what does not match a
seal was damaged, and what has none is still being written, was cut off or was changed on purpose.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import FormatError

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

_MARK: Final = b"\nKNITSEAL"
_DIGEST_BYTES: Final = 16
SIZE: Final = len(_MARK) + _DIGEST_BYTES
"""Bytes of a seal."""

_PIECE: Final = 2**20


def seal_of(pieces: Iterable[bytes | memoryview]) -> bytes:
    """Return the seal for the bytes of a file."""
    digest = hashlib.blake2b(digest_size=_DIGEST_BYTES)
    for piece in pieces:
        digest.update(piece)
    return _MARK + digest.digest()


def pieces_of(path: Path, size: int) -> Iterable[bytes]:
    """Yield the first bytes of a file, piece by piece."""
    with path.open("rb") as file:
        while size > 0 and (piece := file.read(min(_PIECE, size))):
            size -= len(piece)
            yield piece


def seal(path: Path) -> None:
    """Seal a file that has no seal; without room on the disk the file stays as it was."""
    size = path.stat().st_size
    mark = seal_of(pieces_of(path, size))
    with path.open("ab", buffering=0) as file:
        try:
            while mark:  # a disk that has room for a part of it fails at the next write
                mark = mark[file.write(mark) or 0 :]
        except OSError:
            file.truncate(size)
            raise


def sealed_size(path: Path) -> int | None:
    """Return the length of a file without its seal [bytes]; None if it has none."""
    size = path.stat().st_size - SIZE
    if size < 0:
        return None
    with path.open("rb") as file:
        file.seek(size)
        return size if file.read(len(_MARK)) == _MARK else None


def require_intact(path: Path, what: str) -> None:
    """Raise if a sealed file was changed after it was sealed.

    Raises
    ------
    FormatError
        Naming `what` was expected.
    """
    size = sealed_size(path)
    if size is None:
        return
    with path.open("rb") as file:
        file.seek(size)
        found = file.read()
    if found != seal_of(pieces_of(path, size)):
        raise FormatError(path, 1, f"{what}, undamaged: its checksum does not match")
