"""Drawing of a run's pictures, in this process or in one that starts early and imports during the test."""

from __future__ import annotations

import json
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

from app import beside

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Callable, Iterator
    from types import TracebackType
    from typing import Self

    from app.records.reader import RunReader

    Draw = Callable[[RunReader, str], Callable[[], None]]

DRAWN: Final = b"drawn\n"
"""Reply of a process that has drawn."""

IDLE_SECONDS: Final = 120.0
"""Time that a process which is ready to draw waits for a record [s]; it does not hold memory through a long test."""


def draw_pictures(run: RunReader, name: str) -> None:
    """Draw the plot and the knit of a record that has rows, into its folder.

    Parameters
    ----------
    run : RunReader
        The record.
    name : str
        What the names of the files begin with.
    """
    from app.views.plots import stress_strain_plot  # noqa: PLC0415
    from app.views.renders import knit_frames  # noqa: PLC0415 (matplotlib: only where something is drawn)

    stress_strain_plot(run, run.path.with_name(f"{name}_stress_strain.png"))
    knit_frames(run, run.path.with_name(f"{name}_knit.png"))


def draw_here(run: RunReader, name: str) -> Callable[[], None]:
    """Return a function that draws in this process, as `draw_pictures` does."""
    return lambda: draw_pictures(run, name)


class Drawer:
    """A process that draws the pictures of one run; if it fails or has ended, this process draws.

    It starts at once, so that it imports while the test goes on. It ends when it has drawn, when nothing came to
    draw for `IDLE_SECONDS`, and when this process ends, however that comes about: then its input ends.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = beside.start("app.views.drawing_process")

    def __call__(self, run: RunReader, name: str) -> Callable[[], None]:
        """Begin to draw; return a function that waits for the end of it."""
        asked = json.dumps([str(run.path.absolute()), name]).encode() + b"\n"
        if self._process is not None and self._process.stdin is not None:
            with suppress(OSError):  # the process has ended: the answer will be empty
                self._process.stdin.write(asked)
                self._process.stdin.flush()

        def wait() -> None:
            if self._answer() != DRAWN:
                draw_pictures(run, name)

        return wait

    def _answer(self) -> bytes:
        """Return the line that the process writes when it has drawn; empty if it ends without."""
        process = self._process
        answer = b"" if process is None or process.stdout is None else process.stdout.readline()
        self.close()
        return answer

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            beside.end(process)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


@contextmanager
def drawer(*, wanted: bool) -> Iterator[Draw | None]:
    """Yield a process that draws while the block runs; None if no pictures are wanted."""
    if not wanted:
        yield None
        return
    with Drawer() as process:
        yield process
