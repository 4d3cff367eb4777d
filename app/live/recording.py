"""Recording of a live test: its steps as they come, its run folder, and marks to which it can be taken back."""

from __future__ import annotations

from collections import deque
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, cast

from app.records.checkpoint import read_checkpoint, save
from app.records.lock import locked
from app.records.writer import RunWriter
from app.runs.interrupts import interrupts_held
from app.runs.runner import begin_record, finish_record, journal_of, published
from app.runs.stopped import kept_in
from app.schemas import to_yaml
from rigs.control.checkpoint import checkpoint_of, restore
from rigs.control.experiment import perform_steps, session_of
from rigs.control.planner import Planner
from rigs.protocol.targets import Until
from rigs.record import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from app.live.pace import Pace
    from app.runs.journal import Journal
    from app.runs.publishing import RunResult
    from app.runs.runner import Task
    from knitlab_core.equilibrium.model import State
    from rigs.control.checkpoint import Checkpoint
    from rigs.control.experiment import Event
    from rigs.control.session import Session
    from rigs.machines.rig import Rig
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.step import Step
    from rigs.protocol.steps import Ramp
    from rigs.protocol.unrolled import UnrolledStep
    from rigs.step_record import StepRecord

HEADER: Final = "# a live rig: its head, and the steps that were done\n"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mark:
    """Place between two steps of a live test to which it can be taken back.

    Attributes
    ----------
    time : float
        Time on the rig's clock [s].
    steps : tuple of Step
        The steps before it.
    checkpoint : Checkpoint
        The test there.
    lengths : Mapping
        Lengths of its record.
    rows, zeroings : int
        How many there were.
    """

    time: float
    steps: tuple[Step, ...]
    checkpoint: Checkpoint
    lengths: Mapping[str, int]
    rows: int
    zeroings: int


@dataclass(slots=True, kw_only=True, eq=False)
class Recording:
    """Test whose steps are given one by one, and its record.

    Attributes
    ----------
    task : Task
        The test's head, its folder, and who is told of it.
    mounted : Rig
        The rig with the specimen as mounted.
    pace : Pace
        How its time passes.
    planner : Planner
        Makes the strokes of its steps.
    session : Session
        The test under way.
    journal : Journal
        Records it.
    steps : list of Step
        The steps so far.
    outcome : Outcome or None
        How it ended; None while it goes on.
    """

    task: Task
    mounted: Rig
    pace: Pace
    planner: Planner = field(init=False)
    session: Session = field(init=False)
    journal: Journal = field(init=False)
    steps: list[Step] = field(default_factory=list)
    outcome: Outcome | None = None
    _events: Iterator[Event] = field(init=False)
    _next: deque[UnrolledStep] = field(default_factory=deque)
    _closing: bool = False
    _open: ExitStack = field(default_factory=ExitStack)

    def open(self, state: State) -> None:
        """Lock the folder and create the record, to be closed by `close`."""
        self.planner = Planner(protocol=self.task.loaded.protocol, gauges=self.mounted.gauges)
        with kept_in(self.task.folder), ExitStack() as opened:
            opened.enter_context(locked(self.task.folder))
            begin_record(self.task, self.mounted, state)
            self._write()
            self._open = opened.pop_all()
        self.session = session_of(self.mounted, state, self.planner)
        self._perform()

    @property
    def protocol(self) -> Protocol:
        """Return the protocol of the steps so far."""
        return replace(self.task.loaded.protocol, steps=tuple(self.steps))

    def protocol_of(self, step: Step) -> Protocol:
        """Return the protocol of one step alone; it raises what is wrong with it on this rig."""
        return replace(self.task.loaded.protocol, steps=(step,))

    def text(self) -> str:
        """Return the same as the text of a file."""
        return HEADER + to_yaml(self.protocol)

    def do(self, leaf: UnrolledStep) -> StepRecord:
        """Do a step to its end, which may be that of the test; return how it ended."""
        self.steps.append(leaf.step)
        self._next.append(leaf)
        self.pace.begin(self.session.time)
        self.session.stopping = False
        self.go_on()
        record = self.journal.step
        if record is None or record.number != leaf.number:
            raise RuntimeError("a step that was done must be recorded")
        if record.end == "abort" and record.time > record.start:
            # So that the protocol says what was done.
            self.steps[-1] = _until(leaf.step, record.time - record.start)
        return record

    def go_on(self) -> None:
        """Record what happens until the test waits, or ends.

        Raises
        ------
        KeyboardInterrupt
            If it was interrupted, which ends it. So does any other error.
        """
        try:
            with kept_in(self.task.folder), interrupts_held() as self.journal.window:
                self.outcome = self.journal.record_steps(self._events)
        except BaseException as error:
            self.outcome = self._broken_off(error)
            raise
        if self.outcome is not None and self.outcome.end == "abort":
            raise KeyboardInterrupt

    def mark(self) -> Mark:
        """Return a mark of the place where the test waits."""
        checkpoint = checkpoint_of(self.session.rig, self.session.state, self.session.cursor)
        if checkpoint is None:
            raise RuntimeError("a test that waits has an equilibrium")
        return Mark(
            time=self.session.time,
            steps=tuple(self.steps),
            checkpoint=checkpoint,
            lengths=self.journal.writer.lengths(),
            rows=len(self.journal.rows),
            zeroings=len(self.journal.zeroings),
        )

    def go_back(self, mark: Mark) -> None:
        """Take test and record back to a mark; what came after it is dropped, and how the test ended too."""
        with kept_in(self.task.folder), interrupts_held():
            self.journal.keeper.forget()
            self.journal.writer.close()
            rows, zeroings = self.journal.rows[: mark.rows], self.journal.zeroings[: mark.zeroings]
            self._write(mark.lengths)
            self.journal.rows, self.journal.zeroings = rows, zeroings
            self.steps[:] = mark.steps
            self.journal.keeper.set_protocol(self.text(), self.journal.writer)
        rig = restore(self.mounted, mark.checkpoint)
        self.session = session_of(rig, mark.checkpoint.state, self.planner, cursor=mark.checkpoint.cursor)
        self.outcome = None
        self._perform()
        self.go_on()

    def close(self, error: BaseException | None) -> RunResult:
        """End the test, and write its record, log, plot and pictures; return how it ended."""
        with self._open, kept_in(self.task.folder):
            with interrupts_held():
                try:
                    outcome = self._ended(error)
                    text = self.text()
                    self._set_last(text, resumable=outcome.end == "abort")
                    loaded = replace(self.task.loaded, protocol=self.protocol, resolved=text)
                    task = replace(self.task, loaded=loaded)
                    outcome, figures = finish_record(task, self.mounted, self.journal, outcome)
                except BaseException as fault:
                    self.journal.writer.__exit__(type(fault), fault, None)
                    raise
                self.journal.writer.close()
            return published(task, self.journal, outcome, figures)

    def _write(self, lengths: Mapping[str, int] | None = None) -> None:
        """Open the record for rows, cut to some lengths."""
        writer = RunWriter(self.task.record, lengths)
        self.journal = journal_of(self.task, self.mounted, writer, nullcontext)
        self.journal.keeper.text = self.text

    def _perform(self) -> None:
        """Begin the events of the session."""
        self._next.clear()
        self._events = self.pace.keep(perform_steps(self.session, self.planner, self._leaves()))

    def _leaves(self) -> Iterator[UnrolledStep | None]:
        """Yield the steps as they are given; None while there is none."""
        while not self._closing or self._next:
            yield self._next.popleft() if self._next else None

    def _ended(self, error: BaseException | None) -> Outcome:
        """Return how the test ended, or end it."""
        if error is not None and (self.outcome is None or self.outcome.end == "abort"):
            return self._broken_off(error)
        if self.outcome is not None:
            return self.outcome
        self._closing = True
        return self.journal.record(self._events)

    def _broken_off(self, error: BaseException) -> Outcome:
        """Return the outcome of a test that an error broke off."""
        kept = f"{self.journal.writer.rows} equilibria kept"
        if isinstance(error, KeyboardInterrupt):
            return Outcome(end="abort", message=f"interrupted; {kept}")
        what = " ".join(f"{type(error).__name__}: {error}".split())
        return Outcome(end="abort", message=f"broken off by {what}; {kept}")

    def _set_last(self, text: str, *, resumable: bool) -> None:
        """Record the protocol in its last form; a test that was broken off resumes from its last checkpoint."""
        keeper = self.journal.keeper
        saved = read_checkpoint(keeper.path) if resumable and keeper.path.exists() else None
        keeper.set_protocol(text, self.journal.writer)
        if saved is not None:
            save(keeper.path, replace(saved, origin=keeper.origin))


def _until(step: Step, time: float) -> Step:
    """Return a step that ends after some time [s], if not before."""
    driven = cast("Ramp", step)
    until = Until(time=time) if step.until is None else replace(step.until, time=time)
    return replace(driven, until=until)
