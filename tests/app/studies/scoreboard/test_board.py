"""The board as a whole: its rows, tests and folders, and what it writes."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from typer.testing import CliRunner

from app.cli.main import knitlab, main
from app.schemas import load
from app.studies.scoreboard.board import Board, Scored, make_board
from app.studies.scoreboard.page import page_of
from app.studies.scoreboard.plan import FULL, QUICK, all_tests
from app.studies.scoreboard.report import board_data, markdown_of
from app.studies.scoreboard.rows import ROWS
from app.studies.scoreboard.runs import folder_of, loaded_tests
from app.studies.scoreboard.verdict import judged

if TYPE_CHECKING:
    from app.studies.scoreboard.plan import Sizes

PROTOCOLS = Path(__file__).parents[4] / "examples" / "paper"


def test_there_is_a_row_for_each_of_the_26_claims() -> None:
    assert [row.number for row in ROWS] == list(range(1, 27))
    assert len({row.claim for row in ROWS}) == 26
    assert all(row.criterion and row.claim.paper for row in ROWS)


@pytest.mark.parametrize("sizes", [FULL, QUICK], ids=["full", "quick"])
def test_every_test_is_needed_and_every_need_is_met(sizes: Sizes) -> None:
    tests = all_tests(sizes)
    for row in ROWS:
        for need in row.tests:
            assert any(row.needs(name) for name in tests), need
            assert need.endswith("*") or need in tests, need
    assert all(any(row.needs(name) for row in ROWS) for name in tests)


def test_planar_rows_have_one_specimen_and_one_friction() -> None:
    tests = all_tests(FULL)
    planar = [name for name in tests if name.startswith(("fig3a", "fig3d", "uniaxial"))]
    loaded = loaded_tests(PROTOCOLS, [tests[name] for name in (*planar, "fig3c", "cotton", "hooks 0")])
    specimens = {repr(loaded[name].protocol.specimen) for name in planar}
    assert len(planar) == 13
    assert len(specimens) == 1
    assert {one.protocol.specimen.friction for one in loaded.values()} == {0.55}
    # The protocol with a number to change has the declared stitch unless one is changed.
    own, declared = (loaded[name].protocol.specimen.fabric for name in ("fig3c", "fig3a"))
    assert repr(own) == repr(declared)


def test_the_folder_of_a_test_follows_from_what_its_protocol_says(tmp_path: Path) -> None:
    path = tmp_path / "hooks.yaml"
    text = (PROTOCOLS / "hooks.yaml").read_text(encoding="utf-8")
    (tmp_path / "paper-fit-resin.yaml").write_bytes((PROTOCOLS / "materials" / "paper-fit-resin.yaml").read_bytes())

    def folder(said: str) -> Path:
        path.write_text(said.replace("materials/", ""), encoding="utf-8")
        return folder_of(tmp_path, "hooks 0", load(path))

    assert folder(text) == folder(f"# another comment\n{text}")
    assert folder(text) != folder(text.replace("to: 30 %", "to: 29 %"))
    assert re.fullmatch(r"hooks_0-[0-9a-f]{10}", folder(text).name)


def test_a_board_without_runs_says_what_is_missing(tmp_path: Path) -> None:
    board = make_board(PROTOCOLS, tmp_path, lambda _share, _text: None, numbers=[13, 26], run=False)
    assert [one.score.verdict for one in board.rows] == ["not scorable"] * 2
    assert board.rows[0].score.why == "not run: fig3d course 0, fig3d course 0.4"
    assert board.count("not scorable") == 2
    assert board.count("not scorable", fitted=True) == 1


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--row", "27"), "--row"),
        (("--jobs", "0"), "--jobs"),
        (("--protocols", "nowhere"), "--protocols"),
    ],
)
def test_mistakes_are_one_line(words: tuple[str, ...], says: str, tmp_path: Path) -> None:
    known = () if "--protocols" in words else ("--protocols", str(PROTOCOLS))
    said = CliRunner().invoke(knitlab, ["scoreboard", "--row", "26", *words, *known, "--out", str(tmp_path)])
    assert said.exit_code != 0
    assert says in str(said.exception) + said.output


def made_board() -> Board:
    """Return a board with a row of each verdict, one of them fitted."""
    found = ((1.0, "ours | with a bar"), (2.0, "ours <b>"), (float("nan"), "ours"))
    scores = [judged(value == 1.0, ours, {"x": value}, "because") for value, ours in found]
    rows = [ROWS[12], ROWS[15], ROWS[0]]
    scored = [
        Scored(row=row, score=score, command=f"knitlab scoreboard --row {row.number}", runs=("knitlab run x",))
        for row, score in zip(rows, scores, strict=True)
    ]
    return Board(rows=tuple(scored), runs={}, failed={"fig3a": "why not"}, quick=True)


def test_every_row_is_in_the_data_the_markdown_and_the_page() -> None:
    board = made_board()
    data = board_data(board)
    assert json.loads(json.dumps(data, allow_nan=False))["counts"] == {"reproduced": 1, "differs": 1, "not scorable": 1}
    assert data["rows"][2]["values"] == {"x": None}
    text, page = markdown_of(board), page_of(board)
    for one in board.rows:
        assert f"\n| {one.row.number} | {one.row.claim.words} (" in text
        assert f"<code>{one.command}</code>" in page
    assert "ours \\| with a bar" in text
    assert "reproduced (fitted)" in text
    assert "**16, dissipation of the wale" in text
    assert "ours &lt;b&gt;" in page
    assert "because" in page


def test_the_page_needs_no_network() -> None:
    page = page_of(made_board())
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!#)|@import|url\((?!#)""", page)


def scoreboard(monkeypatch: pytest.MonkeyPatch, out: Path, *words: str) -> int:
    given = ["knitlab", "scoreboard", "--protocols", PROTOCOLS, "--out", out, "--quiet", *words]
    monkeypatch.setattr(sys, "argv", [str(word) for word in given])
    with pytest.raises(SystemExit) as raised:
        main()
    return int(raised.value.code or 0)


def test_a_row_is_run_once_and_scored_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "board.md"
    assert scoreboard(monkeypatch, tmp_path, "--quick", "--row", "26", "--markdown", str(table)) == 0
    assert "1 reproduced" in capsys.readouterr().out
    assert "| 26 | hooks" in table.read_text(encoding="utf-8")
    assert not list(tmp_path.glob("*.html"))
    written = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("run.h5")}
    assert len(written) == 2
    assert scoreboard(monkeypatch, tmp_path, "--quick", "--row", "26", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["rows"][0]["verdict"] == "reproduced"
    assert len(found["rows"][0]["runs"]) == 2
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("run.h5")} == written


@pytest.mark.slow
def test_quick_mode_scores_every_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert scoreboard(monkeypatch, tmp_path, "--quick", "--jobs", "2", "--markdown", str(tmp_path / "board.md")) == 0
    board = make_board(PROTOCOLS, tmp_path, lambda _share, _text: None, quick=True, run=False)
    verdicts = {one.row.number: one.score.verdict for one in board.rows}
    assert board.count("not scorable") == 0
    # What no small specimen changes: order of axes, loops, sequence, contraction, topology, pile, constants, hooks.
    for number in (2, 3, 5, 6, 7, 18, 19, 21, 25, 26):
        assert verdicts[number] == "reproduced", number
    # Dimensional analysis: stress is proportional to the modulus.
    assert verdicts[11] == "differs"
    page = (tmp_path / "scoreboard-quick.html").read_text(encoding="utf-8")
    assert all(f"Fig. {name}" in page for name in ("3a", "3c", "3d", "4c", "4d", "5b"))
