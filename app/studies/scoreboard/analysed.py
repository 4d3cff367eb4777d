"""What the rows of the scoreboard are scored by: curves, tables and facts of a test."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from app.records.analysis import analyse_run, hooks_of
from app.records.measurements import cycled, measurements_of, zeroings_of
from knitlab_core.knits import Stitch, clasp_counts, locking_strain, yarn_per_loop
from rigs.analysis.curve_tables import loading_branches
from rigs.analysis.figures import figures_by_cycle
from rigs.protocol.made_specimen import make_specimen

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from app.records.reader import RunReader
    from rigs.analysis.cycles import CycleFigures
    from rigs.analysis.table import Table
    from rigs.axes import Axis, FloatArray
    from rigs.measurement import Measurement
    from rigs.protocol.protocol import Protocol


class UnscorableError(Exception):
    """A row cannot be scored; the message says why."""


def _no_table(name: str) -> Table:
    raise UnscorableError(f"no table {name}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysed:
    """A test as its rows are scored.

    Attributes
    ----------
    name : str
        What rows call it.
    curves : Mapping
        Its cycles, or the whole test, along each driven axis.
    tables : callable
        Returns a table by its name: those of `knitlab analyse --table`.
    hooks : callable
        Returns how many hooks are on a side of each axis.
    facts : Mapping
        Numbers of its protocol, specimen and log, in SI units.
    end, message : str
        How it ended.
    """

    name: str
    curves: Mapping[str, Measurement] = field(default_factory=dict)
    tables: Callable[[str], Table] = _no_table
    hooks: Callable[[], Mapping[Axis, int]] = dict
    facts: Mapping[str, float] = field(default_factory=dict)
    end: str = "target"
    message: str = ""

    def loading(self, axis: str, cycle: int = 1) -> tuple[FloatArray, FloatArray]:
        """Return strain [1] and stress [Pa] of the loading of a cycle along an axis.

        Raises
        ------
        UnscorableError
            If the test has no such loading.
        """
        for number, strain, stress in loading_branches(self.curves[axis]) if axis in self.curves else ():
            if number == cycle:
                return strain, stress
        raise UnscorableError(f"{self.name} has no loading {cycle} along {axis}{self.ended()}")

    def cycles(self, axis: str) -> tuple[CycleFigures, ...]:
        """Return the figures of all cycles along an axis."""
        if axis not in self.curves:
            raise UnscorableError(f"{self.name} was not driven along {axis}{self.ended()}")
        return figures_by_cycle(self.curves[axis])

    def rows_of(self, table: str, *columns: str) -> list[FloatArray]:
        """Return columns of a table at the rows of the first loading, numbers (n,)."""
        found = self.tables(table)
        missing = [name for name in columns if name not in found.columns]
        if missing:
            raise UnscorableError(f"{self.name} has no {missing[0]} in its table {table}")
        cycle, phase = np.asarray(found.columns["cycle"]), np.asarray(found.columns["phase"], dtype=object)
        first = (cycle == cycle.min()) & ((phase == "Stretch") | (phase == "Zero"))
        return [np.asarray(found.columns[name], dtype=np.float64)[first] for name in columns]

    def ended(self) -> str:
        """Return in words how it ended before its target; nothing of a test that got there."""
        return "" if self.end == "target" else f": it ended as {self.end}, {self.message}"


def analysed(name: str, run: RunReader) -> Analysed:
    """Return a run as its rows are scored."""
    parts = cycled(run.trace, run.size, zeroings_of(run), run.test)
    whole = {one.axis: one for one in measurements_of(run)}
    return Analysed(
        name=name,
        curves={**whole, **{part.axis: part for part in parts}},
        tables=lambda table: analyse_run(run, table),
        hooks=lambda: hooks_of(run),
        facts=dict(_facts(run)),
        end=run.outcome.end,
        message=run.outcome.message,
    )


def _facts(run: RunReader) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a run: material, stitch, and speeds by its log."""
    yield from _of_specimen(run.test)
    material = run.test.specimen.substance
    modulus = getattr(material, "young_modulus", None)
    if modulus is not None:
        yield "young_modulus", float(modulus.value)
    yield from (("thickness", run.size.extents["P"]), ("height", run.size.extents["P"]))
    rubs = run.provenance.get("rig.pole.friction")
    if rubs is not None:
        yield "pole_friction", float(rubs)
    yield from _speeds(run)


def _of_specimen(protocol: Protocol) -> Iterator[tuple[str, float]]:
    spec = protocol.specimen
    yield from (("rows", float(spec.rows)), ("loops", float(spec.loops)), ("layers", float(spec.layers)))
    yield "loop_width", spec.loop_width
    stitch = spec.fabric
    if not isinstance(stitch, Stitch):
        return
    fibres = 1 if spec.yarn is None else spec.yarn.fibres
    radius = stitch.fibre_radius if spec.yarn is None else spec.yarn.fibre_radius
    yield from (("a", stitch.curvature), ("n", float(fibres)), ("l", spec.loop_width))
    for name, value in (("h", stitch.height), ("d", stitch.depth), ("w", stitch.row_spacing), ("r", radius)):
        yield name, value * spec.loop_width
    yield "L", yarn_per_loop(stitch) * spec.loop_width
    thick = stitch.fibre_radius if spec.yarn is None else spec.yarn.contact_radius
    yield "locking_strain", locking_strain(stitch, yarn_per_loop(stitch), thick)


def _speeds(run: RunReader) -> Iterator[tuple[str, float]]:
    """Yield the speed of each axis by the instrument's log [m/s]: the median of its travel by time as it is driven."""
    for log in run.logs.values():
        samples = log.part(0, min(len(log), 20_000))
        driven = np.asarray(samples.phase, dtype=object) == "Stretch"
        both = driven[1:] & driven[:-1]
        for channel, column in samples.reads.items():
            axis = column.removeprefix("crosshead_")
            if axis == column or not both.any():
                continue
            rate = np.diff(samples.measured[channel])[both] / np.diff(samples.time)[both]
            # A log has another axis' steps too, in which this one stands.
            moving = rate[np.abs(rate) > 1e-3 * np.abs(rate).max()] if np.any(rate) else rate[:0]
            if len(moving):
                yield f"speed {axis}", float(np.median(moving))


def printed(name: str, protocol: Protocol) -> Analysed:
    """Return a specimen as it is printed, which rows about its shape alone are scored by."""
    specimen = make_specimen(protocol.specimen)
    facts = {
        **dict(_of_specimen(protocol)),
        "strands": float(len(specimen.strands)),
        "clearance": specimen.clearance,
        "fibre_radius": specimen.radius,
        **{f"clasps {joined}": float(count) for joined, count in clasp_counts(specimen).items()},
    }
    return Analysed(name=name, facts=facts)
