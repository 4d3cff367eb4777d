"""Command line: results to stdout, progress and errors to stderr.

Heavy modules are imported inside the commands, so that `knitlab --help` answers at once.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from app.cli.analyse import ANALYSE_HELP, analyse
from app.cli.analysis import plot, sweep
from app.cli.calibrate import CALIBRATE_HELP, calibrate
from app.cli.compare import COMPARE_HELP, compare
from app.cli.design import DESIGN_HELP, design
from app.cli.exit_codes import UNWRITABLE, USAGE, error_exit_code
from app.cli.export import EXPORT_HELP, export
from app.cli.live import LIVE_HELP, live
from app.cli.printing import PRINT_HELP, print_
from app.cli.remote import remote
from app.cli.report import REPORT_HELP, report
from app.cli.run import resume, run
from app.cli.scoreboard import SCOREBOARD_HELP, scoreboard
from app.cli.sem import EXAMPLE, SHORT, images
from app.cli.serve import service
from app.cli.studies import master_curve
from app.cli.terminal import AsJson, Chosen, ProtocolPath, complain, complain_of, values_of, warn
from app.records.storage import is_unwritable
from app.runs.stopped import RunStoppedError
from knitlab_core.errors import KnitlabError

knitlab = typer.Typer(
    name="knitlab",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    help="""A virtual laboratory for the mechanics of knits.

    A protocol (YAML) says which knit is tested on which rig, and how. A first session:

    \b
      knitlab check examples/biaxial_cycle.yaml     what would happen, without physics
      knitlab preview examples/biaxial_cycle.yaml   the knit: picture, clearance, yarn length
      knitlab run examples/biaxial_cycle.yaml       the test itself, into a run folder
      knitlab resume runs/biaxial_cycle             go on with a run that was killed
      knitlab export runs/biaxial_cycle             its log again, in any dialect, locale, unit
      knitlab print examples/biaxial_cycle.yaml     the knit for a 3D printer: checks, STL, 3MF
      knitlab submit examples/biaxial_cycle.yaml    the test as a job of a service: knitlab serve

    Results go to stdout, progress to stderr.

    Exit codes: 0 done, 2 invalid input, 3 the solver failed, 4 a limit tripped before any data,
    5 service unreachable, 6 not printable, 7 a file cannot be written (disk full), 130 interrupted.""",
)
knitlab.add_typer(service)
knitlab.add_typer(remote)


def main() -> None:
    """Run the command line; every foreseen error is one line on stderr and an exit code."""
    try:
        try:
            knitlab(standalone_mode=True)
        finally:
            _flush()
    except KnitlabError as error:
        complain_of(error)
        sys.exit(error_exit_code(error))
    except RunStoppedError as error:
        complain(f"{error.filename}: {error.strerror}")
        sys.exit(UNWRITABLE)
    except OSError as error:
        # Errors of files carry a name; without one it is stdout.
        name = error.filename or ("output" if is_unwritable(error) else "")
        complain(f"{name}{': ' if name else ''}{error.strerror.lower() if error.strerror else error}")
        sys.exit(UNWRITABLE if is_unwritable(error) else USAGE)


def _flush() -> None:
    """Flush stdout now: otherwise a full disk is reported at exit, as a traceback."""
    try:
        sys.stdout.flush()
    except OSError:
        # The rest is dropped, or Python would try again at exit.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.close(nowhere)
        raise


def _version(asked: bool) -> None:  # noqa: FBT001 (typer calls it with the option's value)
    """Print the version and leave."""
    if asked:
        from app.version import version_of  # noqa: PLC0415 (lazy, as all below)

        sys.stdout.write(f"knitlab {version_of('knitlab')}\n")
        raise typer.Exit


@knitlab.callback()
def _root(
    *,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Register the options that come before a command."""


@knitlab.command(
    short_help="Say what a protocol would do, without physics.",
    epilog="\b\nExample:\n  knitlab check examples/biaxial_cycle.yaml",
)
def check(protocol: ProtocolPath, *, chosen: Chosen = None, as_json: AsJson = False) -> None:
    """Say what a protocol would do: strokes, duration, rows, limits, arc-length budget. No physics.

    Of a sweep all points. Values that are taken by default are named. Every mistake in the protocol is a line on
    stderr, at most twenty; warnings (a limit passed, yarn used up) go there too and leave the exit code at 0.
    """
    from app.checks.dry_run import dry_run  # noqa: PLC0415
    from app.schemas import load, load_sweep  # noqa: PLC0415
    from app.views.plan_tables import plan_data, print_plan, print_points  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    loaded = load(protocol, values_of(chosen))
    if loaded.points:
        plans = {point.label: dry_run(one) for point, one in load_sweep(protocol, values_of(chosen))}
        if as_json:
            print_json({"points": {label: plan_data(plan) for label, plan in plans.items()}})
        else:
            print_points(plans)
    else:
        plans = {"": dry_run(loaded)}
        if as_json:
            print_json(plan_data(plans[""]))
        else:
            print_plan(plans[""])
    for label, plan in plans.items():
        warn(protocol, [f"{label}: {warning}" if label else warning for warning in plan.warnings])


@knitlab.command(
    short_help="Draw the knit of a protocol; its clearance and yarn length.",
    epilog="\b\nExample:\n  knitlab preview examples/biaxial_cycle.yaml --out pictures",
)
def preview(
    protocol: ProtocolPath,
    *,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the picture.", show_default="the current folder", file_okay=False)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Build the knit of a protocol: picture, clearance, yarn length, arc-length budget."""
    from app.checks.dry_run import build_specimen  # noqa: PLC0415
    from app.checks.specimen_facts import describe  # noqa: PLC0415
    from app.file_names import file_stem  # noqa: PLC0415
    from app.schemas import load  # noqa: PLC0415
    from app.views.renders import specimen_picture  # noqa: PLC0415
    from app.views.tables import print_facts, print_json, specimen_data  # noqa: PLC0415
    from rigs.machines.fixtures import clamped_nodes  # noqa: PLC0415
    from rigs.machines.pins import pins_on  # noqa: PLC0415

    loaded = load(protocol)
    specimen = build_specimen(loaded)
    folder = Path() if out is None else out
    folder.mkdir(parents=True, exist_ok=True)
    picture = folder / f"{file_stem(loaded.protocol.name)}_specimen.png"
    clamped = clamped_nodes(specimen, loaded.protocol.fixtures)
    specimen_picture(specimen, picture, clamped, pins_on(specimen, loaded.protocol.extensometer))
    facts = describe(specimen, loaded.protocol.fixtures, loaded.protocol.extensometer)
    if as_json:
        print_json({**specimen_data(loaded.protocol, facts), "picture": str(picture)})
    else:
        print_facts(loaded.protocol, facts)
        sys.stdout.write(f"picture: {picture}\n")


knitlab.command(
    short_help="Run a protocol into a run folder.",
    epilog="\b\nExamples:\n  knitlab run examples/biaxial_cycle.yaml --out runs/first\n"
    "  knitlab run examples/biaxial_small.yaml --quiet --json",
)(run)
knitlab.command(
    short_help="Go on with a run that was killed or interrupted.",
    epilog="\b\nExample:\n  knitlab resume runs/biaxial_cycle",
)(resume)


knitlab.command(short_help="Let lab software drive a rig: SCPI-like commands over TCP.", epilog=LIVE_HELP)(live)
knitlab.command(name="print", short_help="Check the knit for a 3D printer; write STL, 3MF, layers.", epilog=PRINT_HELP)(
    print_
)
knitlab.command(
    short_help="Run every point of a sweep, each into its folder.",
    epilog="\b\nExample:\n  knitlab sweep examples/fig3d/fig3d_course.yaml --out runs/fig3d --jobs 2",
)(sweep)
knitlab.command(short_help="Work out the figures of a run or a measured file.", epilog=ANALYSE_HELP)(analyse)
knitlab.command(
    short_help="Put the curves of several runs into one figure.",
    epilog="\b\nExample:\n  knitlab plot runs/course runs/wale runs/pile --out three_directions.png",
)(plot)
knitlab.command(short_help="Lay runs and measured files over each other.", epilog=COMPARE_HELP)(compare)
knitlab.command(short_help="Write the report of runs: one HTML file.", epilog=REPORT_HELP)(report)
knitlab.command(short_help="Fit parameters of a protocol to measured tests.", epilog=CALIBRATE_HELP)(calibrate)
knitlab.command(short_help="Look for parameters with which a test comes to what is wanted.", epilog=DESIGN_HELP)(design)
knitlab.command(
    name="master-curve",
    short_help="Ask whether knits of any design have one curve.",
    epilog="\b\nExample:\n  knitlab master-curve --points 32 --jobs 2",
)(master_curve)
knitlab.command(short_help="Score the claims of the paper from virtual tests.", epilog=SCOREBOARD_HELP)(scoreboard)
knitlab.command(short_help="Write a run's log as an instrument would.", epilog=EXPORT_HELP)(export)


@knitlab.command(
    short_help="List the materials, with the source of every number.",
    epilog="\b\nExamples:\n  knitlab materials\n  knitlab materials examples/materials/my-resins.yaml",
)
def materials(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="Materials of one's own (YAML).", show_default=False)
    ] = None,
    *,
    as_json: AsJson = False,
) -> None:
    """List the materials of the catalogue, and those of a file, with the source of every number."""
    from app.schemas.material_files import known_materials  # noqa: PLC0415
    from app.views.tables import materials_data, print_json, print_materials  # noqa: PLC0415

    known = known_materials(file)
    if as_json:
        print_json(materials_data(known))
    else:
        print_materials(known)


@knitlab.command(
    short_help="Print the JSON Schema of protocol or materials files.",
    epilog="\b\nExamples:\n  knitlab schema > protocol.schema.json\n"
    "  knitlab schema --kind material > material.schema.json",
)
def schema(
    *,
    kind: Annotated[
        Literal["protocol", "material"], typer.Option(help="Which kind of file: protocol or material.")
    ] = "protocol",
) -> None:
    """Print the JSON Schema of protocol or materials files, for editors that complete and check YAML."""
    from app import schemas  # noqa: PLC0415
    from app.schemas import materials as material_schemas  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    print_json(material_schemas.json_schema() if kind == "material" else schemas.json_schema())


knitlab.command(short_help=SHORT, epilog=EXAMPLE)(images)
