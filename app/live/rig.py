"""A rig that is driven step by step: each move is a step of a protocol, done at once and recorded as such."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Self

from app.checks.dry_run import fitted_machines
from app.file_names import file_stem
from app.interactive.results import Run
from app.live.checks import checked, require_going_on
from app.live.moves import number_of, ramp_of, rate_of
from app.live.pace import Pace
from app.live.readings import Reading, reading_of
from app.live.recording import HEADER, Mark, Recording
from app.records.folder import make_run_folder
from app.runs.runner import make_task, mount_specimen, quiet
from app.runs.stopped import kept_in
from app.runs.use_cases import RUNS, compiling
from app.schemas import load, to_yaml
from app.views.drawing import draw_here
from knitlab_core.errors import SpecificationError
from rigs.protocol.step import step_name
from rigs.protocol.steps import Hold, Ramp, Repeat, Zero
from rigs.protocol.unrolled import unrolled

if TYPE_CHECKING:
    from collections.abc import Mapping
    from types import TracebackType

    from app.live.moves import Quantity
    from app.live.pace import Speed
    from app.runs.runner import Watch
    from app.schemas import Loaded, Source
    from app.views.drawing import Draw
    from rigs.axes import Axis
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.step import Step
    from rigs.protocol.targets import Control, Rate, StepLog, Target, Until
    from rigs.record import Equilibrium, Frame, Outcome
    from rigs.step_record import StepRecord


class LiveRig:
    """A rig with a specimen on it, driven step by step; use it in a `with` block, whose end writes log and pictures.

    Its run folder holds what `run` would have written of a protocol with these steps, and `protocol` is this protocol.
    Numbers are in SI; texts bring their units (``"5 mm"``). A move returns how it ended. A limit and a rupture are
    ends, after which moves are refused; `go_back` takes the test to an earlier `checkpoint` as if nothing had come
    after it.

    Parameters
    ----------
    head : Path, str, Mapping, Protocol or Loaded
        Specimen, rig and log: a protocol, its file, its text, or data. Steps that it has are done first.
    out : Path, str or None
        Run folder to make, under the next free name; None for one under ``runs/``.
    watch : callable or None
        Told number, row and strains [1] of every equilibrium as it is recorded.
    pace : float, 'real' or None
        How many seconds of the rig pass in one second, "real" for 1; None does not wait.
    draw : callable or None
        Begins to draw the plot and the knit at the end; None for no pictures.

    Attributes
    ----------
    folder : Path
        The run folder.

    Raises
    ------
    ProtocolError
        For whatever is wrong with the head.
    """

    def __init__(
        self,
        head: Source,
        out: Path | str | None = None,
        *,
        watch: Watch | None = None,
        pace: Speed = None,
        draw: Draw | None = draw_here,
    ) -> None:
        began, clock = perf_counter(), Pace(pace)
        given = load(head).no_sweep()
        loaded = _without_steps(given)
        wanted = RUNS / file_stem(loaded.protocol.name) if out is None else Path(out)
        with compiling():
            mounted, state = mount_specimen(loaded)
        with kept_in(wanted):
            self.folder = make_run_folder(wanted)
        self._watch = watch
        self._result: Run | None = None
        self._closed = False
        self._marks: list[Mark] = []
        self._machines = fitted_machines(loaded)
        task = make_task(loaded, self.folder, began, quiet, self._show, draw=draw)
        self._test = Recording(task=task, mounted=mounted, pace=clock)
        self._test.open(state)
        self._reading = reading_of(self._test.session)
        try:
            self._test.go_on()
            for leaf in unrolled(given.protocol.steps):
                if self._test.outcome is None:
                    self.do(leaf.step)
        except BaseException as error:
            self.close(error)
            raise

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes that are driven."""
        return self.protocol.axes

    @property
    def protocol(self) -> Protocol:
        """Return the protocol of what was done so far; `run` does the same again."""
        return self._test.protocol

    @property
    def outcome(self) -> Outcome | None:
        """Return how the test ended; None while it goes on."""
        return self._test.outcome

    def move(
        self,
        *axes: Axis,
        rate: Rate | str,
        to: Target | None = None,
        until: Until | None = None,
        log: StepLog | None = None,
        tag: str | None = None,
        **levels: Quantity,
    ) -> StepRecord:
        """Drive axes to a displacement since the last zero [m]: ``rig.move(C=5e-3, rate=2e-4)``.

        Several axes go together, to one level. ``rig.move("C", "W", to=kl.Target(kind="strain", value=0.1), rate=...)``
        says another target. `rate` is a speed [m/s], or a `StrainRate`.
        """
        if to is None:
            if axes:
                raise SpecificationError("move", ", ".join(axes), f"a target too: to=kl.Target(...), or {axes[0]}=5e-3")
            step = ramp_of("displacement", levels, rate, self.axes, until=until, log=log, tag=tag)
        else:
            if levels:
                raise SpecificationError(
                    "move", ", ".join(levels), 'axes by their names beside `to`: move("C", to=...)'
                )
            step = Ramp(axes=axes, to=to, rate=rate_of(rate, to.kind), until=until, log=log, tag=tag)
        return self.do(step)

    def move_strain(
        self,
        *,
        rate: Rate | str,
        until: Until | None = None,
        log: StepLog | None = None,
        tag: str | None = None,
        **levels: Quantity,
    ) -> StepRecord:
        """Drive axes to a strain since the last zero [1]: ``rig.move_strain(C=0.1, W=0.1, rate="1e-3 1/s")``."""
        return self.do(ramp_of("strain", levels, rate, self.axes, until=until, log=log, tag=tag))

    def move_force(
        self,
        *,
        rate: Rate | str,
        until: Until | None = None,
        log: StepLog | None = None,
        tag: str | None = None,
        **levels: Quantity,
    ) -> StepRecord:
        """Drive axes until their load cells show a force [N], at a force rate [N/s]."""
        return self.do(ramp_of("force", levels, rate, self.axes, until=until, log=log, tag=tag))

    def hold(
        self,
        duration: Quantity,
        *axes: Axis,
        control: Control | None = None,
        until: Until | None = None,
        log: StepLog | None = None,
        tag: str | None = None,
    ) -> StepRecord:
        """Keep the displacements for a time [s], or with ``control="force"`` the forces of some axes."""
        seconds = number_of(duration, "time", "duration")
        return self.do(Hold(duration=seconds, axes=axes, control=control, until=until, log=log, tag=tag))

    def zero(self) -> StepRecord:
        """Set load cells and encoders to zero."""
        return self.do(Zero())

    def do(self, step: Step | Repeat) -> StepRecord:
        """Do any step of a protocol, such as a `Cycle`; return how it ended.

        Raises
        ------
        SpecificationError
            If it cannot be done: it names an axis that is not driven, passes a limit of a machine, the test has ended,
            or the rig is closed. Nothing has moved then.
        """
        if isinstance(step, Repeat):
            records = []
            for leaf in unrolled((step,)):
                records.append(self.do(leaf.step))
                if records[-1].end == "abort" or self._test.outcome is not None:
                    break
            return records[-1]
        self._require_open(step_name(step))
        leaf = checked(self._test, self._machines, step)
        try:
            return self._test.do(leaf)
        finally:
            self._reading = reading_of(self._test.session)

    def stop(self) -> None:
        """End the step under way at its next equilibrium; another thread, or `watch`, may ask for it."""
        self._test.session.stopping = True
        self._test.pace.cut()

    def read(self) -> Reading:
        """Return what the rig shows: time [s], displacement [m], strain [1] and force [N] of each axis."""
        return self._reading

    def knit(self) -> Frame:
        """Return the shape of the knit: nodes [m], strains of the yarn [1], contact forces [N]."""
        self._require_open("knit")
        return self._test.session.frame()

    def checkpoint(self) -> Mark:
        """Return a mark to which `go_back` takes the test."""
        self._require_open("checkpoint")
        require_going_on(self._test, "checkpoint")
        self._marks.append(self._test.mark())
        return self._marks[-1]

    def go_back(self, mark: Mark) -> None:
        """Take the test back to a mark: specimen, clock and record are as if nothing had come after it."""
        self._require_open("go_back")
        if not any(mark is one for one in self._marks):
            raise SpecificationError("go_back", "a mark of another rig, or one that was undone", "a mark of this rig")
        while self._marks[-1] is not mark:
            self._marks.pop()
        self._test.go_back(mark)
        self._reading = reading_of(self._test.session)

    @property
    def result(self) -> Run:
        """Return how the run ended, with its tables, plots and pictures.

        Raises
        ------
        SpecificationError
            If the rig is open, or log and pictures could not be written.
        """
        if self._result is None:
            raise SpecificationError("result", "a run without an end", "a rig that was closed")
        return self._result

    def close(self, error: BaseException | None = None) -> Run:
        """End the test, write log and pictures, and return how it ended; an error that broke it off is recorded."""
        if not self._closed:
            self._closed = True
            self._result = Run.of(self._test.close(error))
        return self.result

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(error)

    def __repr__(self) -> str:
        state = "closed" if self._closed else "ended" if self._test.outcome is not None else "open"
        return f"<Rig {self.protocol.rig}, {state}, {len(self._test.steps)} steps, {self._reading.time:g} s>"

    def _show(self, number: int, row: Equilibrium, strain: Mapping[Axis, float]) -> None:
        """Note what the rig shows at an equilibrium that is recorded, and tell whoever watches."""
        self._reading = reading_of(self._test.session)
        if self._watch is not None:
            self._watch(number, row, strain)

    def _require_open(self, what: str) -> None:
        """Raise if the rig is closed."""
        if self._closed:
            raise SpecificationError(what, f"a rig that is closed; its run is in {self.folder}", "an open rig")


def _without_steps(loaded: Loaded) -> Loaded:
    """Return the head of a protocol: all but its steps, with its text."""
    protocol = replace(loaded.protocol, steps=())
    return replace(loaded, protocol=protocol, resolved=HEADER + to_yaml(protocol), materials="")
