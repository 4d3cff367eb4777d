"""Checksums of the rows of ``run.h5``, which show damage by power cuts and bad disks.

HDF5's own checksums are of chunks of thousands of rows, and a kill in the middle of one would cost all of them.
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    import numpy.typing as npt

    from rigs.axes import FloatArray

CHECKSUM: Final = "checksum"
"""Column of the equilibria that holds the CRC-32 of each row."""

_UNCHECKED: Final = frozenset({CHECKSUM, "tag", "seconds"})
"""Columns that do not count: the number of a tag, whose text does, and wall time, which is another in every run."""


def checked(names: Iterable[str]) -> tuple[str, ...]:
    """Return the columns that enter the checksum, in order."""
    return tuple(sorted(set(names) - _UNCHECKED))


def row_checksum(numbers: FloatArray, tag: str | None) -> int:
    """Return the CRC-32 of a row: its numbers as 64-bit floats, low byte first, then its tag as UTF-8."""
    return zlib.crc32(b"" if tag is None else tag.encode(), zlib.crc32(numbers.astype("<f8").tobytes()))


def good_rows(columns: Mapping[str, FloatArray], tags: Sequence[str | None]) -> npt.NDArray[np.bool_]:
    """Return which rows match their checksums, (n,) bool; all rows if the record has no checksums."""
    if CHECKSUM not in columns:
        return np.ones(len(tags), dtype=bool)
    table = np.column_stack([columns[name][: len(tags)] for name in checked(columns)]).astype("<f8")
    found = [row_checksum(numbers, tag) for numbers, tag in zip(table, tags, strict=True)]
    return np.equal(np.array(found, dtype=np.uint32), columns[CHECKSUM][: len(tags)])
