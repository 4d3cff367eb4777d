"""The report of runs: whole, without anything from elsewhere, and with texts of users as text."""

from __future__ import annotations

import hashlib
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser
from typing import TYPE_CHECKING

import pytest

from app.records.seal import seal
from app.views.report.assumed import assumed_numbers, mesh_label
from app.views.report.drawings import inline_svg
from app.views.report.figures import result_rows
from app.views.report.page import report, titles_of
from knitlab_core.errors import FormatError, SpecificationError
from tests.synthetic_run import PROTOCOL, SIZE, make_run, stress

if TYPE_CHECKING:
    from pathlib import Path

    from app.records.reader import RunReader

EVIL = "</pre><script>alert('1')</script><img src=http://example.org/x.png onerror=alert(2)>"
SMALL = f"# {EVIL}\n" + PROTOCOL.replace("[6, 6]", "[2, 2]")


class Page(HTMLParser):
    """Tags of a page, their attributes, and all its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.names: list[str] = []
        self.links: list[str] = []
        self.handlers: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name == "id":
                self.names.append(value or "")
            if name in {"src", "href", "xlink:href"}:
                self.links.append(value or "")
            if name.startswith("on"):
                self.handlers.append(name)

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunReader]:
    """Make two runs of one name: one whole, the other cut off before its first row."""
    whole, cut = (tmp_path_factory.mktemp(name) for name in ("whole", "cut"))
    return [
        make_run(whole / "run.h5", protocol=SMALL, sampled=False),
        make_run(cut / "run.h5", [], protocol=SMALL, sampled=False),
    ]


@pytest.fixture(scope="module")
def page(runs: list[RunReader]) -> Page:
    out = runs[0].path.with_name("synthetic_report.html")
    assert report([runs[0].path.parent]) == (out,)
    return Page(out.read_text(encoding="utf-8"))


def test_a_report_needs_nothing_from_elsewhere(page: Page) -> None:
    assert page.links
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in page.links)
    assert not {"script", "link", "iframe", "object"} & set(page.tags)
    assert page.handlers == []
    # Names are told apart, or one plot would use the clips and marks of another.
    assert len(page.names) == len(set(page.names)) > 0
    assert {link[1:] for link in page.links if link.startswith("#")} <= set(page.names)


def test_texts_of_users_stay_text(page: Page) -> None:
    assert page.text.count(SMALL) == 1
    # Pictures of the specimen and of its shapes, and no other image.
    assert page.tags.count("img") == 2
    assert page.tags.count("pre") == 1


def test_a_report_holds_all_that_there_is_to_know(page: Page, runs: list[RunReader]) -> None:
    assert page.tags.count("svg") == 2
    assert "cut short: the run is going on, or was killed" in page.text
    for words in ("48 nodes per loop (default)", "Taken by default", "beyond elastic"):
        assert words in page.text
    assert hashlib.sha256(runs[0].path.read_bytes()).hexdigest() in page.text
    assert hashlib.sha256(SMALL.encode()).hexdigest() in page.text


def test_figures_of_runs_are_side_by_side_in_one_unit(runs: list[RunReader]) -> None:
    rows = {(row.axis, row.cycle, row.figure): row for row in result_rows(runs)}
    force = rows["C", "whole test", "Maximum force"]
    assert float(force.values[0]) * {"N": 1.0, "mN": 1e-3}[force.unit] == pytest.approx(
        stress(0.4, 1, "Stretch", "C") * SIZE.section("C"), rel=1e-3
    )
    assert force.values[1] == ""
    axes = [row.axis for row in result_rows(runs)]
    assert axes == sorted(axes, key=["C", "W", "all"].index)


def test_assumed_numbers_are_told_with_their_reason() -> None:
    found = list(
        assumed_numbers(
            {
                "yield": "off",
                "friction": 0.3,
                "friction.source": "1; not published; assumed",
                "material.strength": 29e6,
                "material.strength.source": "Pa; low end; quoted; assumed",
                "material.young_modulus": 820e6,
                "material.young_modulus.source": "Pa; the paper",
                "material.yield_curve[0].strain": 0.01,
                "material.yield_curve[0].strain.source": "1; rounded; assumed",
            }
        )
    )
    assert [(one.name, one.value, one.source) for one in found] == [
        ("friction", "0.3", "not published"),
        ("material.strength", "29 MPa", "low end; quoted"),
    ]


def test_a_mesh_that_is_coarser_than_any_known_promises_nothing(runs: list[RunReader]) -> None:
    spec = runs[0].test.specimen
    assert "err by more than 3 %" in mesh_label(replace(spec, nodes_per_loop=16))
    assert "err by at most 3 %" in mesh_label(replace(spec, nodes_per_loop=40))


def test_a_damaged_run_and_too_many_are_refused_in_one_line(runs: list[RunReader], tmp_path: Path) -> None:
    copy = tmp_path / "run.h5"
    shutil.copy(runs[0].path, copy)
    seal(copy)
    content = bytearray(copy.read_bytes())
    content[len(content) // 2] ^= 1
    copy.write_bytes(content)
    with pytest.raises(FormatError, match=re.escape("run.h5")) as refused:
        report([copy], tmp_path / "report.html")
    assert "\n" not in str(refused.value)
    copy.write_text("no record")
    with pytest.raises(FormatError):
        report([copy], tmp_path / "report.html")
    with pytest.raises(FileNotFoundError):
        report([tmp_path / "none"], tmp_path / "report.html")
    for sources, name in ((([runs[0].path] * 13), "report.html"), ([], "report.html"), ([runs[0].path], "report.docx")):
        with pytest.raises(SpecificationError):
            report(sources, tmp_path / name)
    assert list(tmp_path.iterdir()) == [copy]


def test_labels_of_plots_are_escaped() -> None:
    def draw(path: Path) -> None:
        path.write_text('<?xml version="1.0"?>\n<!-- x --><svg width="3" height="4" id="a"><use href="#a"/></svg>')

    found = inline_svg(draw, '"><script>', "n")
    assert found == ('<svg role="img" aria-label="&#34;&gt;&lt;script&gt;" id="n-a"><use href="#n-a"/></svg>')


def test_runs_of_one_name_are_told_apart(runs: list[RunReader]) -> None:
    assert [title.rstrip("0123456789)") for title in titles_of(runs)] == ["synthetic (whole", "synthetic (cut"]
    assert titles_of([runs[0], runs[0]])[1].endswith("(2)")


@pytest.mark.slow
def test_a_run_without_rows_beside_a_whole_one_on_screen_and_as_pdf(runs: list[RunReader], tmp_path: Path) -> None:
    try:
        import weasyprint  # noqa: F401, PLC0415 (needs a library of the system)
    except OSError:
        pytest.skip("no Pango is installed")
    html, pdf = report([run.path for run in runs], tmp_path / "report.html", pdf=True)
    page = Page(html.read_text(encoding="utf-8"))
    assert page.text.count("No row was recorded.") == 1
    assert page.text.count(SMALL) == 2
    assert len(page.names) == len(set(page.names))
    assert pdf.name == "report.pdf"
    assert pdf.read_bytes().startswith(b"%PDF-")
