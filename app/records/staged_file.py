"""HDF5 files whose changes are staged in memory and committed to disk, so that a disk fault leaves the file whole.

HDF5 does not survive a write that fails: its file is torn, and the process dies of SIGSEGV when it lets go of it. So it
writes to a `StagedFile`, which never fails, and `commit` brings to the disk what has been written since the last one:
first what makes the file longer, then what changes bytes that are there. Only the first can find a full disk, and is
then taken back; the file on the disk is the one of the last commit.
"""

from __future__ import annotations

import io
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, Self

import h5py

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from types import TracebackType

    Buffer = bytes | bytearray | memoryview

_SPILL: Final = 64 * 2**20
"""Bytes in memory at which a commit is tried before it is asked for."""

_PIECE: Final = 2**20
"""Bytes that are written at once where a file grows."""


class StagedFile:
    """A file object for `h5py.File` whose changes are kept in memory until they are committed.

    Parameters
    ----------
    path : Path
        The file, which must be there.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("r+b", buffering=0)
        self._stored = self._size = self._file.seek(0, io.SEEK_END)  # bytes committed to the disk; bytes in all
        self._position = 0
        self._staged: list[tuple[int, bytes]] = []
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
        try:
            for begin in range(before, self._size, _PIECE):
                self._put(begin, self._at(begin, min(_PIECE, self._size - begin)))
        except OSError:
            self._file.truncate(before)
            raise
        self._stored = self._size
        for offset, piece in self._staged:
            if offset < before:
                self._put(offset, piece[: before - offset])
        self._file.truncate(self._size)
        self._staged.clear()
        self._bytes, self._full = 0, False

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

    def _put(self, offset: int, data: Buffer) -> None:
        """Write bytes to the disk, all of them."""
        view = memoryview(data)
        self._file.seek(offset)
        while view:
            view = view[self._file.write(view) or 0 :]


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
