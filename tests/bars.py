"""The table of bars as files: `docs/validation.json`, which runs add to, and the page that is made of it.

``pytest tests/validation --bars docs/validation.json`` replaces the rows of the tests that ran and keeps the others,
each with version, commit and date of its own. ``python -m tests.bars`` makes the page again without running anything.
"""

from __future__ import annotations

import ast
import json
import math
import subprocess
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.version import __version__

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

ROOT: Final = Path(__file__).parents[1]
FILE: Final = ROOT / "docs" / "validation.json"
CODE: Final = ("knitlab_core", "rigs", "tests/validation")
"""What figures follow from; the commit of a row is the last that changed any of it."""

HEAD: Final = """\
# Validation

What the model is held to: closed forms, published solutions, and laws that must hold whatever the knit. Each row is a
figure that a test of [`tests/validation`](../tests/validation) computed, beside the bar that it must stay under in
magnitude, and the bar's source. A row that misses its bar is kept in the table, with the decision that says why. Runs
write this page and [`validation.json`](validation.json), nobody by hand:

```
make validate                                        # all tests, slow ones too
pytest tests/validation --bars docs/validation.json  # the quick ones
```

A run replaces the rows of its own tests. *computed* is the version, the commit that last changed physics, rigs or
tests (`+`: with changes not committed), and the day.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class BarRow:
    """A figure beside its bar, and where it was computed.

    Attributes
    ----------
    test : str
        The test, as pytest names it.
    name, unit, source : str
        What the figure is, its unit, where the bar comes from.
    figure : float or None
        What was reached; None if it is no number.
    limit : float
        What its magnitude must not exceed.
    known : str
        Why a miss is expected; empty where none is.
    version, commit, date : str
        Of the code that computed it, and when.
    """

    test: str
    name: str
    figure: float | None
    limit: float
    unit: str
    source: str
    known: str = ""
    version: str = ""
    commit: str = ""
    date: str = ""

    @property
    def met(self) -> bool:
        """Whether the bar is met."""
        return self.figure is not None and abs(self.figure) <= self.limit


def stamped(test: str, known: str, values: Sequence[object]) -> BarRow:
    """Return a row of the run that is going on; `values` are name, figure, limit, unit and source."""
    name, figure, limit, unit, source = values
    number = float(str(figure))
    return BarRow(
        test=test,
        name=str(name),
        figure=float(f"{number:.4g}") if math.isfinite(number) else None,
        limit=float(str(limit)),
        unit=str(unit),
        source=str(source),
        known=known,
        version=__version__,
        commit=commit(),
        date=datetime.now(UTC).date().isoformat(),
    )


@lru_cache(maxsize=1)
def commit() -> str:
    """Return the commit that last changed what figures follow from, when first asked; empty outside a repository."""
    try:
        found = _git("log", "-1", "--format=%h")
        return f"{found}+" if found and _git("status", "--porcelain") else found
    except (OSError, subprocess.CalledProcessError):
        return ""


def _git(*words: str) -> str:
    asked = ["git", *words, "--", *CODE]
    return subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()  # noqa: S603


def read_rows(path: Path) -> list[BarRow]:
    """Return the rows of a file; none where there is none."""
    return [BarRow(**row) for row in json.loads(path.read_text(encoding="utf-8"))] if path.exists() else []


def record(path: Path, ran: Collection[str], rows: Iterable[BarRow], root: Path = ROOT) -> None:
    """Put the rows of the tests that ran into a file, in place of those they had; make the page beside it.

    Rows of tests that are no more are dropped.
    """
    kept = [row for row in read_rows(path) if row.test not in ran and _is_there(row.test, root)]
    every = sorted([*kept, *rows], key=lambda row: (row.test, row.name))
    lines = ",\n".join(json.dumps(asdict(row), ensure_ascii=False, allow_nan=False) for row in every)
    path.write_text(f"[\n{lines}\n]\n", encoding="utf-8")
    write_page(path, root)


def write_page(path: Path, root: Path = ROOT) -> None:
    """Write the page of a file of rows beside it."""
    rows = read_rows(path)
    path.with_suffix(".md").write_text(page_of(rows, root) + _left_out(rows, root), encoding="utf-8")


def page_of(rows: Sequence[BarRow], root: Path = ROOT) -> str:
    """Return rows as a page, a table for each file of tests."""
    met = sum(row.met for row in rows)
    parts = [HEAD, f"{met} of {len(rows)} bars are met.\n"]
    for file, here in groupby(rows, key=lambda row: row.test.partition("::")[0]):
        parts.append(f"## {_title(root / file)}\n\n[`{file}`](../{file})\n")
        parts.append("| what | figure | bar | unit | | source | computed |\n|---|---|---|---|---|---|---|")
        parts += [_line(row) for row in here]
        parts.append("")
    return "\n".join(parts)


def _line(row: BarRow) -> str:
    """Return a row of the page."""
    verdict = "met" if row.met else " ".join(["**missed**", _led(row.known)]).strip()
    figure = "none" if row.figure is None else f"{row.figure:.3g}"
    computed = ", ".join(part for part in (row.version, row.commit, row.date) if part)
    cells = (row.name, figure, f"{row.limit:.3g}", row.unit, verdict, row.source, computed)
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _led(reason: str) -> str:
    """Return why a miss is expected, with a link to the decision that it names."""
    place, colon, words = reason.partition(":")
    for page in sorted(ROOT.glob(f"{place}*.md")):
        return f"([{page.stem[:4]}](decisions/{page.name}){colon}{words})"
    return f"({reason})" if reason else ""


def _title(path: Path) -> str:
    """Return the first line of a file's docstring, or its name."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    doc = ast.get_docstring(ast.parse(text)) or path.stem
    return doc.splitlines()[0].rstrip(".:")


def _is_there(test: str, root: Path) -> bool:
    file, _, rest = test.partition("::")
    name = rest.partition("[")[0]
    return (root / file).exists() and f"def {name}(" in (root / file).read_text(encoding="utf-8")


def _left_out(rows: Sequence[BarRow], root: Path) -> str:
    """Return which tests with bars have no row."""
    had = {row.test.partition("[")[0] for row in rows}
    missing = [
        f"{path.relative_to(root).as_posix()}::{one.name}"
        for path in sorted(root.glob("tests/validation/test_*.py"))
        for one in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(one, ast.FunctionDef) and any(each.arg == "bar" for each in one.args.args)
    ]
    missing = [one for one in missing if one not in had]
    if not missing:
        return ""
    listed = "\n".join(f"- `{one}`" for one in missing)
    return f"\n## Not in the table\n\nThese tests have bars too, and were not run for this table yet:\n\n{listed}\n"


if __name__ == "__main__":
    write_page(FILE)
