"""Do what the doors ask for: run a protocol into a run folder."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Final

from app.check import build_specimen
from app.export import export_logs
from app.figures import run_figures
from app.pictures import knit_frames
from app.provenance import provenance
from app.report import stress_strain_plot
from app.rig_data import machines_of
from app.run_folder import make_run_folder
from app.run_reader import RunReader
from app.runs import RunWriter
from app.schemas import load
from knitlab_core.errors import SpecificationError
from knitlab_core.jit import cache_is_cold
from rigs.experiment import perform
from rigs.instruments import Zeroing, measure
from rigs.motion import planned_duration
from rigs.record import Equilibrium, Frame, Outcome, trace_of
from rigs.rig import mount

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from app.figures import Figure
    from app.schemas import Loaded
    from rigs.experiment import Event
    from rigs.record import End
    from rigs.rig import Rig
    from rigs.steps import Axis

    Watch = Callable[[int, Equilibrium, Mapping[Axis, float]], None]

RUNS: Final = Path("runs")

TESTED: Final = 0.9
"""Share of a run that is done when its test is: log, plot and pictures come after."""

FIRST_RUN: Final = (
    "compiling the solver for this machine: takes about a minute, once; the result is kept for later runs\n"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunResult:
    """Say how a run ended and what it came to.

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
    """

    outcome: End
    message: str
    folder: Path
    figures: tuple[Figure, ...]


@dataclass(slots=True, kw_only=True)
class _Journal:
    """Write a test down as it happens, and remember what the end of it needs."""

    writer: RunWriter
    rig: Rig
    planned: float
    progress: Callable[[float, str], None]
    watch: Watch | None = None
    rows: list[Equilibrium] = field(default_factory=list)
    zeroings: list[Zeroing] = field(default_factory=list)

    def record(self, events: Iterator[Event]) -> Outcome:
        """Write down every event; an interrupt ends the test and keeps them."""
        try:
            for event in events:
                match event:
                    case Equilibrium():
                        self.writer.append(event)
                        self.rows.append(event)
                        self._show(event)
                    case Frame():
                        self.writer.add_frame(event)
                    case Zeroing():
                        self.zeroings.append(event)
                    case Outcome():
                        return event
        except KeyboardInterrupt:
            return Outcome(end="abort", message=f"interrupted; {len(self.rows)} equilibria kept")
        raise RuntimeError("a test must end with an outcome")

    def _show(self, row: Equilibrium) -> None:
        """Show how far the test is."""
        strain = {axis: row.displacement[axis] / length for axis, length in self.rig.gauges.items()}
        if self.watch is not None:
            self.watch(len(self.rows) - 1, row, strain)
        text = f"{row.phase:7} {row.cycle}: {', '.join(f'{axis} {value:6.1%}' for axis, value in strain.items())}"
        done = min(1.0, row.time / self.planned) if self.planned > 0.0 else 1.0
        self.progress(TESTED * done, text)


def run_protocol(path: Path, out: Path | None, progress: Callable[[float, str], None]) -> RunResult:
    """Run a protocol: record, log, plot and pictures in a run folder.

    Parameters
    ----------
    path : Path
        The protocol file.
    out : Path or None
        Run folder to make, under the next free name; None for one under ``runs/``.
    progress : callable
        Told the share done [1] and what is being done.

    Returns
    -------
    RunResult
        How it ended; a limit, an interrupt and a solver that gave up are outcomes, with their rows kept.

    Raises
    ------
    ProtocolError
        For whatever is wrong with the protocol, in one line.
    """
    loaded = load(path)
    return run_loaded(loaded, RUNS / loaded.protocol.name if out is None else out, progress)


def run_loaded(
    loaded: Loaded,
    out: Path,
    progress: Callable[[float, str], None],
    watch: Watch | None = None,
    *,
    pictures: bool = True,
) -> RunResult:
    """Run a protocol that has been read; else as `run_protocol`.

    Parameters
    ----------
    loaded : Loaded
        The protocol.
    out : Path
        Run folder to make, under the next free name.
    progress : callable
        Told the share done [1] and what is being done.
    watch : callable or None
        Told the number, the row and the strains [1] of every equilibrium.
    pictures : bool
        Whether to draw the plot and the knit too.
    """
    if cache_is_cold():
        sys.stderr.write(FIRST_RUN)
    result = _test(loaded, out, progress, watch)
    _publish(result.folder, loaded.protocol.name, progress, pictures=pictures)
    return result


def _test(loaded: Loaded, wanted: Path, progress: Callable[[float, str], None], watch: Watch | None) -> RunResult:
    """Do the test of a protocol and write its record, ``run.h5``."""
    began = perf_counter()
    protocol = loaded.protocol
    specimen = build_specimen(loaded)
    data = machines_of(protocol)
    rig, state = mount(specimen, protocol, data)
    folder = make_run_folder(wanted)
    figures: tuple[Figure, ...] = ()
    with RunWriter(
        folder / "run.h5",
        protocol=loaded.text,
        size=rig.size,
        axes=protocol.axes,
        strands=rig.strands,
        instruments=rig.instruments,
        provenance=provenance(protocol, data),
        materials=loaded.materials,
    ) as writer:
        planned = planned_duration(protocol, rig.gauges)
        journal = _Journal(writer=writer, rig=rig, planned=planned, progress=progress, watch=watch)
        outcome = _located(loaded, lambda: journal.record(perform(rig, state, protocol)))
        if journal.rows:
            trace, log = trace_of(journal.rows), protocol.log
            for instrument in rig.instruments:
                writer.write_samples(
                    measure(instrument, trace, seed=log.seed, noise=log.noise, zeroings=journal.zeroings)
                )
            figures = run_figures(trace, rig.size, journal.zeroings, perf_counter() - began)
        writer.finish(outcome)
    return RunResult(outcome=outcome.end, message=outcome.message, folder=folder, figures=figures)


def _located(loaded: Loaded, test: Callable[[], Outcome]) -> Outcome:
    """Give a step that turns out impossible on the way its place in the file."""
    try:
        return test()
    except SpecificationError as error:
        raise loaded.locate(error) from error


def _publish(folder: Path, name: str, progress: Callable[[float, str], None], *, pictures: bool) -> None:
    """Write the views of a record that has rows: the instruments' logs, the plot, the pictures."""
    run = RunReader(folder / "run.h5")
    if not len(run.trace):
        return
    progress(TESTED, "writing the log")
    export_logs(run, folder, name)
    if pictures:
        progress(TESTED, "plotting")
        stress_strain_plot(run, folder / f"{name}_stress_strain.png")
        progress(TESTED, "drawing the knit")
        note = knit_frames(run, folder / f"{name}_knit.png").note
        if note:
            sys.stderr.write(note + "\n")
    progress(1.0, "done")
