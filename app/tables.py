"""Show plans, specimens and results in a terminal, or as JSON."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from app.labels import ELASTIC, beyond_elastic, yarn_label
from knitlab_core.knits import Filament
from knitlab_core.materials import DEFAULT_FRICTION

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from types import TracebackType
    from typing import Self

    from app.check import Plan, SpecimenFacts
    from app.figures import Figure
    from app.knitlab_client import Job
    from app.sweeps import SweepResult
    from app.usecases import RunResult
    from knitlab_core.materials import Material, Value
    from rigs.motion import Stroke
    from rigs.plan import Planned
    from rigs.protocol import Protocol
    from rigs.record import StepRecord
    from rigs.targets import Axis

_MOST_LINES: Final = 40


class Bar:
    """Show how far a run is, on stderr.

    Parameters
    ----------
    hidden : bool
        Show nothing.
    """

    def __init__(self, *, hidden: bool) -> None:
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            disable=hidden,
        )
        self._task = self._progress.add_task("starting", total=1.0)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def show(self, fraction: float, message: str) -> None:
        """Show the fraction done [1] and what is being done."""
        self._progress.update(self._task, completed=fraction, description=message)


def print_json(data: object) -> None:
    """Print an object as JSON to stdout."""
    sys.stdout.write(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def specimen_data(protocol: Protocol, facts: SpecimenFacts) -> dict[str, Any]:
    """Return a specimen as plain data, SI units."""
    spec = protocol.specimen
    return {
        "knit": spec.knit if isinstance(spec.knit, str) else asdict(spec.knit),
        "rows": spec.rows,
        "loops": spec.loops,
        "layers": spec.layers,
        "loop_width_m": spec.loop_width,
        "material": spec.substance.name,
        "friction": spec.friction,
        "yarn": yarn_label(spec),
        "beyond_elastic": beyond_elastic(spec),
        "nodes": facts.nodes,
        "yarn_length_m": facts.yarn_length,
        "fibre_radius_m": facts.fibre_radius,
        "clearance_m": facts.clearance,
        "gauge_lengths_m": dict(facts.gauge_lengths),
        "locking_strain": facts.locking_strain,
    }


def plan_data(plan: Plan) -> dict[str, Any]:
    """Return a plan as plain data, SI units."""
    return {
        "name": plan.protocol.name,
        "rig": plan.protocol.rig,
        "specimen": specimen_data(plan.protocol, plan.specimen),
        "steps": [_step_data(step) for step in plan.steps],
        "strokes": [_stroke_data(stroke) for stroke in plan.strokes],
        "duration_s": plan.duration,
        "rows": plan.rows,
        "images": plan.images,
        "largest_strain": plan.largest_strain,
        "warnings": list(plan.warnings),
    }


def _step_data(step: Planned) -> dict[str, Any]:
    """Return a step as plain data, SI units."""
    until = step.leaf.until
    return {
        "step": step.leaf.number,
        "place": step.leaf.place,
        "tag": step.leaf.tag,
        "strokes": len(step.strokes),
        "duration_s": step.duration,
        "until": None if until is None else {name: one for name, one in asdict(until).items() if one is not None},
    }


def _stroke_data(stroke: Stroke) -> dict[str, Any]:
    """Return a stroke as plain data, SI units."""
    return {
        "step": stroke.step,
        "cycle": stroke.cycle,
        "phase": stroke.phase,
        "tag": stroke.tag,
        "start_m": dict(stroke.start),
        "end_m": dict(stroke.end),
        "duration_s": stroke.duration,
        "force_N": {axis: list(ends) for axis, ends in stroke.force.items()},
        "free": list(stroke.free),
        "stop_force_N": stroke.stop_force,
        "drop": stroke.drop,
        "channels": list(stroke.channels),
    }


def result_data(result: RunResult) -> dict[str, Any]:
    """Return the end of a run as plain data."""
    return {
        "outcome": result.outcome,
        "message": result.message,
        "folder": str(result.folder),
        "figures": figures_data(result.figures),
        "steps": [asdict(step) for step in result.steps],
    }


def figures_data(figures: Sequence[Figure]) -> list[dict[str, Any]]:
    """Return figures as plain data."""
    return [{"name": name, "value": value, "unit": unit} for name, value, unit in figures]


def print_plan(plan: Plan) -> None:
    """Print the specimen, the table of strokes and what they come to."""
    print_facts(plan.protocol, plan.specimen)
    axes = plan.protocol.axes
    table = Table("step", "set", "what", *(f"axis {axis}" for axis in axes), "time", "tag")
    lengths, lines = plan.specimen.gauge_lengths, 0
    for step in plan.steps:
        name = step.leaf.place.removeprefix("steps")
        for stroke in step.strokes[: _MOST_LINES - lines]:
            ways = [_way(stroke, axis, lengths[axis]) for axis in axes]
            table.add_row(name, str(stroke.cycle), _what(stroke), *ways, f"{stroke.duration:.4g} s", stroke.tag or "")
            name, lines = "", lines + 1
        if not step.strokes and lines < _MOST_LINES:
            table.add_row(name, "", "nothing moves", *[""] * len(axes), "0 s", step.leaf.tag or "")
            lines += 1
        if step.leaf.until is not None and lines < _MOST_LINES:
            table.add_row("", "", f"until {_until(step)}", *[""] * len(axes), "", "")
    console = _stdout()
    console.print(table)
    if len(plan.strokes) > _MOST_LINES:
        console.print(f"... and {len(plan.strokes) - _MOST_LINES} strokes more")
    images = f", {plan.images} pictures" if plan.images else ""
    console.print(f"planned duration {plan.duration:.4g} s, {plan.rows} rows at {plan.protocol.log.rate:g} Hz{images}")
    if plan.largest_strain is not None and plan.specimen.locking_strain is not None:
        spare = plan.specimen.locking_strain - plan.largest_strain
        console.print(
            f"arc-length budget: goes to {plan.largest_strain:.1%} (as equibiaxial strain), "
            f"estimated locking at {plan.specimen.locking_strain:.1%}, {spare:+.1%} to spare"
        )
    if not plan.warnings:
        console.print("no limit would be passed")


def print_points(plans: Mapping[str, Plan]) -> None:
    """Print the plan of the first point of a sweep, and what all of them come to."""
    print_plan(next(iter(plans.values())))
    table = Table("point", "duration", "rows", "largest strain", "locking", "warnings")
    for label, plan in plans.items():
        strains = (plan.largest_strain, plan.specimen.locking_strain)
        shown = ("" if strain is None else f"{strain:.1%}" for strain in strains)
        table.add_row(label, f"{plan.duration:.4g} s", str(plan.rows), *shown, str(len(plan.warnings)))
    _stdout().print(f"the plan above is that of the first of {len(plans)} points")
    _stdout().print(table)


def _what(stroke: Stroke) -> str:
    """Return what a stroke is."""
    what = f"{stroke.phase} {', '.join(stroke.channels)}".strip()
    if stroke.stop_force is not None:
        what += f" to {stroke.stop_force:g} N"
    return what if stroke.drop is None else f"{what} until the force drops by {stroke.drop:.0%}"


def _until(step: Planned) -> str:
    """Return what ends a step early."""
    units = {"force": " N", "displacement": " m", "time": " s"}
    ends = {} if step.leaf.until is None else asdict(step.leaf.until)
    return ", ".join(f"{name} {value:g}{units.get(name, '')}" for name, value in ends.items() if value is not None)


def _way(stroke: Stroke, axis: Axis, length: float) -> str:
    """Return what an axis does, in strain and mm, or in newtons."""
    start, end = stroke.start[axis], stroke.end[axis]
    if axis in stroke.force:
        first, last = stroke.force[axis]
        return f"{first:.4g} -> {last:.4g} N" if first != last else f"keeps {last:.4g} N"
    if axis in stroke.free:
        return "gives way"
    if stroke.follow is not None and axis not in stroke.named:
        return f"strains with {stroke.follow}"
    if start == end:
        return f"stays at {start / length:.1%}"
    if stroke.searches:
        return f"from {start / length:.1%}"
    return f"{start / length:.1%} -> {end / length:.1%} ({1e3 * end:.4g} mm)"


def print_facts(protocol: Protocol, facts: SpecimenFacts) -> None:
    """Print what is known of the specimen."""
    spec = protocol.specimen
    material = spec.substance
    knit = spec.knit if isinstance(spec.knit, str) else "a stitch given by its values"
    knit = "no knit: a straight filament" if isinstance(spec.knit, Filament) else knit
    assumed = " (assumed)" if DEFAULT_FRICTION.assumed else ""
    table = Table.grid(padding=(0, 2))
    count = f"{spec.rows} rows x {spec.loops} loops" + (f" x {spec.layers} layers" if "P" in spec.axes else "")
    mounted = "" if protocol.mount is None else f", {protocol.mount} along the frame"
    budget = "no estimate but for a planar knit"
    if facts.locking_strain is not None:
        budget = f"used up at {facts.locking_strain:.1%} equibiaxial strain (estimate, +-1.3%)"
    for name, text in (
        ("test", f"{protocol.name} on {protocol.rig}{mounted}"),
        ("knit", f"{knit}, {count}, l = {1e3 * spec.loop_width:.4g} mm"),
        ("material", f"{material.name}: E = {material.young_modulus}, Poisson's ratio {material.poisson_ratio}"),
        ("friction", f"{spec.friction:g}{assumed}"),
        (
            "yarn",
            f"{facts.yarn_length:.4g} m, radius in contact {1e3 * facts.fibre_radius:.4g} mm, {facts.nodes} nodes",
        ),
        ("fibres", yarn_label(spec)),
        ("clearance", f"{1e3 * facts.clearance:.4g} mm between surfaces"),
        ("hook to hook", ", ".join(f"{axis} {1e3 * length:.4g} mm" for axis, length in facts.gauge_lengths.items())),
        ("arc-length budget", budget),
        *(beyond_elastic(spec) or {"beyond elastic": ELASTIC}).items(),
    ):
        table.add_row(name, text)
    _stdout().print(table)


def print_result(result: RunResult) -> None:
    """Print how a run ended and its figures."""
    console = _stdout()
    console.print(f"outcome: {result.outcome}; folder: {result.folder}", soft_wrap=True)
    print_steps(result.steps)
    print_figures(result.figures)


def sweep_data(result: SweepResult) -> dict[str, Any]:
    """Return a sweep as plain data."""
    points = [
        {
            "point": one.point.label,
            "values": dict(one.point.values),
            "folder": str(one.folder),
            "outcome": one.outcome,
            "message": one.message,
            "skipped": one.skipped,
            "figures": figures_data(one.figures),
        }
        for one in result.points
    ]
    return {"points": points, "table": str(result.table), "plot": str(result.plot)}


def print_sweep(result: SweepResult) -> None:
    """Print how the points of a sweep ended and where they are summed up."""
    table = Table("point", "outcome", "folder", "")
    for one in result.points:
        table.add_row(one.point.label, one.outcome, str(one.folder), "done before" if one.skipped else "")
    _stdout().print(table)
    _stdout().print(f"table: {result.table}\nplot: {result.plot}", soft_wrap=True)


def print_steps(steps: Sequence[StepRecord]) -> None:
    """Print how the steps ended."""
    if not steps:
        return
    table = Table("step", "tag", "from", "to", "end", "message")
    for step in steps[:_MOST_LINES]:
        times = (f"{step.start:.4g} s", f"{step.time:.4g} s")
        table.add_row(step.place.removeprefix("steps"), step.tag or "", *times, step.end, step.message)
    _stdout().print(table)
    if len(steps) > _MOST_LINES:
        _stdout().print(f"... and {len(steps) - _MOST_LINES} steps more")


def print_figures(figures: Sequence[Figure]) -> None:
    """Print figures."""
    if not figures:
        return
    table = Table("figure", "value", "unit")
    for name, value, unit in figures:
        table.add_row(name, f"{value:.4g}", unit)
    _stdout().print(table)


def materials_data(known: Mapping[str, Material]) -> dict[str, Any]:
    """Return materials as plain data, SI units, each number with its source."""
    return {name: asdict(material) for name, material in known.items()}


def print_materials(known: Mapping[str, Material]) -> None:
    """Print every number of every material with its source."""
    table = Table("material", "number", "value")
    table.add_column("source", overflow="fold")  # a DOI is one long word
    for name, material in known.items():
        first = name
        for number, value in _numbers(material):
            table.add_row(first, number, str(value), value.source)
            first = ""
        if material.note:
            table.add_row("", "note", "", material.note)
    _stdout().print(table)


def _numbers(material: Material) -> list[tuple[str, Value]]:
    """Return the numbers of a material that are known, under the words of a table."""
    single = {
        "Young's modulus": material.young_modulus,
        "Poisson's ratio": material.poisson_ratio,
        "strength": material.strength,
        "elongation at break": material.elongation_at_break,
        "density": material.density,
    }
    terms = [
        (f"{word} {number}", value)
        for number, term in enumerate(material.relaxation, 1)
        for word, value in (("relaxing share", term.share), ("relaxation time", term.time))
    ]
    return [(word, value) for word, value in single.items() if value is not None] + terms


def jobs_data(found: Sequence[Job]) -> list[dict[str, Any]]:
    """Return jobs as plain data."""
    return [asdict(job) for job in found]


def print_jobs(found: Sequence[Job]) -> None:
    """Print a table of jobs."""
    table = Table()
    for name in ("id", "name", "state", "done", "created", "end"):
        # An id must stay whole, to be copied.
        table.add_column(name, no_wrap=name == "id", overflow="fold")
    for job in found:
        created = (job.created or "")[:16].replace("T", " ")
        table.add_row(job.id, job.name, job.state, f"{job.progress.share:.0%}", created, job.end or "")
    _stdout().print(table)


def _stdout() -> Console:
    """Return a console that writes plain text where it is piped."""
    return Console(highlight=False, markup=False)
