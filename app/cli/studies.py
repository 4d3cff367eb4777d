"""Commands of studies: many runs that answer one question."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.terminal import AsJson, complain

if TYPE_CHECKING:
    from app.studies.master_curve import Study


def master_curve(
    *,
    points: Annotated[int, typer.Option(help="Designs, 12 or more; 64 tell exponents within a tenth or so.")] = 32,
    out: Annotated[Path, typer.Option(help="Folder of the study.", file_okay=False)] = Path("runs/master_curve"),
    jobs: Annotated[int, typer.Option(help="Processes that run at once.")] = 1,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")] = False,
    as_json: AsJson = False,
) -> None:
    """Ask whether planar knits of any design have one curve: the paper's normalisation, and others beside it.

    Designs fill the ranges of loop width, the stitch's four numbers, fibre radius, fibres and Young's modulus. Each is
    a periodic cell that is pulled both ways to near its locking strain. Printed are the exponents of a power law, with
    intervals of 95 %, and how far curves lie apart under each scaling. Designs that are done are skipped.
    """
    from app.records.folder import write_whole  # noqa: PLC0415
    from app.studies.master_curve import run_study, table_of  # noqa: PLC0415
    from app.views.master_curves import master_curve_plot  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    with Bar(hidden=quiet) as bar:
        study = run_study(out, bar.show, points=points, jobs=jobs)
    table = write_whole(out / "master_curve.csv", [table_of(study).encode()])
    plot = master_curve_plot(study.designs, out / "master_curve.png")
    for one in study.missed:
        complain(one)
    if as_json:
        print_json({**study_data(study), "table": str(table), "plot": str(plot)})
        return
    _print(study)
    typer.echo(f"table: {table}\nplot: {plot}")


def study_data(study: Study) -> dict[str, object]:
    """Return a study as plain data."""
    laws = {
        str(axis): {
            "exponents": {one.name: {"value": one.value, "half_width_95": one.half_width} for one in law.exponents},
            "r_squared": law.r_squared,
            "left_out_error": law.left_out,
            "p_value": law.p_value,
            "designs": law.designs,
        }
        for axis, law in study.laws.items()
    }
    spreads = [
        {"scaling": one.name, "spread": one.spread, "first": one.first, "last": one.last, "curves": one.curves}
        for one in study.collapses
    ]
    return {"laws": laws, "collapses": spreads, "missed": list(study.missed)}


#: Exponents of stress that the paper's xi stands for: stress is proportional to 1 / xi.
_PAPER = {"E": 2.0, "r": 4.0, "n": 2.0, "d": -3.0, "a": -2.0, "h": 0.0, "w": 0.0, "l": 0.0}


def _print(study: Study) -> None:
    """Print exponents and spreads."""
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    console = Console()
    exponents = Table("parameter", "course", "wale", "the paper's ξ", title="exponents of stress, intervals of 95 %")
    for rows in zip(*(law.exponents for law in study.laws.values()), strict=True):
        found = [f"{one.value:.2f} ± {one.half_width:.2f}" for one in rows]
        exponents.add_row(rows[0].name, *found, f"{_PAPER[rows[0].name]:g}")
    for name, words in (("r_squared", "R²"), ("left_out", "error of ln stress, left out"), ("p_value", "p, permuted")):
        exponents.add_row(words, *(f"{getattr(law, name):.3g}" for law in study.laws.values()), "")
    console.print(exponents)
    spreads = Table("scaling", "spread of ln stress", "between", "curves", title="how far curves lie apart")
    for one in study.collapses:
        spreads.add_row(one.name, f"{one.spread:.3f}", f"{one.first:.2f} to {one.last:.2f}", str(one.curves))
    console.print(spreads)
