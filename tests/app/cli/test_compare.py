from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest
from PIL import Image

from app.cli.main import main
from app.records.export import export_log
from app.records.reader import read_run
from tests.synthetic_run import make_run

if TYPE_CHECKING:
    from collections.abc import Callable

MEASURED = Path(__file__).parents[3] / "examples" / "fabric" / "measured"
COURSE = (MEASURED / "course.csv",)


class Said(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def say(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    def command(*words: object) -> Said:
        monkeypatch.setattr(sys, "argv", ["knitlab", *map(str, words)])
        with pytest.raises(SystemExit) as raised:
            main()
        return Said(int(raised.value.code or 0), *capsys.readouterr())

    return command


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    make_run(folder / "run.h5")
    return folder


def scores(text: str) -> dict[tuple[str, str, str], float]:
    found = json.loads(text)
    assert found["table"] == "comparison"
    return {(row[0], row[1], row[3]): row[4] for row in found["rows"]}


def test_repeats_of_a_file_are_a_band(say: Callable[..., Said], tmp_path: Path) -> None:
    said = say("compare", *COURSE, "--leave-out", 1, "--out", tmp_path / "band.png", "--json")
    assert (said.code, said.err) == (0, "")
    found = scores(said.out)
    assert found["course.csv", "C", "Repeats"] == 4
    # Between the published forces per width at 20 %, 0.062 and 0.081 N/mm, over 1 mm and 20 %.
    assert 0.062e6 / 0.2 < found["course.csv", "C", "Modulus (secant 0 % - 20 %)"] < 0.081e6 / 0.2
    with Image.open(tmp_path / "band.png") as picture:
        assert len(picture.convert("L").getcolors() or ()) > 20


def test_a_run_lies_on_its_own_log(say: Callable[..., Said], run: Path, tmp_path: Path) -> None:
    log = export_log(read_run(run), tmp_path, "biotester", locale="de", units={"force": "N"})
    said = say("compare", run, log, "--cycle", 2, "--axis", "W", "--out", tmp_path / "own.png", "--json")
    assert (said.code, said.err) == (0, "")
    found = scores(said.out)
    assert found["synthetic", "W", "NRMSE"] < 0.005
    loops = [found[name, "W", "Loop area"] for name in ("synthetic", log.name)]
    assert loops[0] == pytest.approx(loops[1], rel=0.02)


def test_the_table_goes_to_a_file_too(say: Callable[..., Said], run: Path, tmp_path: Path) -> None:
    path = tmp_path / "scores.csv"
    said = say("compare", run, *COURSE, "--axis", "C", "--slack", "10 mN", "--out", tmp_path / "a.png", "--table", path)
    assert said.code == 0
    assert f"plot: {tmp_path / 'a.png'}" in said.out
    rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    assert rows[0][:4] == ["name", "axis", "cycle", "figure"]
    assert {row[0] for row in rows[1:]} == {"synthetic", "course.csv"}
    slack = {row[0]: float(row[4]) for row in rows if row[3] == "Slack taken off"}
    assert slack["synthetic"] > 0.0


FAULTS = [
    (("compare", *COURSE, "--cycle", 2), "--cycle: found 2, allowed 1 to 1, the cycles of course, repeat 1"),
    (("compare", *COURSE, "--leave-out", 1, "--leave-out", 2, "--axis", "P"), "--axis: found 'P', allowed one of C"),
    (("compare", *COURSE, "--slack", "1 kN"), "--slack: found '29.38 N at most in course, repeat 1'"),
    (("compare", *COURSE, "--width", "-3 mm"), "--width: found '-3 mm', allowed a length above 0 m"),
    (("analyse", *COURSE, "--table", "energy"), "--table: found 'energy', allowed one of results"),
    (("analyse", *COURSE, "--window", "5%"), "--window: found '5%', allowed two strains"),
    (("analyse", *COURSE, "--fit", "0.4:0.1"), "--fit: found '0.4:0.1', allowed two strains that rise"),
    (("analyse", "nothing.csv"), "nothing.csv: no such file or directory"),
]


@pytest.mark.parametrize(("words", "error"), FAULTS)
def test_a_mistake_is_one_line(
    say: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[object, ...], error: str
) -> None:
    monkeypatch.chdir(tmp_path)
    said = say(*words)
    assert said.code == 2
    assert error in said.err
    assert said.err.count("\n") == 1


def test_a_file_without_an_axis_needs_one_beside_two(say: Callable[..., Said], run: Path, tmp_path: Path) -> None:
    copy = tmp_path / "course.csv"
    copy.write_bytes(COURSE[0].read_bytes())
    said = say("compare", run, copy, "--width", "66.56mm", "--out", tmp_path / "a.png")
    assert said.code == 2
    assert "--axis: found 'none', allowed that of course.csv: one of C, W" in said.err
    # A protocol of that name is no mapping; a mapping elsewhere is told.
    (tmp_path / "course.yaml").write_text("schema: knitlab/protocol@1\n", encoding="utf-8")
    said = say("compare", run, copy, "--mapping", MEASURED / "course.yaml", "--out", tmp_path / "a.png", "--json")
    assert said.code == 0
    assert scores(said.out)["course.csv", "C", "Repeats"] == 5


def test_analyse_prints_specimens_side_by_side(say: Callable[..., Said]) -> None:
    said = say("analyse", *COURSE, "--window", "0:5%")
    assert said.code == 0
    assert "repeat 5" in said.out
    assert "deviation" in said.out
    assert "Modulus (segment 0 % - 5 %)" in said.out
    wide = say("analyse", *COURSE, "--table", "fits").out
    assert "weight of exponential [1]" in wide
    assert len(wide.splitlines()) > 15


def test_tables_of_a_run_are_printed_and_written(say: Callable[..., Said], run: Path, tmp_path: Path) -> None:
    said = say("analyse", run, "--table", "energy", "--json")
    data = json.loads(said.out)
    assert data["table"] == "energy"
    assert None in data["rows"][0]
    path = tmp_path / "contacts.csv"
    assert say("analyse", run, "--table", "contacts", "--out", path).out == f"table: {path}\n"
    assert len(path.read_text(encoding="utf-8").splitlines()) == len(data["rows"]) + 1
    assert "and " in say("analyse", run, "--table", "contacts").out


def test_help_names_every_table(say: Callable[..., Said]) -> None:
    from app.records.analysis import OF_CURVES, OF_RUNS  # noqa: PLC0415

    told = say("analyse", "--help").out
    for name in (*OF_CURVES, *OF_RUNS):
        assert f"  {name} " in told


def test_files_may_be_repeats_of_one_test(say: Callable[..., Said], tmp_path: Path) -> None:
    paths = []
    for number in (1, 2, 3):
        paths.append(tmp_path / f"a name that is longer than a legend has room for, Specimen_RawData_{number}.csv")
        rows = "".join(f"{0.1 * k:.1f},{0.2 * k:.1f},{number * k}\n" for k in range(20))
        paths[-1].write_text(f"Time (s),Extension (mm),Load (N)\n{rows}", encoding="utf-8")
    one = scores(say("compare", *paths, "--repeats", "--out", tmp_path / "a.png", "--json").out)
    (name,) = {name for name, _, _ in one}
    assert one[name, "", "Repeats"] == 3
    # The mean of 1, 2 and 3 N on 0.2 mm.
    assert one[name, "", "Stiffness (secant 0 mm - 3.8 mm)"] == pytest.approx(1e4)


def test_a_figure_has_the_format_of_its_suffix(say: Callable[..., Said], run: Path, tmp_path: Path) -> None:
    assert say("plot", run, "--out", tmp_path / "both.svg").code == 0
    assert "<svg" in (tmp_path / "both.svg").read_text()
    said = say("plot", run, "--out", tmp_path / "both.docx")
    assert said.code == 2
    assert said.err.startswith("file of a figure: found 'both.docx', allowed a name that ends in .")
    assert said.err.count("\n") == 1


def test_a_report_of_what_is_no_run_is_one_line(say: Callable[..., Said], tmp_path: Path) -> None:
    (tmp_path / "run.h5").write_text("none")
    for words in ((tmp_path,), (tmp_path / "none",)):
        said = say("report", *words)
        assert said.code == 2
        assert said.err.count("\n") == 1
        assert said.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]
