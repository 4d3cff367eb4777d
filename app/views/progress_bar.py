"""Progress bar of long work, in a terminal or a notebook."""

from __future__ import annotations

import html
import sys
from time import perf_counter
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self


class Bar:
    """Progress bar of a run, on stderr.

    Parameters
    ----------
    hidden : bool
        Show nothing.
    began : float, optional
        When what is shown began, on the clock of `perf_counter` [s]; by itself now.
    """

    def __init__(self, *, hidden: bool, began: float | None = None) -> None:
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            disable=hidden,
        )
        self._task = self._progress.add_task("starting", total=1.0)
        if began is not None:
            self._progress.tasks[0].start_time = self._progress.get_time() - (perf_counter() - began)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def show(self, fraction: float, message: str) -> None:
        """Show the fraction done [1] and what is being done."""
        self._progress.update(self._task, completed=fraction, description=message)


class NotebookBar:
    """The same in a notebook: part of a cell's output, replaced at every report."""

    def __init__(self) -> None:
        self._handle: Any = None
        self._began = perf_counter()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._handle is not None and kind is None:
            self._write(f"<small>done in {perf_counter() - self._began:.1f} s</small>")

    def show(self, fraction: float, message: str) -> None:
        """Show the fraction done [1] and what is being done."""
        so_far = f"{100.0 * fraction:.0f} %, {perf_counter() - self._began:.0f} s: {html.escape(message)}"
        self._write(f"<progress value='{fraction:.3f}'></progress> {so_far}")

    def _write(self, text: str) -> None:
        from IPython.display import HTML, display  # noqa: PLC0415 (a notebook has it)

        shown = HTML(text)  # type: ignore[no-untyped-call]
        if self._handle is None:
            self._handle = display(shown, display_id=True)  # type: ignore[no-untyped-call]
        else:
            self._handle.update(shown)


def bar_for(*, wanted: bool) -> Bar | NotebookBar:
    """Return a bar for whoever looks: in a notebook, in a terminal, or one that shows nothing."""
    if wanted and "ipykernel" in sys.modules:
        return NotebookBar()
    return Bar(hidden=not wanted or not sys.stderr.isatty())
