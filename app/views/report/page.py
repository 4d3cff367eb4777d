"""The page of a report, and the files it is written to."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from app.file_names import file_stem
from app.records.folder import whole_file, write_whole
from app.records.reader import read_run
from app.version import __version__
from app.views.compare import compare_runs
from app.views.report.contents import contents_of
from app.views.report.drawings import inline_svg
from app.views.report.figures import result_rows, soundness_rows
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from markupsafe import Markup

    from app.records.reader import RunReader

MOST_RUNS: Final = 12
"""Runs of one report."""

TEMPLATE: Final = "page.html"


def report(sources: Sequence[Path | str], out: Path | str | None = None, *, pdf: bool = False) -> tuple[Path, ...]:
    """Write the report of one or several runs, side by side: one HTML file that needs no other.

    It holds the protocol, the specimen, curves, results, pictures along the test, energies, what was assumed, versions
    and checksums. All of it comes from the records.

    Parameters
    ----------
    sources : sequence of Path or str
        Run folders, or their ``run.h5``.
    out : Path, str or None
        Path of the file; None for one in the run folder, of several runs ``report.html`` here.
    pdf : bool
        Write the same as PDF beside it.

    Returns
    -------
    tuple of Path
        The HTML file, and the PDF if it was asked for.

    Raises
    ------
    FileNotFoundError, FormatError
        If a run has no record, or it is damaged or of another layout.
    SpecificationError
        For no run or too many, a file name that is not one of HTML, or a PDF without the library that writes it.
    """
    if not 1 <= len(sources) <= MOST_RUNS:
        raise SpecificationError("runs", len(sources), f"1 to {MOST_RUNS} runs")
    runs = [read_run(source) for source in sources]
    path = _default(runs) if out is None else Path(out)
    if path.suffix.lower() not in {".html", ".htm"}:
        raise SpecificationError("--out", path.name, "a name that ends in .html")
    if pdf:
        _require_pdf()
    text = report_page(runs)
    written = [write_whole(path, [text.encode()])]
    if pdf:
        written.append(_write_pdf(text, path.with_suffix(".pdf")))
    return tuple(written)


def report_page(runs: Sequence[RunReader]) -> str:
    """Return the report of some runs as an HTML page; texts of users stay text."""
    titles = titles_of(runs)
    told = [contents_of(run, title, number) for number, (run, title) in enumerate(zip(runs, titles, strict=True), 1)]
    page = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, undefined=StrictUndefined
    ).get_template(TEMPLATE)
    return page.render(
        title=" · ".join(titles),
        runs=told,
        overlay=_overlay(runs),
        results=result_rows(runs),
        soundness=soundness_rows(runs),
        version=__version__,
    )


def _default(runs: Sequence[RunReader]) -> Path:
    if len(runs) > 1:
        return Path("report.html")
    (run,) = runs
    return run.path.with_name(f"{file_stem(str(run.provenance.get('name', run.path.parent.name)))}_report.html")


def titles_of(runs: Sequence[RunReader]) -> list[str]:
    """Return the names of runs; those of one name are told apart by their folders, then by numbers."""
    names = [str(run.provenance.get("name", run.path.parent.name)) for run in runs]
    for number in (1, 2):
        same = [names.count(name) > 1 for name in names]
        parts = [run.path.parent.name if number == 1 else str(k) for k, run in enumerate(runs, 1)]
        names = [f"{name} ({part})" if double else name for name, part, double in zip(names, parts, same, strict=True)]
    return names


def _overlay(runs: Sequence[RunReader]) -> Markup | None:
    """Return the curves of all runs in one plot; None of a single one."""
    drawn = [run.path for run in runs if len(run.trace)]
    if len(drawn) < 2:
        return None
    return inline_svg(lambda path: compare_runs(drawn, path), "curves of all runs", "all")


def _require_pdf() -> None:
    """Raise unless the library that writes PDF is there."""
    try:
        import weasyprint  # noqa: F401, PLC0415 (optional)
    except ImportError as error:
        raise SpecificationError("--pdf", "no WeasyPrint", "pip install 'knitlab[pdf]', or print the page") from error
    except OSError as error:
        raise SpecificationError("--pdf", "no Pango, which WeasyPrint needs", "Pango, or print the page") from error


def _write_pdf(text: str, path: Path) -> Path:
    """Write a page as PDF, atomically; nothing is fetched for it."""
    from weasyprint import HTML  # noqa: PLC0415 (optional)

    with whole_file(path) as temporary:
        HTML(string=text).write_pdf(temporary)
    return path
