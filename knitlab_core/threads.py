"""Two pieces of work at once, in threads: kernels release the interpreter's lock.

Which piece does what never depends on the number of threads, so results have the same bits with one and with two.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TYPE_CHECKING, Final, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

FirstT = TypeVar("FirstT")
SecondT = TypeVar("SecondT")

VARIABLE: Final = "KNITLAB_THREADS"
"""Environment variable with the number of threads; more than two are as two."""


class _Threads:
    """The number of threads of this process and the one beside the caller's own."""

    count: int | None = None
    pool: ThreadPoolExecutor | None = None


def wanted_threads(environment: Mapping[str, str], processors: int | None) -> int:
    """Return the number of threads to use, 1 or 2.

    Parameters
    ----------
    environment : Mapping[str, str]
        Environment variables; what is no whole number counts as not given.
    processors : int or None
        Processors of the machine, None if unknown.

    Examples
    --------
    >>> wanted_threads({}, 64), wanted_threads({"KNITLAB_THREADS": "1"}, 64)
    (2, 1)
    """
    given = environment.get(VARIABLE, "").strip()
    count = int(given) if given.isdecimal() else (processors or 1)
    return min(max(count, 1), 2)


def thread_count() -> int:
    """Return the number of threads this process uses."""
    if _Threads.count is None:
        _Threads.count = wanted_threads(os.environ, os.cpu_count())
    return _Threads.count


def use_threads(count: int) -> None:
    """Use so many threads from now on, whatever the environment has."""
    _Threads.count = min(max(count, 1), 2)


def both(first: Callable[[], FirstT], second: Callable[[], SecondT]) -> tuple[FirstT, SecondT]:
    """Call two functions that touch nothing in common, at once if there are two threads; return what they return.

    Where the other thread has not begun when the first function ends, as on a busy machine, nobody waits for it.
    """
    if thread_count() == 1:
        return first(), second()
    if _Threads.pool is None:
        _Threads.pool = ThreadPoolExecutor(1, thread_name_prefix="knitlab")
    beside = _Threads.pool.submit(second)
    try:
        done = first()
    except BaseException:
        wait([beside])
        raise
    return done, second() if beside.cancel() else beside.result()


def _forget_pool() -> None:
    """Drop a thread that a forked process does not have."""
    _Threads.pool = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_pool)
