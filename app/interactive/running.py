"""Tests from Python: as the command line runs them, with a progress bar where somebody looks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.interactive.results import Run
from app.runs.use_cases import resume_run, run_protocol
from app.views.drawing import draw_here
from app.views.progress_bar import bar_for

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from app.runs.publishing import Progress
    from app.runs.runner import Watch
    from app.schemas import Source
    from app.schemas.document import Data
    from app.views.drawing import Draw


def run(
    source: Source,
    out: Path | str | None = None,
    progress: Progress | None = None,
    watch: Watch | None = None,
    *,
    exact: bool = False,
    chosen: Mapping[str, Data] | None = None,
    draw: Draw | None = draw_here,
) -> Run:
    """Run a protocol: record, log, plot and pictures in a run folder.

    Parameters
    ----------
    source : Path, str, Mapping, Protocol or Loaded
        Path of the protocol file, its text, data such as a file holds, or the protocol.
    out : Path, str or None
        Run folder to make, under the next free name; None for one under ``runs/``.
    progress : callable, optional
        Told the share done [1] and what is being done; by default a bar, in a terminal or a notebook.
    watch : callable, optional
        Told number, row and strains [1] of every equilibrium.
    exact : bool
        Run in `out` itself, whatever else is in it but a run that can be gone on with.
    chosen : Mapping, optional
        Values for some parameters of the protocol, in the place of its own.
    draw : callable or None
        Begins to draw the plot and the knit; None for no pictures.

    Returns
    -------
    Run
        How it ended, its tables and pictures; a limit, an interrupt and a solver that gave up are outcomes.

    Raises
    ------
    ProtocolError
        For whatever is wrong with the protocol, in one line.
    SpecificationError
        If there is a run in the exact folder.
    """
    with bar_for(wanted=progress is None) as bar:
        done = run_protocol(source, out, progress or bar.show, watch, exact=exact, chosen=chosen, draw=draw)
    return Run.of(done)


def resume(
    folder: Path | str, progress: Progress | None = None, watch: Watch | None = None, *, draw: Draw | None = draw_here
) -> Run:
    """Go on with a run that was killed or interrupted; one that has ended is left as it is.

    Parameters
    ----------
    folder : Path or str
        Its folder.
    progress, watch, draw
        As `run` has them.

    Raises
    ------
    FileNotFoundError, FormatError
        If there is no run, or none that this version can go on with.
    """
    with bar_for(wanted=progress is None) as bar:
        return Run.of(resume_run(folder, progress or bar.show, watch, draw=draw))


def show(folder: Path | str) -> Run:
    """Return a run that was done before, by its folder, with its tables and pictures.

    Raises
    ------
    FileNotFoundError, FormatError
        If there is no run, or it is damaged.
    """
    return Run.at(folder)
