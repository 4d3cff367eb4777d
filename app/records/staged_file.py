"""HDF5 files whose changes are staged in memory and committed to disk, so that a disk fault leaves the file whole.

HDF5 does not survive a write that fails: its file is torn, and the process dies of SIGSEGV when it lets go of it. So it
writes to a `StagedFile`, which never fails, and `commit` brings to the disk what has been written since the last one:
first what makes the file longer, with a list of what will change behind it, then what changes bytes that are there.
Only the first can find a full disk, and is then taken back; the file on the disk is the one of the last commit. Where
a change fails (an I/O error, a stale handle, a kill) the list stays behind the file, and who opens it next makes the
changes, or reads the file as if they were made.
"""

from __future__ import annotations

import hashlib
import io
import struct
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final, Self

import h5py

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path
    from types import TracebackType

    Buffer = bytes | bytearray | memoryview

_SPILL: Final = 64 * 2**20
"""Bytes in memory at which a commit is tried before it is asked for."""

_PIECE: Final = 2**20
"""Bytes that are written at once where a file grows."""

_MARK: Final = b"knitlab changes\n"
_DIGEST: Final = 16
_PLACE: Final = struct.Struct("<QQ")
"""Offset and length of a change that is listed behind a file."""

_END: Final = struct.Struct(f"<Q{_DIGEST}s{len(_MARK)}s")
"""End of such a list: its length, its digest, and what tells it from a file without one."""


class StagedFile:
    """A file object for `h5py.File` whose changes are kept in memory until they are committed.

    Parameters
    ----------
    path : Path
        The file, which must be there.
    writing : bool
        Whether it may be changed.
    """

    def __init__(self, path: Path, *, writing: bool = True) -> None:
        self._file = path.open("r+b" if writing else "rb", buffering=0)
        size, left = _left_changes(self._file)
        self._stored = self._size = size  # bytes committed to the disk; bytes in all
        self._position = 0
        self._staged: list[tuple[int, bytes]] = [] if writing else left
        if writing and left:
            for offset, piece in left:
                _put(self._file, offset, piece)
            self._file.truncate(size)
        self._bytes = 0
        self._full = False

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move the position to an offset from the start, from the position or from the end."""
        self._position = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._position, io.SEEK_END: self._size}[whence]
        return self._position

    def tell(self) -> int:
        """Return the position from the start [bytes]."""
        return self._position

    def read(self, size: int) -> bytes:
        """Read bytes from the position, with staged changes; zeros past the end."""
        found = bytes(self._at(self._position, size))
        self._position += size
        return found

    def readinto(self, buffer: Buffer) -> int:
        """Read bytes from the position into a buffer, with staged changes; zeros past the end."""
        view = memoryview(buffer).cast("B")
        view[:] = self._at(self._position, len(view))
        self._position += len(view)
        return len(view)

    def write(self, data: Buffer) -> int:
        """Stage a change of bytes at the position."""
        piece = bytes(data)
        self._staged.append((self._position, piece))
        self._position += len(piece)
        self._size = max(self._size, self._position)
        self._bytes += len(piece)
        if self._bytes > _SPILL and not self._full:
            try:
                self.commit()
            except OSError:  # HDF5 does not survive an error here; the next commit raises it
                self._full = True
        return len(piece)

    def truncate(self, size: int | None = None) -> int:
        """Stage a change of the file's length."""
        self._size = self._position if size is None else size
        self._stored = min(self._stored, self._size)
        kept = [(offset, piece[: self._size - offset]) for offset, piece in self._staged if offset < self._size]
        self._staged = kept
        return self._size

    def flush(self) -> None:
        """Do nothing: HDF5 flushes more often than the file is consistent."""

    def commit(self) -> None:
        """Write all staged changes to the disk.

        Raises
        ------
        OSError
            If that fails. A file that could not grow is as it was after the last commit.
        """
        before = self._stored
        changes = [(offset, piece[: before - offset]) for offset, piece in self._staged if offset < before]
        try:
            for begin in range(before, self._size, _PIECE):
                _put(self._file, begin, self._at(begin, min(_PIECE, self._size - begin)))
        except OSError:
            with suppress(OSError):  # what is longer than HDF5 knows does no harm
                self._file.truncate(before)
            raise
        self._stored = self._size
        self._list(changes)
        for offset, piece in changes:
            _put(self._file, offset, piece)
        self._file.truncate(self._size)
        self._staged.clear()
        self._bytes, self._full = 0, False

    def _list(self, changes: Sequence[tuple[int, bytes]]) -> None:
        """List changes behind the file; without room for that they are made all the same, since they need none."""
        listed = _listed(changes)
        try:
            _put(self._file, self._size, listed)
            self._file.truncate(self._size + len(listed))
        except OSError:
            with suppress(OSError):
                self._file.truncate(self._size)

    def fileno(self) -> int:
        """Return the descriptor of the file on the disk."""
        return self._file.fileno()

    def close(self) -> None:
        """Close the file; changes that were not committed are dropped."""
        self._staged.clear()
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _at(self, offset: int, length: int) -> bytearray:
        """Return bytes with staged changes; zeros where there are none."""
        found = bytearray(length)
        if offset < self._stored:
            self._file.seek(offset)
            held = self._file.read(min(length, self._stored - offset)) or b""
            found[: len(held)] = held
        for begin, piece in self._staged:
            first, last = max(begin, offset), min(begin + len(piece), offset + length)
            if first < last:
                found[first - offset : last - offset] = piece[first - begin : last - begin]
        return found


def _put(file: io.FileIO, offset: int, data: Buffer) -> None:
    """Write bytes to the disk, all of them."""
    view = memoryview(data)
    file.seek(offset)
    while view:
        view = view[file.write(view) or 0 :]


def _listed(changes: Sequence[tuple[int, bytes]]) -> bytes:
    """Return changes as they are kept behind a file: each its place, length and bytes; then length, digest, mark."""
    body = b"".join(part for offset, piece in changes for part in (_PLACE.pack(offset, len(piece)), piece))
    return body + _END.pack(len(body), hashlib.blake2b(body, digest_size=_DIGEST).digest(), _MARK) if changes else b""


def _left_changes(file: io.FileIO) -> tuple[int, list[tuple[int, bytes]]]:
    """Return the length of a file without the list behind it, and the changes listed; none without a whole list."""
    size = file.seek(0, io.SEEK_END)
    if size < _END.size:
        return size, []
    file.seek(size - _END.size)
    length, digest, mark = _END.unpack(file.read(_END.size))
    begin = size - _END.size - length
    if mark != _MARK or begin < 0:
        return size, []
    file.seek(begin)
    body = file.read(length)
    if hashlib.blake2b(body, digest_size=_DIGEST).digest() != digest:
        return size, []
    changes, place = [], 0
    while place < length:
        offset, count = _PLACE.unpack_from(body, place)
        place += _PLACE.size + count
        changes.append((offset, body[place - count : place]))
    return begin, changes


def is_between(path: Path) -> bool:
    """Tell whether changes are listed behind a file: it is being written, or its writer was cut off."""
    with path.open("rb", buffering=0) as file:
        return bool(_left_changes(file)[1])


@contextmanager
def new_hdf5(path: Path) -> Iterator[h5py.File]:
    """Create an HDF5 file in the place of an empty file, as a context manager; it is written at the end.

    Raises
    ------
    OSError
        If it finds no room.
    """
    with StagedFile(path) as staged:
        with h5py.File(staged, "w", libver="earliest") as file:
            yield file
        staged.commit()
