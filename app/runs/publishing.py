"""Views of a recorded test (logs, plot, pictures, microscope images), and how it ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.file_names import file_stem
from app.records.export import export_logs
from app.runs.journal import TESTED

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from app.records.reader import RunReader
    from app.records.results import Figure
    from app.views.drawing import Draw
    from rigs.analysis.clasps import ClaspLoss
    from rigs.analysis.material_limits import LimitCrossing
    from rigs.record import End, Outcome
    from rigs.step_record import StepRecord

    Progress = Callable[[float, str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class RunResult:
    """How a run ended, and its figures.

    Attributes
    ----------
    outcome : End
        How it ended.
    message : str
        One line for the user; empty when there is nothing to add.
    folder : Path
        The run folder.
    figures : tuple of (name, value, unit)
        Empty if nothing was measured.
    steps : tuple of StepRecord
        How each step ended that was begun.
    crossings : tuple of LimitCrossing
        Where a fibre passed a limit of its material.
    losses : tuple of ClaspLoss
        Where clasps let go.
    """

    outcome: End
    message: str
    folder: Path
    figures: tuple[Figure, ...]
    steps: tuple[StepRecord, ...] = ()
    crossings: tuple[LimitCrossing, ...] = ()
    losses: tuple[ClaspLoss, ...] = ()


def publish(run: RunReader, name: str, progress: Progress, *, draw: Draw | None) -> None:
    """Write the views of a record that has rows: logs, plot, pictures."""
    if not len(run.trace):
        return
    folder = run.path.parent
    drawn = None if draw is None else draw(run, file_stem(name))
    progress(TESTED, "writing the log")
    export_logs(run, folder)
    images_of(run, folder, name, progress)
    if drawn is not None:
        progress(TESTED, "drawing the curves and the knit")
        drawn()
    progress(1.0, "done")


def images_of(run: RunReader, folder: Path, name: str, progress: Callable[[float, str], None]) -> tuple[Path, ...]:
    """Render the microscope images that the protocol took, if any, into the run's folder."""
    if not any(frame.image is not None for frame in run.frames()):
        return ()
    from app.views.sem.images import IMAGES, usual_look, write_images  # noqa: PLC0415 (its kernels only when they are needed)

    return write_images(run, folder / IMAGES, file_stem(name), usual_look(run), progress)


def result_of(outcome: Outcome, figures: tuple[Figure, ...], record: RunReader) -> RunResult:
    """Return how a recorded test ended."""
    return RunResult(
        outcome=outcome.end,
        message=outcome.message,
        folder=record.path.parent,
        figures=figures,
        steps=record.steps,
        crossings=record.crossings,
        losses=record.losses,
    )
