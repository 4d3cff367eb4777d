"""Recording of a test while it runs: rows, shapes, checkpoints, progress."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from rigs.control.checkpoint import Checkpoint
from rigs.control.experiment import Waiting
from rigs.instruments.zeros import Zeroing
from rigs.record import Equilibrium, Frame, Outcome
from rigs.step_record import StepRecord
from rigs.trace import trace_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from contextlib import AbstractContextManager

    from app.records.checkpoint import Keeper
    from app.records.writer import RunWriter
    from rigs.axes import Axis
    from rigs.control.experiment import Event
    from rigs.trace import Trace

TESTED: Final = 0.9
"""Share of a run that is done when its test is: log, plot and pictures come after."""


@dataclass(slots=True, kw_only=True)
class Journal:
    """Recorder of a test while it runs; it keeps what the end of the test needs.

    Attributes
    ----------
    writer : RunWriter
        The record.
    keeper : Keeper
        Keeps checkpoints of it.
    gauges : Mapping
        Initial hook-to-hook length of each driven axis [m].
    planned : float
        Time that the test is planned to take [s].
    progress : callable
        Told the share done [1] and what is being done.
    watch : callable or None
        Told number, row and strains [1] of every equilibrium; a run that goes on tells some again.
    before : Trace or None
        Rows of the sessions before this one, up to the checkpoint that it resumed.
    rows : list of Equilibrium
        Rows of this session so far.
    zeroings : list of Zeroing
        Those so far.
    step : StepRecord or None
        The step that began or ended last.
    done : float
        Share of the run that is done [1].
    window : callable
        Returns a context in which an interrupt is raised: that of the solver's work, not of writing.
    """

    writer: RunWriter
    keeper: Keeper
    gauges: Mapping[Axis, float]
    planned: float
    progress: Callable[[float, str], None]
    watch: Callable[[int, Equilibrium, Mapping[Axis, float]], None] | None = None
    before: Trace | None = None
    rows: list[Equilibrium] = field(default_factory=list)
    zeroings: list[Zeroing] = field(default_factory=list)
    step: StepRecord | None = None
    done: float = 0.0
    window: Callable[[], AbstractContextManager[None]] = nullcontext

    def record(self, events: Iterator[Event]) -> Outcome:
        """Record every event; an interrupt ends the test and keeps the events so far."""
        outcome = self.record_steps(events)
        if outcome is None:
            raise RuntimeError("a test with all its steps must not wait for one")
        return outcome

    def record_steps(self, events: Iterator[Event]) -> Outcome | None:
        """Do the same until the test waits for its next step; return its outcome, None if it goes on."""
        try:
            while True:
                with self.window():
                    event = next(events, None)
                match event:
                    case Waiting():
                        return None
                    case Outcome():
                        return event
                    case None:
                        raise RuntimeError("a test must end with an outcome")
                    case _:
                        self._keep(event)
        except KeyboardInterrupt:
            return Outcome(end="abort", message=f"interrupted; {self.writer.rows} equilibria kept")

    def _keep(self, event: Event) -> None:
        """Record an event of the test that goes on."""
        match event:
            case Equilibrium():
                self.writer.append(event)
                self.rows.append(event)
                self._show(event)
            case Checkpoint():
                self.keeper.keep(event, self.writer, self.zeroings)
            case Frame():
                self.writer.add_frame(event)
            case StepRecord():
                self.writer.add_step(event)
                self.step = event
            case Zeroing():
                self.writer.add_zero(event)
                self.zeroings.append(event)

    @property
    def trace(self) -> Trace:
        """Return the rows of the test so far."""
        made = trace_of(self.rows)
        return made if self.before is None else self.before.followed_by(made)

    def _show(self, row: Equilibrium) -> None:
        """Report the progress of the test."""
        strain = {axis: row.displacement[axis] / length for axis, length in self.gauges.items()}
        if self.watch is not None:
            self.watch(self.writer.rows - 1, row, strain)
        text = f"{row.phase:7} {row.cycle}: {', '.join(f'{axis} {value:6.1%}' for axis, value in strain.items())}"
        done = min(1.0, row.time / self.planned) if self.planned > 0.0 else 1.0
        self.done = TESTED * done
        self.progress(self.done, text)
