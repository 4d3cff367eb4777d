"""Commands that run a protocol, and resume a run that was killed."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 (typer reads it)
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from app.cli.clock import BEGAN
from app.cli.exit_codes import exit_code
from app.cli.terminal import AsJson, Chosen, ProtocolPath, complain, values_of, warn

if TYPE_CHECKING:
    from app.runs.use_cases import RunResult


Pictures = Annotated[
    bool, typer.Option("--pictures/--no-pictures", help="Draw the curves and the knit.", show_default=False)
]


def run(
    protocol: ProtocolPath,
    *,
    out: Annotated[
        Path | None,
        typer.Option(help="Run folder to write.", show_default="a new one under runs/", file_okay=False),
    ] = None,
    chosen: Chosen = None,
    pictures: Pictures = True,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Run a protocol: run.h5, the stage's CSV, plots and pictures, in a run folder.

    Ctrl-C keeps what was recorded, and `knitlab resume` goes on.
    """
    from app.views.drawing import drawer  # noqa: PLC0415

    # What draws takes about as long to import as what computes, so it begins first.
    with drawer(wanted=pictures) as draw:
        from app.checks.dry_run import dry_run  # noqa: PLC0415
        from app.cli.tables import print_result, result_data  # noqa: PLC0415
        from app.runs.use_cases import run_protocol  # noqa: PLC0415
        from app.schemas import load  # noqa: PLC0415
        from app.views.progress_bar import Bar  # noqa: PLC0415
        from app.views.tables import print_json  # noqa: PLC0415

        loaded = load(protocol, values_of(chosen)).one_test()
        warn(protocol, dry_run(loaded).warnings)
        with Bar(hidden=quiet, began=BEGAN) as bar:
            result = run_protocol(loaded, out, bar.show, draw=draw, began=BEGAN)
    if as_json:
        print_json(result_data(result))
    else:
        print_result(result)
    _end(str(protocol), result)


def resume(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run folder, or its run.h5.", show_default=False)],
    *,
    pictures: Pictures = True,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Go on with a run that was killed or interrupted, from its last checkpoint to the rows it would have had.

    A run that has ended is left as it is.
    """
    from app.cli.tables import print_result, result_data  # noqa: PLC0415
    from app.runs.use_cases import has_ended, resume_run  # noqa: PLC0415
    from app.views.drawing import drawer  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    ended = has_ended(run)
    if ended is not None:
        complain(f"{run}: has ended already: {ended.end}{': ' if ended.message else ''}{ended.message}")
        raise typer.Exit
    with Bar(hidden=quiet, began=BEGAN) as bar, drawer(wanted=pictures) as draw:
        result = resume_run(run, bar.show, draw=draw, began=BEGAN)
    if as_json:
        print_json(result_data(result))
    else:
        print_result(result)
    _end(str(run), result)


def _end(name: str, result: RunResult) -> NoReturn:
    """Report an outcome other than `target`, and exit with the run's code."""
    hint = f"; go on with: knitlab resume {result.folder}" if result.outcome == "abort" else ""
    if result.outcome != "target":
        complain(f"{name}: {result.outcome}: {result.message}{hint}")
    raise typer.Exit(exit_code(result))
