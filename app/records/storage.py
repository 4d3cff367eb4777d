"""Detection of disk faults, such as a full or read-only disk, among errors of a run."""

from __future__ import annotations

import errno
import os
from typing import Final

FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""No room: of the disk, of the user's share, of what one file may have."""

_FORBIDDEN: Final = (errno.EACCES, errno.EPERM)
_FAULTS: Final = (*FULL, errno.EROFS, errno.EIO, errno.ESTALE)


def fault_of(error: BaseException) -> int | None:
    """Return the error number of a disk fault; None for any other error.

    h5py gives some error numbers only in its text, and raises some of these errors as RuntimeError.
    """
    if not isinstance(error, OSError | RuntimeError):
        return None
    known = (*_FAULTS, *_FORBIDDEN)
    if isinstance(error, OSError) and error.errno is not None:
        return error.errno if error.errno in known else None
    return next((number for number in known if os.strerror(number) in str(error)), None)


def is_unwritable(error: OSError) -> bool:
    """Return whether a file could not be written by any user; missing permission does not count."""
    return error.errno in _FAULTS
