"""Ctrl-C during a run: raised while the solver works, delayed while files are written, and never lost.

HDF5 calls back into Python to write a record; an exception there is printed and leaves the file torn. An exception in
a finaliser, where the solver may be, is swallowed by Python. So the handler notes every interrupt, and raises
`KeyboardInterrupt` itself only in a window.
"""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager


class Interrupts:
    """Interrupts of a run: whether one is pending, and whether it may be raised now."""

    def __init__(self) -> None:
        self._due = self._open = False

    def note(self, *_: object) -> None:
        """Record an interrupt, as the handler of SIGINT; raise it inside a window."""
        self._due = True
        if self._open:
            raise KeyboardInterrupt

    def check(self) -> None:
        """Raise a pending interrupt, once."""
        if self._due:
            self._due = False
            raise KeyboardInterrupt

    @contextmanager
    def window(self) -> Iterator[None]:
        """Allow interrupts in this block; one that is pending is raised at its begin or end."""
        self.check()
        self._open = True
        try:
            yield
        except KeyboardInterrupt:
            self._due = False
            raise
        finally:
            self._open = False
        self.check()


@contextmanager
def interrupts_held() -> Iterator[Callable[[], AbstractContextManager[None]]]:
    """Delay interrupts; yield windows in which they are raised. A pending one is raised at the end.

    Handlers other than Python's own stay, as in a service or where SIGINT is ignored; so do threads.
    """
    interrupts = Interrupts()
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield interrupts.window
        return
    signal.signal(signal.SIGINT, interrupts.note)
    try:
        yield interrupts.window
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    interrupts.check()
