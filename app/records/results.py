"""Figures of a test, such as moduli, loop areas and cost, computed from its equilibria."""

from __future__ import annotations

from math import isfinite
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from app.records.measurements import cycled, zeroings_of
from knitlab_core.equilibrium.stopwatch import Cost
from knitlab_core.knits import clasp_kind
from rigs.analysis.clasps import clasps_of
from rigs.analysis.cycles import cycle_figures
from rigs.analysis.material_limits import crossings, limits_of
from rigs.analysis.run_tables import LOST, STORED
from rigs.axes import DIRECTIONS, SHEARS
from rigs.instruments.zeros import gauge_lengths_taken, pin_strain

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from app.records.reader import RunReader
    from rigs.analysis.cycles import CycleFigures
    from rigs.analysis.material_limits import LimitCrossing
    from rigs.axes import Axis
    from rigs.instruments.zeros import Zeroing
    from rigs.protocol.protocol import Protocol
    from rigs.record import SpecimenSize
    from rigs.trace import Trace

Figure: TypeAlias = tuple[str, float, str]

WALL_TIME: Final = "wall time"
NOTHING: Final = Cost()
PITCH: Final = "relaxed_pitch_"
"""What the attributes of a record begin with that hold the pitch of relaxed stitches; the axis follows."""
NO_PITCH: Final[Mapping[Axis, float]] = MappingProxyType({})


def run_figures(
    trace: Trace,
    size: SpecimenSize,
    zeroings: Sequence[Zeroing],
    wall_seconds: float,
    *,
    protocol: Protocol | None = None,
    unfinished: Cost = NOTHING,
    pitch: Mapping[Axis, float] = NO_PITCH,
) -> tuple[Figure, ...]:
    """Return the figures of a run: stresses and loops of every cycle, cost, energy balance.

    Where the protocol has steps `cycle`, theirs alone are the cycles, each counted from the start of its step, on the
    axes that it drives.

    Parameters
    ----------
    trace : Trace
        The equilibria.
    size : SpecimenSize
        Turns travel and force into strain and stress.
    zeroings : sequence of Zeroing
        When channels were set to zero; strain and stress count from there, by the gauge lengths of each.
    wall_seconds : float
        Time from the start of the run to the end of its test [s].
    protocol : Protocol, optional
        The test.
    unfinished : Cost, optional
        What was spent on searches after the last row.
    pitch : Mapping, optional
        Pitch of the stitches of a yarn that relaxed into them before the test [m].

    Returns
    -------
    tuple of (name, value, unit)
        Empty if nothing was measured beyond the specimen as mounted.
    """
    if len(trace) < 2:
        return ()
    limits = limits_of(protocol.specimen) if protocol is not None else ()
    found = [
        *_zeros(size, zeroings),
        *_mechanics(trace, size, zeroings, protocol),
        *_effort(trace, unfinished, wall_seconds),
        *_soundness(trace),
        *_limits(crossings(trace, size, limits)),
        *((f"stitch pitch {axis}, relaxed", length, "m") for axis, length in pitch.items()),
        *_pins(trace, zeroings),
        *_clasps(trace),
        *_yielding(trace, protocol),
    ]
    return tuple(figure for figure in found if isfinite(figure[1]))


def _yielding(trace: Trace, protocol: Protocol | None) -> Iterator[Figure]:
    """Yield what plastic flow took, where fibres may yield."""
    if protocol is not None and protocol.specimen.yields:
        yield "plastic work", float(trace.columns["plastic_work"][-1]), "J"
        yield "plastic work / largest external work", _share_of_work(trace, "plastic_work"), "1"


def _share_of_work(trace: Trace, name: str) -> float:
    largest = float(np.abs(trace.columns["external_work"]).max())
    return float(trace.columns[name][-1]) / largest if largest > 0.0 else float("nan")


def with_wall_time(figures: Sequence[Figure], seconds: float) -> tuple[Figure, ...]:
    """Return the figures of a run with the wall time from its start to its last file [s]."""
    return tuple((name, seconds if name == WALL_TIME else value, unit) for name, value, unit in figures)


def energy_balance_error(trace: Trace) -> float:
    """Return the difference of external work and stored and dissipated energy over the largest work [1]."""
    columns = trace.columns
    kept = np.sum([columns[name] for name in (*STORED, *LOST) if name in columns], axis=0)
    work = columns["external_work"]
    # Work counts from the first row, but a straight yarn was bent into its knit before.
    kept -= kept[0] - work[0]
    largest = float(np.abs(work).max())
    return float(np.abs(work - kept).max()) / largest if largest > 0.0 else float("nan")


def figures_of(run: RunReader) -> tuple[Figure, ...]:
    """Return the figures of a run from its record, which does not hold the wall time."""
    return run_figures(
        run.trace,
        run.size,
        zeroings_of(run),
        float("nan"),
        protocol=run.test,
        unfinished=run.outcome.unfinished,
        pitch=pitch_of(run),
    )


def pitch_of(run: RunReader) -> dict[Axis, float]:
    """Return the pitch of the stitches of a yarn that relaxed into them before the test [m]; empty of a printed one."""
    found = {axis: run.provenance.get(f"{PITCH}{axis}") for axis in DIRECTIONS}
    return {axis: float(pitch) for axis, pitch in found.items() if pitch is not None}


def _zeros(size: SpecimenSize, zeroings: Sequence[Zeroing]) -> Iterator[Figure]:
    """Yield both zeros of strain, as printed and where a gauge length was taken, if one was."""
    taken = gauge_lengths_taken(size, zeroings)
    for axis in taken[0].gauges if taken else ():
        yield f"gauge length {axis}, as printed", size.gauge(axis), "m"
        for zeroing in taken:
            where = "at the zero" if len(taken) == 1 else f"at {zeroing.place}"
            yield f"gauge length {axis}, {where}", zeroing.gauges[axis], "m"
            yield f"travel {axis} from as printed, {where}", zeroing.travel[axis], "m"
            yield f"force {axis}, {where}", zeroing.force[axis], "N"


def _mechanics(
    trace: Trace, size: SpecimenSize, zeroings: Sequence[Zeroing], protocol: Protocol | None
) -> Iterator[Figure]:
    for part in cycled(trace, size, zeroings, protocol):
        found = cycle_figures(part.axis, part.strain, part.stress, part.phase, part.cycle)
        yield from _of_cycles(part.axis, found, f", {part.name}" if part.name else "")


def _of_cycles(axis: str, cycles: Sequence[CycleFigures], name: str) -> Iterator[Figure]:
    """Yield the figures of the cycles of an axis; a name distinguishes the steps of several."""
    shear = "shear " if axis in SHEARS else ""
    for figures in cycles:
        where = f"{axis}{name}, cycle {figures.cycle}"
        for level, value in figures.stress.items():
            yield f"{shear}stress at {level:.0%}, {where}", value, "Pa"
        yield f"secant {shear}modulus to 0.4%, {where}", figures.initial_secant, "Pa"
        yield f"secant {shear}modulus to peak, {where}", figures.peak_secant, "Pa"
        yield f"work of loading, {where}", figures.loading_work, "J/m3"
        yield f"loop area, {where}", figures.loop_area, "J/m3"
        yield f"loop area / work of loading, {where}", figures.hysteresis, "1"


def _effort(trace: Trace, unfinished: Cost, wall_seconds: float) -> Iterator[Figure]:
    columns = trace.columns
    iterations = columns["iterations"].sum()
    solved = np.count_nonzero(columns["factorisations"])
    yield "equilibria", float(len(trace)), "1"
    yield "Newton iterations", float(iterations + unfinished.iterations), "1"
    if unfinished.iterations:
        yield "of these after the last equilibrium", float(unfinished.iterations), "1"
    yield "iterations per equilibrium", float(iterations / solved) if solved else float("nan"), "1"
    yield "factorisations", float(columns["factorisations"].sum() + unfinished.factorisations), "1"
    yield "solver time", float(columns["seconds"].sum() + unfinished.seconds), "s"
    yield WALL_TIME, wall_seconds, "s"


def _soundness(trace: Trace) -> Iterator[Figure]:
    yield "energy balance error", energy_balance_error(trace), "1"
    if trace.columns["bonds_broken"].any():
        yield "fused points broken", float(trace.columns["bonds_broken"][-1]), "1"
    yield "largest strain of a fibre", float(trace.columns["fibre_strain"].max()), "1"
    yield "worst residual", float(trace.columns["residual"].max()), "1"


def _pins(trace: Trace, zeroings: Sequence[Zeroing]) -> Iterator[Figure]:
    """Yield what an extensometer read: the distance of its pins at the start, and the range of strain between them."""
    for axis in DIRECTIONS:
        distance = trace.columns.get(f"pin_distance_{axis}")
        if distance is not None:
            strain = pin_strain(distance, trace.columns["time"], zeroings)
            yield f"distance of pins {axis}, as mounted", float(distance[0]), "m"
            yield f"strain between pins {axis}, largest", float(strain.max()), "1"
            yield f"strain between pins {axis}, smallest", float(strain.min()), "1"


def _clasps(trace: Trace) -> Iterator[Figure]:
    for joined, held in clasps_of(trace).items():
        yield f"clasps {clasp_kind(joined)}, as mounted", float(held[0]), "1"
        yield f"clasps {clasp_kind(joined)}, fewest", float(held.min()), "1"


def _limits(found: Sequence[LimitCrossing]) -> Iterator[Figure]:
    for crossing in found:
        for axis, strain in crossing.strain.items():
            yield f"strain {axis} where {crossing.limit.name} is passed", strain, "1"
