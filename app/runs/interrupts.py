"""Ctrl-C during a run: raised while the solver works, held back while files are written, and never lost.

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
    """The interrupts of a run: whether one is due, and whether it may be raised now."""

    def __init__(self) -> None:
        self._due = self._open = False

    def note(self, *_: object) -> None:
        """Note an interrupt, as the handler of SIGINT; raise it in a window."""
        self._due = True
        if self._open:
            raise KeyboardInterrupt

    def check(self) -> None:
        """Raise an interrupt that is due, once."""
        if self._due:
            self._due = False
            raise KeyboardInterrupt

    @contextmanager
    def window(self) -> Iterator[None]:
        """Raise an interrupt in this block, as soon as it comes; at its begin or end if one is due."""
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
    """Hold back interrupts; lend windows in which they are raised. What is still due is raised at the end.

    Only where Python's own handler is at work: a thread, a service and whoever ignores SIGINT keep what they have.
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
