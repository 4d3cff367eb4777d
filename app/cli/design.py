"""The command `knitlab design`."""

from __future__ import annotations

import sys
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from app.cli.exit_codes import INTERRUPTED, NOT_PRINTABLE
from app.cli.terminal import AsJson, complain

if TYPE_CHECKING:
    from app.studies.design import Design

DESIGN_HELP: Final = """\b
Example:
  knitlab design examples/design/secant.yaml --jobs 2"""


def design(
    file: Annotated[Path, typer.Argument(metavar="DESIGN", help="Design file (YAML).", show_default=False)],
    *,
    out: Annotated[Path, typer.Option(help="Folder of runs, table and figure.", file_okay=False)] = Path("runs/design"),
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 1,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Look for parameters with which a test comes to a wanted secant, loop area or curve; prove them by a last test.

    Tests that fill the ranges make a surrogate, which proposes further ones until one is near enough. What cannot be
    knitted or printed is left out; exit code 6: the last knit is not printable. Runs are kept: the same command again
    goes on where it was. Needs the extra: pip install 'knitlab[design]'.
    """
    from app.studies.design import design as designed  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    try:
        with Bar(hidden=quiet) as bar:
            found = designed(file, out, bar.show, jobs=jobs)
    except KeyboardInterrupt:
        complain(f"{file}: interrupted; the same command goes on with the runs in {out}")
        raise typer.Exit(INTERRUPTED) from None
    if as_json:
        print_json(design_data(found))
    else:
        _print(found)
    for line in found.notes:
        complain(f"{file}: WARNING: {line}")
    raise typer.Exit(0 if all(check.met for check in found.checks) else NOT_PRINTABLE)


def design_data(found: Design) -> dict[str, Any]:
    """Return a design as plain data; what is not known is null."""
    return {
        "values": dict(found.values),
        "target": {name: _known(value) for name, value in asdict(found.outcome).items()} | {"met": found.outcome.met},
        "checks": [
            {name: _known(value) for name, value in asdict(one).items()} | {"met": one.met} for one in found.checks
        ],
        "tests": len(found.trials),
        "runs": found.runs,
        "reused": found.reused,
        "folder": str(found.folder),
        "notes": list(found.notes),
        "files": [str(path) for path in found.files],
    }


def _known(value: Any) -> Any:  # noqa: ANN401 (a text or a number)
    return None if isinstance(value, float) and not isfinite(value) else value


def _print(found: Design) -> None:
    """Print the values, target beside expected and reached, and the checks for the printer."""
    from rich.table import Table  # noqa: PLC0415

    from app.views.curves import prefixed  # noqa: PLC0415
    from app.views.tables import console_of  # noqa: PLC0415

    one = found.outcome
    factor, letter = (1.0, "") if one.unit == "1" else prefixed(one.wanted)
    values = ", ".join(f"{name}: {value}" for name, value in found.values.items())
    table = Table("figure", "wanted", "predicted", "95 % interval", "reached", "unit")
    table.add_row(
        one.name,
        f"{factor * one.wanted:.4g}",
        f"{factor * one.predicted:.4g}",
        f"{factor * one.low:.4g} to {factor * one.high:.4g}",
        f"{factor * one.reached:.4g}" if isfinite(one.reached) else "-",
        f"{letter}{one.unit}",
    )
    console_of().print(f"values: {values}", soft_wrap=True)
    console_of().print(table, soft_wrap=True)
    if found.checks:
        checks = Table("check for the printer", "found", "allowed", "")
        for check in found.checks:
            ends = [
                f"{check.least:.4g}" if isfinite(check.least) else "",
                f"{check.most:.4g}" if isfinite(check.most) else "",
            ]
            allowed = f"{ends[0]} to {ends[1]}" if all(ends) else f"≥ {ends[0]}" if ends[0] else f"≤ {ends[1]}"
            unit = "" if check.unit == "1" else f" {check.unit}"
            checks.add_row(
                check.name, f"{check.found:.4g}{unit}", f"{allowed}{unit}", "met" if check.met else "NOT MET"
            )
        console_of().print(checks)
    sys.stdout.write(f"tests: {found.runs}, {found.reused} of them done before\nfinal test: {found.folder}\n")
    for label, path in zip(("table", "plot"), found.files, strict=True):
        sys.stdout.write(f"{label}: {path}\n")
