"""The table of bars: what a validation must reach, beside what it did reach.

A test asks for the fixture `bar` and calls it once per figure:

    bar("cantilever, PL²/EI = 1", figure=error, limit=0.005, unit="1", source="Bisshopp & Drucker 1945")

The row is kept before it is judged, so a missed bar is printed too. A bar that cannot be met is
marked ``xfail(reason="docs/decisions/...")``: it stays in the table as missed, with its reason.
``--bars FILE`` puts the rows into a file and a page, as `tests.bars` describes.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import pytest
from hypothesis import settings

from tests.bars import commit, record, stamped

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

PROPERTY = "knitlab-bar"

# At a desk properties are tried on new examples each time; where a commit is judged, on the same ones.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")


class Row(NamedTuple):
    """One line of the table."""

    name: str
    figure: float
    limit: float
    unit: str
    source: str

    @property
    def met(self) -> bool:
        """Whether |figure| <= limit; never for NaN."""
        return abs(self.figure) <= self.limit


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that keeps the table."""
    parser.addoption("--bars", type=Path, metavar="FILE", help="put the table of bars into this .json and its page")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Note the commit before the sources may change."""
    if session.config.getoption("--bars") is not None:
        commit()


@pytest.fixture
def bar(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Return a function that records one figure against its bar and fails the test when it misses."""

    def judge(name: str, figure: float, limit: float, unit: str, source: str) -> None:
        __tracebackhide__ = True
        row = Row(name, float(figure), float(limit), unit, source)
        # User properties travel from the workers of a parallel run.
        request.node.user_properties.append((PROPERTY, tuple(row)))
        if not row.met:
            pytest.fail(f"{name}: figure {row.figure:.4g} {unit}, bar {row.limit:.4g} {unit} ({source})")

    return judge


def ended(terminalreporter: pytest.TerminalReporter) -> Iterator[pytest.TestReport]:
    """Yield the reports of all tests that ran, in the order in which they ended."""
    for reports in terminalreporter.stats.values():
        yield from (one for one in reports if isinstance(one, pytest.TestReport) and one.when == "call")


def rows_of(report: pytest.TestReport) -> Iterator[Row]:
    """Yield the rows of a test."""
    yield from (Row(*cast("Any", entry)) for key, entry in report.user_properties if key == PROPERTY)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print bar and figure side by side; keep them where it is asked for."""
    reports = list(ended(terminalreporter))
    rows = sorted(row for report in reports for row in rows_of(report))
    if (path := config.getoption("--bars")) is not None:
        stamps = [(one.nodeid, getattr(one, "wasxfail", ""), row) for one in reports for row in rows_of(one)]
        record(path, {one.nodeid for one in reports}, [stamped(*each) for each in stamps])
    if not rows:
        return
    width = max(len(row.name) for row in rows)
    terminalreporter.section("validation")
    terminalreporter.write_line(f"{'test':{width}}  {'figure':>10}  {'bar':>10}  {'unit':6}  {'':6}  source")
    for row in rows:
        verdict = "met" if row.met else "MISSED"
        line = f"{row.name:{width}}  {row.figure:10.3g}  {row.limit:10.3g}  {row.unit:6}  {verdict:6}  {row.source}"
        terminalreporter.write_line(line, green=row.met, red=not row.met)
    terminalreporter.write_line(f"{sum(row.met for row in rows)} of {len(rows)} bars met")
