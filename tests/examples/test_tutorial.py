"""Files, commands and scripts of the tutorial and the how-tos, in their order, in an empty folder."""

from __future__ import annotations

import csv
import re
import shlex
import sys
from pathlib import Path

import pytest

from app.cli.main import main
from app.records.reader import read_run

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "tutorial.md").read_text(encoding="utf-8")
HOWTOS = sorted((DOCS / "howto").glob("*.md"))
BLOCK = re.compile(r"(?:`(?P<file>\w+\.yaml)`[^`]*)?```(?P<kind>\w*)\n(?P<text>.*?)```", re.DOTALL)


@pytest.mark.slow
def test_the_tutorial_does_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    follow(PAGE, monkeypatch)
    run = read_run(Path("first"))
    assert run.outcome.end == "target"
    assert run.strain("C").max() == pytest.approx(0.3)
    assert Path("first/first.csv").stat().st_size > 10_000
    assert Path("print/first.stl").exists()
    # What it says of friction: without it a knit unloads the way it came.
    with Path("friction/sweep.csv").open(encoding="utf-8") as table:
        points = {row["mu"]: row for row in csv.DictReader(table)}
    share = next(name for name in points["0.3"] if "loop area / work" in name and "C" in name)
    assert abs(float(points["0.0"][share])) < 0.01 * float(points["0.3"][share])


@pytest.mark.slow
@pytest.mark.parametrize("path", HOWTOS, ids=lambda path: path.stem)
def test_a_how_to_does_what_it_says(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(path.read_text(encoding="utf-8"), monkeypatch) > 0
    assert list(tmp_path.rglob("run.h5")) or list(tmp_path.rglob("*.stl"))


def follow(page: str, monkeypatch: pytest.MonkeyPatch) -> int:
    """Write the files of a page, give its commands and run its scripts; return how many there were of both."""
    done = 0
    for block in BLOCK.finditer(page):
        if block["kind"] == "yaml":
            Path(block["file"]).write_text(block["text"], encoding="utf-8")
        elif block["kind"] == "python":
            if "pyvista" in block["text"]:  # no part of knitlab, and it opens a window
                continue
            exec(compile(block["text"], "page", "exec"), {})  # noqa: S102 (our own page)
            done += 1
        elif not block["kind"]:
            for line in block["text"].splitlines():
                assert said(line, monkeypatch) == (2 if "# code 2" in line else 0), line
                done += 1
    return done


def said(line: str, monkeypatch: pytest.MonkeyPatch) -> int:
    """Return the exit code of a command of the page, run in this process, where imports cost but once."""
    monkeypatch.setattr(sys, "argv", shlex.split(line, comments=True))
    with pytest.raises(SystemExit) as raised:
        main()
    return int(raised.value.code or 0)
