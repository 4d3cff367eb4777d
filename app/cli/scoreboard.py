"""The command `knitlab scoreboard`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from app.cli.exit_codes import INTERRUPTED
from app.cli.terminal import AsJson, complain

if TYPE_CHECKING:
    from app.studies.scoreboard.board import Board

SCOREBOARD_HELP: Final = """\b
Examples:
  knitlab scoreboard --quick --jobs 2
  knitlab scoreboard --jobs 2 --markdown docs/scoreboard.md
  knitlab scoreboard --row 13 --row 14 --json"""

COLOURS: Final = {"reproduced": "green", "differs": "yellow", "not scorable": "dim"}


def scoreboard(
    *,
    quick: Annotated[
        bool, typer.Option("--quick", help="Small specimens and coarse meshes: some minutes instead of half an hour.")
    ] = False,
    row: Annotated[list[int] | None, typer.Option(help="Only this row; may be repeated.")] = None,
    out: Annotated[Path, typer.Option(help="Folder of the runs and of the page.", file_okay=False)] = Path(
        "runs/scoreboard"
    ),
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 1,
    protocols: Annotated[Path, typer.Option(help="Folder of the paper's protocols.", file_okay=False)] = Path(
        "examples/paper"
    ),
    no_runs: Annotated[bool, typer.Option("--no-runs", help="Score from the runs that are there.")] = False,
    markdown: Annotated[Path | None, typer.Option(help="File for the table in Markdown.", dir_okay=False)] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Score the claims of the paper from virtual tests: claim, paper, ours, verdict, and the command that repeats it.

    Each test has a folder of its own, found again by a checksum of its protocol: what is done is not run again, and
    the same command goes on where it was stopped. A page with the redrawn figures is written beside the runs, where all
    rows are scored. Rows that differ leave the exit code at 0: that is a result.
    """
    from app.records.folder import write_whole  # noqa: PLC0415
    from app.studies.scoreboard.board import make_board  # noqa: PLC0415
    from app.studies.scoreboard.page import page_of  # noqa: PLC0415
    from app.studies.scoreboard.report import board_data, markdown_of  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    try:
        with Bar(hidden=quiet) as bar:
            board = make_board(protocols, out, bar.show, quick=quick, numbers=row or (), jobs=jobs, run=not no_runs)
    except KeyboardInterrupt:
        complain(f"{out}: interrupted; the same command goes on with the runs that are there")
        raise typer.Exit(INTERRUPTED) from None
    # A page of some rows alone would take the place of the whole one.
    page = None if row else write_whole(out / f"scoreboard{'-quick' * quick}.html", [page_of(board).encode()])
    if markdown is not None:
        write_whole(markdown, [markdown_of(board).encode()])
    if as_json:
        print_json({**board_data(board), "page": None if page is None else str(page)})
        return
    _print(board)
    if page is not None:
        sys.stdout.write(f"page: {page}\n")


def _print(board: Board) -> None:
    """Print the rows and how many have each verdict."""
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    from app.studies.scoreboard.report import counts_said, sizes_said  # noqa: PLC0415
    from app.views.tables import console_of  # noqa: PLC0415

    table = Table("#", title="the paper's claims", show_lines=True, expand=True)
    for name, ratio in (("claim", 3), ("paper", 2), ("ours, and the command that repeats it", 5)):
        table.add_column(name, ratio=ratio)
    table.add_column("verdict", no_wrap=True)
    for one in board.rows:
        verdict, score = one.score.verdict, one.score
        words = f"{verdict}\n(fitted)" if one.row.fitted and verdict == "reproduced" else verdict
        ours = "\n".join(filter(None, (score.ours, score.why, one.command)))
        claim = f"{one.row.claim.words} ({one.row.claim.where})"
        cells = (str(one.row.number), claim, one.row.claim.paper, ours)
        table.add_row(*map(Text, cells), Text(words, style=COLOURS[verdict]))
    console_of().print(table)
    sys.stdout.write(f"{counts_said(board)}\n{sizes_said(board)}\n")
