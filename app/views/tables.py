"""Plans, specimens and results as tables in a terminal, or as JSON."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console
from rich.table import Table

from app.checks.budget import loop_budgets
from app.views.labels import ELASTIC, beyond_elastic, friction_value, material_label, yarn_label
from knitlab_core.knits import clasp_kind
from knitlab_core.materials import MeasuredYarn

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.checks.specimen_facts import SpecimenFacts
    from app.records.results import Figure
    from knitlab_core.materials import Substance, Value
    from rigs.analysis.clasps import ClaspLoss
    from rigs.analysis.material_limits import LimitCrossing
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.specimen import SpecimenSpec
    from rigs.step_record import StepRecord

_MOST_LINES: Final = 40
_BETWEEN: Final = {"hooks": "hook to hook", "clamps": "between clamps", "plates": "between plates"}


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
        "pins_m": dict(facts.pins),
        "locking_strain": facts.locking_strain,
        "clasps": dict(facts.clasps),
    }


def figures_data(figures: Sequence[Figure]) -> list[dict[str, Any]]:
    """Return figures as plain data."""
    return [{"name": name, "value": value, "unit": unit} for name, value, unit in figures]


def print_facts(protocol: Protocol, facts: SpecimenFacts) -> None:
    """Print what is known of the specimen."""
    table = Table.grid(padding=(0, 2))
    for name, text in facts_rows(protocol, facts):
        table.add_row(name, text)
    console_of().print(table)


def facts_rows(protocol: Protocol, facts: SpecimenFacts) -> list[tuple[str, str]]:
    """Return what is known of the specimen, each fact as its name and its text."""
    spec = protocol.specimen
    knit = spec.knit if isinstance(spec.knit, str) else spec.knit.description
    count = f"{spec.rows} rows x {spec.loops} loops" + (f" x {spec.layers} layers" if "P" in spec.axes else "")
    mounted = "" if protocol.mount is None else f", {protocol.mount} along the frame"
    budget = "none: a filament has no loops" if spec.fabric.straight else _loop_budgets(spec)
    budget = "unknown: relaxed strands press on each other" if spec.relaxed else budget
    if facts.locking_strain is not None:
        (loop,) = loop_budgets(spec.fabric, spec.laid).values()
        good = f"estimate, +-{loop.error:.1%}"
        if spec.measured is not None:
            good = "estimate for the outer radius: pressed together, yarn reaches farther"
        budget = f"used up at {facts.locking_strain:.1%} equibiaxial strain ({good})"
    return [
        ("test", f"{protocol.name} on {protocol.rig}{mounted}"),
        ("knit", f"{knit}, {count}, l = {1e3 * spec.loop_width:.4g} mm"),
        ("material", material_label(spec)),
        ("friction", str(friction_value(spec))),
        (
            "yarn",
            f"{facts.yarn_length:.4g} m, radius in contact {1e3 * facts.fibre_radius:.4g} mm, {facts.nodes} nodes",
        ),
        ("fibres", yarn_label(spec)),
        ("clearance", _clearance(facts)),
        *_gauges(protocol, facts),
        *_pins(protocol, facts),
        ("clasps", _clasps(facts)),
        ("arc-length budget", budget),
        *(beyond_elastic(spec) or {"beyond elastic": ELASTIC}).items(),
    ]


def _loop_budgets(spec: SpecimenSpec) -> str:
    """Return the text that names the strain at which loops of a volumetric knit have used up their yarn."""
    budgets = loop_budgets(spec.fabric, spec.laid)
    if not budgets:
        return "unknown: which parts of the yarn are loops is not known"
    ends = [f"{axis} loops {loop.locking:.1%}" for axis, loop in budgets.items()]
    return f"used up at {', '.join(ends)} equibiaxial strain (rough estimate, of planar loops)"


def _clearance(facts: SpecimenFacts) -> str:
    """Return how far the surfaces of strands are apart, or by how much they overlap as laid in."""
    if facts.clearance < 0.0:
        return f"none: surfaces overlap by {-1e3 * facts.clearance:.4g} mm as laid in, before the yarn relaxes"
    return f"{1e3 * facts.clearance:.4g} mm between surfaces"


def _gauges(protocol: Protocol, facts: SpecimenFacts) -> list[tuple[str, str]]:
    """Return a line for each kind of grip with the distances between such grips."""
    lines: dict[str, list[str]] = {}
    for axis, length in facts.gauge_lengths.items():
        between = _BETWEEN[protocol.fixtures[axis]] if axis in protocol.fixtures else "edge to edge"
        between = "cell repeats after" if protocol.specimen.periodic else between
        lines.setdefault(between, []).append(f"{axis} {1e3 * length:.4g} mm")
    return [(between, ", ".join(each)) for between, each in lines.items()]


def _pins(protocol: Protocol, facts: SpecimenFacts) -> list[tuple[str, str]]:
    """Return the line that says where the pins of the extensometer are; none without one."""
    if protocol.extensometer is None:
        return []
    places = protocol.extensometer.places(protocol.specimen.counts)
    pairs = (f"{axis} {1e3 * facts.pins[axis]:.4g} mm between {place}" for axis, place in places.items())
    return [("extensometer", "; ".join(pairs))]


def _clasps(facts: SpecimenFacts) -> str:
    """Say how many clasps hold a knit together."""
    return ", ".join(f"{count} {clasp_kind(joined)}" for joined, count in facts.clasps.items()) or "unknown, or none"


def print_crossings(found: Sequence[LimitCrossing]) -> None:
    """Print where limits of the material were passed."""
    for crossing in found:
        console_of().print(f"beyond strength: {crossing}", soft_wrap=True)


def print_losses(found: Sequence[ClaspLoss]) -> None:
    """Print where clasps let go."""
    for loss in found[:_MOST_LINES]:
        console_of().print(f"let go: {loss}", soft_wrap=True)
    if len(found) > _MOST_LINES:
        console_of().print(f"... and at {len(found) - _MOST_LINES} rows more")


def print_steps(steps: Sequence[StepRecord]) -> None:
    """Print how the steps ended."""
    if not steps:
        return
    table = Table("step", "tag", "from", "to", "end", "message")
    for step in steps[:_MOST_LINES]:
        times = (f"{step.start:.4g} s", f"{step.time:.4g} s")
        table.add_row(step.place.removeprefix("steps"), step.tag or "", *times, step.end, step.message)
    console_of().print(table)
    if len(steps) > _MOST_LINES:
        console_of().print(f"... and {len(steps) - _MOST_LINES} steps more")


def print_figures(figures: Sequence[Figure]) -> None:
    """Print figures."""
    if not figures:
        return
    table = Table("figure", "value", "unit")
    for name, value, unit in figures:
        table.add_row(name, f"{value:.4g}", unit)
    console_of().print(table)


def materials_data(known: Mapping[str, Substance]) -> dict[str, Any]:
    """Return materials as plain data, SI units, each number with its source."""
    return {name: asdict(material) for name, material in known.items()}


def print_materials(known: Mapping[str, Substance]) -> None:
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
    console_of().print(table)


def _numbers(material: Substance) -> list[tuple[str, Value]]:
    """Return the numbers of a material that are known, under the words of a table."""
    if isinstance(material, MeasuredYarn):
        return list(material.numbers())
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
    curve = [
        (f"{word} {number}", value)
        for number, point in enumerate(material.yield_curve, 1)
        for word, value in (("yield strain", point.strain), ("yield stress", point.stress))
    ]
    return [(word, value) for word, value in single.items() if value is not None] + terms + curve


def console_of() -> Console:
    """Return a console that writes plain text where it is piped."""
    return Console(highlight=False, markup=False)
