"""Run of one folder's test, from its start or from a checkpoint, to its logs, plots and pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING

from app.checks.dry_run import build_specimen, fitted_machines
from app.records.checkpoint import CHECKPOINT, Keeper, Origin
from app.records.folder import RECORD
from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.results import PITCH, pitch_of, run_figures, with_wall_time
from app.records.seal import seal, sealed_size
from app.records.writer import RunWriter
from app.runs.interrupts import interrupts_held
from app.runs.journal import Journal
from app.runs.provenance import provenance
from app.runs.publishing import publish, result_of
from app.schemas.defaults import shown_defaults
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import clasp_nodes, clasps_hold
from rigs.analysis.clasps import lost_as_mounted
from rigs.analysis.material_limits import limits_of, unused_yield
from rigs.control.checkpoint import restore
from rigs.control.experiment import perform
from rigs.control.log_rate import stretches_of
from rigs.control.plan import planned_duration
from rigs.instruments.channels import measured_parts
from rigs.machines.mounting import mount
from rigs.machines.shape import wire_ends

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from contextlib import AbstractContextManager
    from pathlib import Path

    from app.records.checkpoint import Saved
    from app.records.results import Figure
    from app.runs.publishing import Progress, RunResult
    from app.schemas import Loaded
    from app.views.drawing import Draw
    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis, IntArray
    from rigs.control.experiment import Event
    from rigs.machines.rig import Rig
    from rigs.record import Equilibrium, Outcome
    from rigs.trace import Trace

    Watch = Callable[[int, Equilibrium, Mapping[Axis, float]], None]


def quiet(_share: float, _text: str) -> None:
    """Show no progress."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A test to run: its protocol, its folder, and who is told of its progress.

    Attributes
    ----------
    loaded : Loaded
        Its protocol.
    folder : Path
        Its folder.
    origin : Origin
        What it is of.
    began : float
        When it began, on the clock of `perf_counter`, earlier sessions counted in [s].
    progress : callable
        Told the share done [1] and what is being done.
    watch : callable or None
        Told number, row and strains [1] of every equilibrium.
    draw : callable or None
        Begins to draw the plot and the knit; None for no pictures.
    """

    loaded: Loaded
    folder: Path
    origin: Origin
    began: float
    progress: Progress
    watch: Watch | None
    draw: Draw | None

    @property
    def record(self) -> Path:
        """Return the file of the record."""
        return self.folder / RECORD

    @property
    def checkpoint(self) -> Path:
        """Return the file of the checkpoint."""
        return self.folder / CHECKPOINT


def make_task(
    loaded: Loaded, folder: Path, began: float, progress: Progress, watch: Watch | None, *, draw: Draw | None
) -> Task:
    """Assemble a task with the identity of its run."""
    origin = Origin(
        name=loaded.protocol.name,
        protocol=loaded.text,
        materials=loaded.materials,
        facts=provenance(loaded.protocol, fitted_machines(loaded)),
    )
    return Task(
        loaded=loaded,
        folder=folder,
        origin=origin,
        began=began,
        progress=progress,
        watch=watch,
        draw=draw,
    )


def mount_specimen(loaded: Loaded) -> tuple[Rig, State]:
    """Mount the specimen of a protocol."""
    return mount(build_specimen(loaded), loaded.protocol, fitted_machines(loaded))


def run_from_start(task: Task, rig: Rig, state: State) -> RunResult:
    """Run a test from its start and write its record, ``run.h5``."""
    begin_record(task, rig, state)
    with interrupts_held() as window, RunWriter(task.record) as writer:
        journal = journal_of(task, rig, writer, window)
        outcome, figures = _tested(task, rig, journal, perform(rig, state, task.loaded.protocol))
    return published(task, journal, outcome, figures)


def begin_record(task: Task, rig: Rig, state: State) -> None:
    """Create the record of a test, without rows, in the place of an older one."""
    protocol, clasps = task.loaded.protocol, clasp_nodes(rig.specimen)
    make_record(
        task.record,
        protocol=task.loaded.text,
        size=rig.size,
        axes=protocol.axes,
        strands=rig.strands,
        instruments=rig.instruments,
        provenance={
            **task.origin.facts,
            "defaults": shown_defaults(task.loaded.defaults),
            **{f"{PITCH}{axis}": pitch for axis, pitch in rig.relaxed_pitch.items()},
            "started": datetime.now().astimezone().isoformat(timespec="seconds"),
        },
        materials=task.loaded.materials,
        plates=_plates(rig),
        wires=len(wire_ends(rig, state)),
        limits=limits_of(protocol.specimen),
        clasps=clasps,
        cell=rig.cell_columns,
        fixtures=rig.fixture_forces,
        pins=rig.pins,
        let_go=lost_as_mounted(*(clasps_hold(x, clasps) for x in (rig.specimen.nodes, state.q[:, :3]))),
    )
    # An older checkpoint does not belong to the new record.
    task.checkpoint.unlink(missing_ok=True)


def _plates(rig: Rig) -> tuple[IntArray, IntArray] | None:
    """Return the nodes in the lower and in the upper load plate; None on a rig without plates."""
    lower, upper = rig.grips.get("P", (None, None))
    if lower is None or upper is None or not lower.rigid:
        return None
    return lower.nodes, upper.nodes


def resume(task: Task, saved: Saved, before: Trace) -> RunResult:
    """Resume a test from a checkpoint; its rows before are those of the record, up to the checkpoint."""
    protocol, checkpoint = task.loaded.protocol, saved.checkpoint
    laid, _ = mount(build_specimen(task.loaded), protocol, fitted_machines(task.loaded), relaxed=False)
    rig = restore(laid, checkpoint)
    task = replace(task, began=task.began - saved.seconds)
    with interrupts_held() as window, RunWriter(task.record, saved.lengths) as writer:
        journal = journal_of(task, rig, writer, window)
        journal.before = before.first(writer.rows)
        journal.zeroings.extend(saved.zeroings)
        events = perform(rig, checkpoint.state, protocol, cursor=checkpoint.cursor)
        outcome, figures = _tested(task, rig, journal, events)
    return published(task, journal, outcome, figures)


def reopen(record: RunReader, saved: Saved | None, progress: Progress, *, draw: Draw | None) -> RunResult:
    """Return how an ended run ended; write its log and pictures if it was killed before they were complete."""
    outcome = record.outcome
    figures: tuple[Figure, ...] = ()
    if saved is not None:
        if sealed_size(record.path) is None:  # the disk was full
            seal(record.path)
        figures = run_figures(
            record.trace,
            record.size,
            saved.zeroings,
            saved.seconds,
            protocol=record.test,
            unfinished=record.outcome.unfinished,
            pitch=pitch_of(record),
        )
        publish(record, saved.origin.name, progress, draw=draw)
        record.path.with_name(CHECKPOINT).unlink()
    return result_of(outcome, figures, record)


def journal_of(task: Task, rig: Rig, writer: RunWriter, window: Callable[[], AbstractContextManager[None]]) -> Journal:
    """Return the recorder of a test that begins."""
    return Journal(
        writer=writer,
        keeper=Keeper(path=task.checkpoint, origin=task.origin, began=task.began),
        gauges=rig.gauges,
        planned=planned_duration(task.loaded.protocol, rig.gauges),
        progress=task.progress,
        watch=task.watch,
        window=window,
    )


def _tested(task: Task, rig: Rig, journal: Journal, events: Iterator[Event]) -> tuple[Outcome, tuple[Figure, ...]]:
    """Record a test to its end; return how it ended, and its figures."""
    return finish_record(task, rig, journal, _located(task.loaded, lambda: journal.record(events)))


def finish_record(task: Task, rig: Rig, journal: Journal, outcome: Outcome) -> tuple[Outcome, tuple[Figure, ...]]:
    """Record the samples of the instruments and how a test ended; return this, and its figures."""
    protocol, trace = task.loaded.protocol, journal.trace
    log = protocol.log
    if outcome.end == "target" and not outcome.message:
        outcome = replace(outcome, message=unused_yield(trace, protocol.specimen))
    figures: tuple[Figure, ...] = ()
    if len(trace):
        for instrument in rig.instruments:
            for samples in measured_parts(
                instrument,
                trace,
                seed=log.seed,
                noise=log.noise,
                zeroings=journal.zeroings,
                stretches=stretches_of(trace, protocol),
            ):
                journal.writer.write_samples(samples)
        wall_time = perf_counter() - task.began
        figures = run_figures(
            trace,
            rig.size,
            journal.zeroings,
            wall_time,
            protocol=protocol,
            unfinished=outcome.unfinished,
            pitch=rig.relaxed_pitch,
        )
    journal.writer.finish(outcome)
    return outcome, figures


def published(task: Task, journal: Journal, outcome: Outcome, figures: tuple[Figure, ...]) -> RunResult:
    """Write the views of a test; the checkpoint is removed unless the test was interrupted.

    After an interrupt the progress stays at the share that was done [1].
    """
    progress = task.progress
    if outcome.end == "abort":
        progress = partial(_stay, task.progress, journal.done)
    record = RunReader(task.record, trace=journal.trace, test=task.loaded.protocol)
    publish(record, task.loaded.protocol.name, progress, draw=task.draw)
    if outcome.end != "abort":
        task.checkpoint.unlink(missing_ok=True)
    return result_of(outcome, with_wall_time(figures, perf_counter() - task.began), record)


def _stay(progress: Progress, done: float, share: float, text: str) -> None:
    """Report progress after an interrupt at a fixed share done [1]."""
    progress(done, "interrupted" if share >= 1.0 else text)


def _located(loaded: Loaded, test: Callable[[], Outcome]) -> Outcome:
    """Run a test; an error that a step raises meanwhile gets its place in the protocol file."""
    try:
        return test()
    except SpecificationError as error:
        raise loaded.locate(error) from error
