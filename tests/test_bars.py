"""The table of bars, run on a small suite of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

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


def test_no_table_without_figures(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(CONFTEST.read_text(encoding="utf-8"))
    pytester.makepyfile("def test_nothing():\n    pass\n")
    result = pytester.runpytest_inprocess("-p", "no:xdist")
    result.stdout.no_fnmatch_line("*validation*")
