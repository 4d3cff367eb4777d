"""The table of bars, run on a small suite of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bars import FILE, commit, page_of, read_rows, record, stamped

CONFTEST = Path(__file__).parents[0] / "conftest.py"
SUITE = """
import pytest

def test_good(bar):
    bar("good", figure=-0.001, limit=0.005, unit="1", source="a book")

def test_poor(bar):
    bar("poor", figure=0.2, limit=0.1, unit="N", source="another book")

def test_nan(bar):
    bar("nan", figure=float("nan"), limit=0.1, unit="1", source="nowhere")

@pytest.mark.xfail(reason="docs/decisions/0009", strict=True)
def test_known(bar):
    bar("known", figure=3, limit=2, unit="1", source="a paper")
"""


@pytest.mark.parametrize("options", [["-p", "no:xdist"], ["-n", "1"]], ids=["one process", "workers"])
def test_table_shows_every_figure_beside_its_bar(pytester: pytest.Pytester, options: list[str]) -> None:
    pytester.makeconftest(CONFTEST.read_text(encoding="utf-8"))
    pytester.makepyfile(SUITE)
    result = pytester.runpytest_inprocess(*options)
    result.assert_outcomes(passed=1, failed=2, xfailed=1)
    result.stdout.fnmatch_lines(
        [
            "*= validation =*",
            "test * figure * bar *",
            "good * -0.001 * 0.005 * met * a book",
            "known * 3 * 2 * MISSED * a paper",
            "nan * nan * 0.1 * MISSED * nowhere",
            "poor * 0.2 * 0.1 * N * MISSED * another book",
            "1 of 4 bars met",
        ]
    )


def test_rows_are_kept_by_test_with_what_they_were_computed_by(tmp_path: Path) -> None:
    (tmp_path / "tests" / "validation").mkdir(parents=True)
    suite = tmp_path / "tests" / "validation" / "test_beams.py"
    suite.write_text('"""Beams.\n\nMore."""\ndef test_a(bar): ...\ndef test_b(bar): ...\ndef test_new(bar): ...\n')
    file, name = tmp_path / "kept.json", "tests/validation/test_beams.py::test_"
    first = [stamped(f"{name}{one}", "", (f"bend {one}", 0.5, 1.0, "N", "a | b")) for one in ("a", "b", "gone")]
    record(file, {row.test for row in first}, first, tmp_path)
    assert [row.test for row in read_rows(file)] == [f"{name}{one}" for one in ("a", "b", "gone")]
    assert {row.commit for row in first} == {commit()}
    # The second run has other figures of b, and a is not run; there is no test of the last name any more.
    again = [stamped(f"{name}b", "docs/decisions/0002: it grows", ("bend b", float("nan"), 1.0, "N", "c"))]
    record(file, {f"{name}b"}, again, tmp_path)
    assert [(row.name, row.figure, row.met) for row in read_rows(file)] == [
        ("bend a", 0.5, True),
        ("bend b", None, False),
    ]
    page = file.with_suffix(".md").read_text(encoding="utf-8")
    assert "1 of 2 bars are met" in page
    assert "## Beams\n" in page
    assert r"| bend a | 0.5 | 1 | N | met | a \| b | " in page
    assert "| bend b | none | 1 | N | **missed** ([0002](decisions/0002-contact-law.md): it grows) | c | " in page
    assert page.endswith("- `tests/validation/test_beams.py::test_new`\n")


def test_a_run_writes_its_rows(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(CONFTEST.read_text(encoding="utf-8"))
    pytester.makepyfile(SUITE)
    pytester.runpytest_inprocess("-p", "no:xdist", "--bars", "out.json")
    assert {(row.name, row.figure) for row in read_rows(pytester.path / "out.json")} == {
        ("good", -0.001),
        ("poor", 0.2),
        ("nan", None),
        ("known", 3.0),
    }


def test_the_page_of_the_documentation_is_that_of_its_rows() -> None:
    page = FILE.with_suffix(".md").read_text(encoding="utf-8")
    wanted = page_of(read_rows(FILE)).splitlines()
    lines = [line for line in wanted if line.startswith("| ") or line.endswith("bars are met.")]
    assert len(lines) > 200
    assert set(lines) <= set(page.splitlines()), "`python -m tests.bars` writes it"


def test_no_table_without_figures(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(CONFTEST.read_text(encoding="utf-8"))
    pytester.makepyfile("def test_nothing():\n    pass\n")
    result = pytester.runpytest_inprocess("-p", "no:xdist")
    result.stdout.no_fnmatch_line("*validation*")
