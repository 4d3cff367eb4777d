"""Compile a share of the kernels in a second process, while a first run compiles the others.

``python -m app.runs.compile_ahead`` is that process. What it compiles reaches the first process through the kernel
cache on disk.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from app import beside
from knitlab_core.jit import CACHE_FOLDER, cache_is_cold
from knitlab_core.threads import thread_count

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def compiling_beside() -> Iterator[None]:
    """Compile in a second process too while the block runs, if kernels are missing and that can help.

    It cannot help with one processor or thread, nor without a cache on disk.
    """
    wanted = CACHE_FOLDER is not None and thread_count() > 1 and cache_is_cold()
    process = beside.start("app.runs.compile_ahead") if wanted else None
    try:
        yield
    finally:
        if process is not None:
            beside.end(process)


def main() -> None:
    """Compile kernels until this process is ended."""
    beside.listen()
    from knitlab_core.equilibrium.first_calls import call_search  # noqa: PLC0415 (so that the end is seen from now on)

    call_search()


if __name__ == "__main__":
    main()
