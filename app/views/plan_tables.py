"""Tables of a plan in a terminal, and the plan as JSON."""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any, Final

from rich.table import Table

from app.checks.budget import fibre_line
from app.schemas.defaults import shown_defaults
from app.views.tables import console_of, print_facts, specimen_data
from rigs.analysis.material_limits import limits_of
from rigs.axes import FACE
from rigs.protocol.targets import Bound

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from app.checks.dry_run import Plan
    from rigs.axes import Axis
    from rigs.control.plan import Planned
    from rigs.protocol.strokes import Stroke

_MOST_LINES: Final = 40


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
        "log_bytes": plan.size,
        "images": plan.images,
        "largest_strain": None if plan.budget is None else plan.budget.largest,
        "budget": None if plan.budget is None else asdict(plan.budget),
        "fibre_strain": plan.fibre_strain,
        "warnings": list(plan.warnings),
        "defaults": dict(plan.defaults),
    }


def _step_data(step: Planned) -> dict[str, Any]:
    """Return a step as plain data, SI units."""
    until = step.leaf.step.until
    return {
        "step": step.leaf.number,
        "place": step.leaf.place,
        "tag": step.leaf.step.tag,
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
        "gauge_length": stroke.gauge_length,
    }


def print_plan(plan: Plan) -> None:
    """Print the specimen, the table of strokes and their totals."""
    print_facts(plan.protocol, plan.specimen)
    axes = plan.protocol.axes
    table = Table("step", "set", "what", *(f"axis {axis}" for axis in axes), "time", "tag")
    lengths, lines = plan.specimen.gauge_lengths, 0
    for step in plan.steps:
        name = step.leaf.place.removeprefix("steps")
        for stroke in step.strokes[: _MOST_LINES - lines]:
            ways = [_way(stroke, axis, lengths[FACE[axis]]) for axis in axes]
            table.add_row(name, str(stroke.cycle), _what(stroke), *ways, f"{stroke.duration:.4g} s", stroke.tag or "")
            name, lines = "", lines + 1
        if not step.strokes and lines < _MOST_LINES:
            table.add_row(name, "", "nothing moves", *[""] * len(axes), "0 s", step.leaf.step.tag or "")
            lines += 1
        if step.leaf.step.until is not None and lines < _MOST_LINES:
            table.add_row("", "", f"until {_until(step)}", *[""] * len(axes), "", "")
    console = console_of()
    console.print(table)
    if len(plan.strokes) > _MOST_LINES:
        console.print(f"... and {len(plan.strokes) - _MOST_LINES} strokes more")
    images = f", {plan.images} pictures" if plan.images else ""
    size = f"{1e-6 * plan.size:.3g} MB at most"
    rows = f"{plan.rows} rows at {plan.protocol.log.rate:g} Hz{_densities(plan)}"
    console.print(f"planned duration {plan.duration:.4g} s, {rows}, {size}{images}")
    if plan.defaults:
        console.print(f"taken by default: {shown_defaults(plan.defaults)}", soft_wrap=True)
    for line in _limit_lines(plan):
        console.print(line)


def _limit_lines(plan: Plan) -> Iterator[str]:
    """Yield the strain of the yarn in the test, and the limits it would pass."""
    spec = plan.protocol.specimen
    if plan.budget is not None:
        budget, least = plan.budget, " at least" * any(stroke.searches for stroke in plan.strokes)
        yield (
            f"arc-length budget: goes to{least} {budget.largest:.1%} {budget.measure}, "
            f"estimated locking at {budget.locking:.1%}, {budget.locking - budget.largest:+.1%} to spare"
        )
    strained = fibre_line(spec, plan.fibre_strain)
    if strained:
        yield strained
    if not limits_of(spec) and spec.breaks_at is None:
        yield f"no strength or elongation at break of {spec.substance.name} is known: no limit of it is watched"
    if not plan.warnings:
        yield "no limit would be passed, as far as it can be foreseen"


def _densities(plan: Plan) -> str:
    """Return the logging of the steps as text."""
    log, own = plan.protocol.log, any(step.leaf.step.log is not None for step in plan.steps)
    events = log.events is not None or any(step.leaf.step.log and step.leaf.step.log.events for step in plan.steps)
    return f"{' and as the steps say' if own else ''}{', more near events' if events else ''}"


def print_points(plans: Mapping[str, Plan]) -> None:
    """Print the plan of the first point of a sweep, and the totals of all."""
    print_plan(next(iter(plans.values())))
    table = Table("point", "duration", "rows", "largest strain", "locking", "warnings")
    for label, plan in plans.items():
        strains = () if plan.budget is None else (plan.budget.largest, plan.budget.locking)
        shown = [f"{strain:.1%}" for strain in strains] or ["", ""]
        table.add_row(label, f"{plan.duration:.4g} s", str(plan.rows), *shown, str(len(plan.warnings)))
    console_of().print(f"the plan above is that of the first of {len(plans)} points")
    console_of().print(table)


def _what(stroke: Stroke) -> str:
    """Return the name of a stroke."""
    what = f"{stroke.phase} {', '.join(stroke.channels)}".strip()
    if stroke.gauge_length is not None:
        what += f", gauge length {stroke.gauge_length}"
    if stroke.stop_force is not None:
        what += f" to {stroke.stop_force:g} N"
    return what if stroke.drop is None else f"{what} until the force drops by {stroke.drop:.0%}"


def _until(step: Planned) -> str:
    """Return the conditions that end a step early."""
    units = {"force": " N", "displacement": " m", "time": " s"}
    until = step.leaf.step.until
    ends = {} if until is None else {one.name: getattr(until, one.name) for one in fields(until)}
    return ", ".join(f"{name} {_level(end)}{units.get(name, '')}" for name, end in ends.items() if end is not None)


def _level(end: float | Bound) -> str:
    """Return a level, with its side where that was said."""
    return f"{end.side} {end.value:g}" if isinstance(end, Bound) else f"{end:g}"


def _way(stroke: Stroke, axis: Axis, length: float) -> str:
    """Return the motion of an axis, in strain and mm, or in newtons."""
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
