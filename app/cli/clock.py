"""Start of this process on the clock of `perf_counter`, from which the duration of a command counts."""

from __future__ import annotations

import os
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Final


def _age() -> float:
    """Return the age of this process [s]; where it is not known, the CPU time that it used."""
    used = time.process_time()
    if sys.platform == "linux":
        with suppress(OSError, ValueError, IndexError):  # no /proc
            started = int(Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[19])
            return max(used, time.clock_gettime(time.CLOCK_BOOTTIME) - started / os.sysconf("SC_CLK_TCK"))
    return used


BEGAN: Final = time.perf_counter() - _age()
"""Time at which the process began [s]."""
