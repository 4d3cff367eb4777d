"""All that a report says of one run."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final

from app.checks.dry_run import dry_run
from app.schemas import loads
from app.views.energies import energy_plot
from app.views.plots import stress_strain_plot
from app.views.renders import knit_frames, specimen_picture
from app.views.report.assumed import assumed_numbers, mesh_label
from app.views.report.drawings import inline_svg, picture
from app.views.tables import facts_rows
from rigs.machines.fixtures import clamped_nodes
from rigs.machines.pins import pins_on
from rigs.protocol.made_specimen import make_specimen

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from markupsafe import Markup

    from app.checks.dry_run import Plan
    from app.records.reader import RunReader
    from app.views.report.assumed import AssumedNumber
    from rigs.step_record import StepRecord

MOST_LINES: Final = 40
"""Steps, and places where clasps let go, that a report names."""

_ENDS: Final[Mapping[str, str]] = {
    "target": "carried out to its end",
    "rupture": "ended by rupture",
    "slipped": "ended as loops slipped off; nothing broke",
    "unravelled": "ended as the knit unravelled",
    "limit": "stopped at a limit",
    "timeout": "timed out",
    "diverged": "ended where no equilibrium was found",
    "abort": "cut short",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class RunContents:
    """All that a report says of one run.

    Attributes
    ----------
    name, title : str
        Name of the test, and the same told apart from others in the report.
    outcome : str
        How it ended, in words.
    going_on : bool
        Whether no end is recorded.
    started : str
        When it began, as the record says.
    notes : sequence of str
        Warnings: limits that would be or were passed, clasps that let go.
    steps : sequence of StepRecord
        Its steps and how each ended, at most `MOST_LINES`.
    more_steps : int
        Steps that are left out.
    facts : sequence of (name, text)
        What is known of the specimen.
    specimen : str
        Its picture as a data address.
    curves, energies : Markup or None
        The plots; None of a run without rows.
    frames : str or None
        Pictures along the test as a data address; None of a run that kept no shape.
    mesh : str
        The mesh and its stated error.
    defaults : Mapping
        Values that the protocol took by default, by their place.
    assumed : sequence of AssumedNumber
        Numbers that are assumed.
    versions : Mapping
        Versions that it was computed with.
    checksums : Mapping
        SHA-256 of the record, of the protocol and of its materials.
    protocol, materials : str
        Both texts as written; no materials is an empty text.
    """

    name: str
    title: str
    outcome: str
    going_on: bool
    started: str
    notes: Sequence[str]
    steps: Sequence[StepRecord]
    more_steps: int
    facts: Sequence[tuple[str, str]]
    specimen: str
    curves: Markup | None
    energies: Markup | None
    frames: str | None
    mesh: str
    defaults: Mapping[str, str]
    assumed: Sequence[AssumedNumber]
    versions: Mapping[str, str]
    checksums: Mapping[str, str]
    protocol: str
    materials: str


def contents_of(run: RunReader, title: str, number: int) -> RunContents:
    """Return all that a report says of a run.

    Parameters
    ----------
    run : RunReader
        The run; one that is going on or was cut off is told as far as it went.
    title : str
        What the report calls it.
    number : int
        Its number in the report, which tells its drawings apart.
    """
    name = str(run.provenance.get("name", run.path.parent.name))
    plan = dry_run(loads(run.protocol, str(run.path), name=name, materials=run.materials))
    rows = len(run.trace)
    return RunContents(
        name=name,
        title=title,
        outcome=_outcome(run),
        going_on=run.going_on,
        started=str(run.provenance.get("started", "not recorded")),
        notes=_notes(run, plan),
        steps=run.steps[:MOST_LINES],
        more_steps=max(0, len(run.steps) - MOST_LINES),
        facts=facts_rows(plan.protocol, plan.specimen),
        specimen=picture(partial(_draw_specimen, plan)),
        curves=inline_svg(partial(stress_strain_plot, run), f"curves of {title}", f"curves{number}") if rows else None,
        energies=inline_svg(partial(energy_plot, run), f"energies of {title}", f"energy{number}") if rows > 1 else None,
        frames=picture(partial(knit_frames, run)) if run.frames() else None,
        mesh=mesh_label(plan.protocol.specimen),
        defaults=plan.defaults,
        assumed=list(assumed_numbers(run.provenance)),
        versions={
            place.removeprefix("version."): str(text)
            for place, text in run.provenance.items()
            if place.startswith("version.")
        },
        checksums=_checksums(run),
        protocol=run.protocol,
        materials=run.materials,
    )


def _outcome(run: RunReader) -> str:
    end, message = run.outcome.end, run.outcome.message
    return f"{_ENDS.get(end, end)}{': ' * bool(message)}{message}"


def _notes(run: RunReader, plan: Plan) -> list[str]:
    """Return warnings of the protocol's check, and what a reader must know of the test."""
    notes = [f"foreseen by the check: {warning}" for warning in plan.warnings]
    notes += [f"beyond strength: {crossing}" for crossing in run.crossings]
    notes += [f"let go: {loss}" for loss in run.losses[:MOST_LINES]]
    if len(run.losses) > MOST_LINES:
        notes.append(f"clasps let go at {len(run.losses) - MOST_LINES} rows more")
    return notes


def _draw_specimen(plan: Plan, path: Path) -> None:
    specimen = make_specimen(plan.protocol.specimen)
    clamped = clamped_nodes(specimen, plan.protocol.fixtures)
    specimen_picture(specimen, path, clamped, pins_on(specimen, plan.protocol.extensometer))


def _checksums(run: RunReader) -> dict[str, str]:
    found = {f"record, {run.path.name}": _digest_of_file(run.path), "protocol": _digest(run.protocol)}
    return found | ({"materials": _digest(run.materials)} if run.materials else {})


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _digest_of_file(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
