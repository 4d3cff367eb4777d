"""Log rates of a test: a rate for each step, more near events, and which cycles are kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.instruments.ticks import Stretch
from rigs.jumps import jumped
from rigs.protocol.bounds import require
from rigs.protocol.unrolled import unrolled

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt

    from rigs.axes import FloatArray, IntArray
    from rigs.machines.machine import MachineData
    from rigs.protocol.catalogue import MachineName
    from rigs.protocol.protocol import LogSpec, Protocol
    from rigs.protocol.strokes import Stroke
    from rigs.protocol.unrolled import UnrolledStep
    from rigs.trace import Trace

SPAN: Final = 1.0
"""Near an event is within this many samples of the log's own rate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Density:
    """Log rate of a step.

    Attributes
    ----------
    rate : float
        Samples per second [Hz].
    events : float
        Samples per second near events [Hz]; no less than the rate.
    every_cycle : int
        Of its cycles the first, the last and each whose number is a multiple of this are kept.
    """

    rate: float
    events: float
    every_cycle: int

    def keeps(self, number: IntArray, last: int) -> npt.NDArray[np.bool_]:
        """Return which cycles of a step, counted from 1, are kept."""
        kept: npt.NDArray[np.bool_] = (number == 1) | (number == last) | (number % self.every_cycle == 0)
        return kept


def density(log: LogSpec, leaf: UnrolledStep | None = None) -> Density:
    """Return the log rate of a step; where it has none of its own, that of the test."""
    own = None if leaf is None else leaf.step.log
    rate = log.rate if own is None or own.rate is None else own.rate
    events = log.events if own is None or own.events is None else own.events
    every = log.every_cycle if own is None or own.every_cycle is None else own.every_cycle
    cycles = leaf is not None and leaf.step.cyclic
    return Density(rate=rate, events=max(rate, events or rate), every_cycle=every if cycles else 1)


def require_rates(protocol: Protocol, machines: Mapping[MachineName, MachineData]) -> None:
    """Raise where a log is faster than a machine of the rig samples.

    Raises
    ------
    SpecificationError
        Naming the place in the protocol and the highest rate.
    """
    machine, most = min(((name, data.clock.max_rate.value) for name, data in machines.items()), key=lambda one: one[1])
    said = [("log", protocol.log), *((f"{leaf.place}.log", leaf.step.log) for leaf in unrolled(protocol.steps))]
    for place, log in said:
        for name in ("rate", "events"):
            rate = None if log is None else getattr(log, name)
            fine = rate is None or rate <= most * (1.0 + 1e-9)
            found = "" if rate is None else f"{rate:g} Hz"
            require(fine, f"{place}.{name}", found, f"{most:g} Hz or less: {machine} samples no faster")


def stretches_of(trace: Trace, protocol: Protocol) -> list[Stretch]:
    """Return the parts of a test with their log rates.

    Events are the jumps of the specimen. Where a rate is said for them, they are logged in every cycle.
    """
    times, log = trace.columns["time"], protocol.log
    rates, events = _row_rates(trace, protocol)
    last = np.append(np.flatnonzero(np.diff(rates) != 0.0), len(times) - 1)
    base = [Stretch(end=float(times[row]), rate=float(rates[row])) for row in last]
    windows = []
    for row in np.flatnonzero(jumped(trace)).tolist():
        span = SPAN / (rates[row] or log.rate)
        if events[row] > rates[row]:
            at = float(times[row - 1])
            windows.append((at - span, min(at + span, float(times[-1])), float(events[row])))
    return _laid_over(base, windows) if windows else base


def _row_rates(trace: Trace, protocol: Protocol) -> tuple[FloatArray, FloatArray]:
    """Return the log rate up to each row, and that near events before it [Hz]; 0 where nothing is logged."""
    whole = density(protocol.log)
    rates, events = np.full(len(trace), whole.rate), np.full(len(trace), whole.events)
    steps, cycles = trace.columns["step"].astype(np.int64), trace.columns["cycle"].astype(np.int64)
    for leaf in unrolled(protocol.steps):
        own = density(protocol.log, leaf)
        if own == whole:
            continue
        rows = slice(*np.searchsorted(steps, [leaf.number, leaf.number + 1]).tolist())
        rates[rows], events[rows] = own.rate, own.events
        if own.every_cycle > 1 and rows.stop > rows.start:
            number = cycles[rows] - cycles[rows].min() + 1
            kept = own.keeps(number, int(number.max()))
            rates[rows] *= kept
            if own.events <= own.rate:
                events[rows] *= kept
    return rates, events


def _laid_over(base: Sequence[Stretch], windows: Sequence[tuple[float, float, float]]) -> list[Stretch]:
    """Return stretches with the denser ones of some windows, (begin, end, rate), laid over them."""
    ends = np.array([stretch.end for stretch in base])
    cuts = sorted({*ends.tolist(), *(edge for begin, end, _ in windows for edge in (begin, end) if edge <= ends[-1])})
    found: list[Stretch] = []
    for end in cuts:
        own = base[int(np.searchsorted(ends, end))].rate
        rate = max([own, *(rate for begin, last, rate in windows if begin < end <= last)])
        if found and found[-1].rate == rate:
            found.pop()
        found.append(Stretch(end=end, rate=rate))
    return found


def planned_samples(protocol: Protocol, steps: Sequence[tuple[UnrolledStep, Sequence[Stroke], float]]) -> float:
    """Return how many samples some steps will make, events not counted: each with its strokes and its time [s]."""
    return sum(
        time * density(protocol.log, leaf).rate * _share(protocol, leaf, strokes) for leaf, strokes, time in steps
    )


def _share(protocol: Protocol, leaf: UnrolledStep, strokes: Sequence[Stroke]) -> float:
    """Return the share of a step's time that is logged [1]."""
    own, whole = density(protocol.log, leaf), sum(stroke.duration for stroke in strokes)
    if own.every_cycle == 1 or whole == 0.0:
        return 1.0
    number = np.array([stroke.cycle for stroke in strokes]) - strokes[0].cycle + 1
    kept = own.keeps(number, int(number[-1]))
    return sum(stroke.duration for stroke, keep in zip(strokes, kept, strict=True) if keep) / whole
