from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, NamedTuple

import pytest

from app.cli.main import main
from app.records.reader import read_run
from rigs.logs.catalogue import LOGS
from tests.synthetic_run import make_run

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


class Said(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def say(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    def command(*words: object) -> Said:
        monkeypatch.setattr(sys, "argv", ["knitlab", "export", *map(str, words)])
        with pytest.raises(SystemExit) as raised:
            main()
        return Said(int(raised.value.code or 0), *capsys.readouterr())

    return command


def test_help_lists_every_dialect(say: Callable[..., Said]) -> None:
    told = say("--help").out
    for name, log in LOGS.items():
        assert f"  {name:18}  {log.about}" in told


def test_a_run_is_exported_in_any_dialect_locale_and_unit(tmp_path: Path, say: Callable[..., Said]) -> None:
    make_run(tmp_path / "run.h5")
    said = say(tmp_path)
    path = tmp_path / "synthetic.csv"
    assert said == Said(0, f"log: {path}\n", "")
    english = path.read_bytes()
    said = say(
        tmp_path / "run.h5", "--dialect", "biotester", "--locale", "de", "--units", "force=N", "--out",
        tmp_path / "new" / "de", "--json",
    )  # fmt: skip
    german = tmp_path / "new" / "de" / "synthetic.csv"
    assert json.loads(said.out) == {"files": [str(german)]}
    heading, first, *_ = german.read_text(encoding="utf-8").splitlines()
    assert heading.endswith(";XForce_N;YForce_N")
    assert first.endswith(";0;0;0,00000;0,00000")
    assert path.read_bytes() == english


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--dialect", "excel"], "dialect: found 'excel', allowed one of biotester, bluehill-universal"),
        (["--dialect", "bluehill3"], "run.channels: found 'biaxial-hook', allowed a run on uniaxial-frame"),
        (["--locale", "tlh"], "locale: found 'tlh', allowed one of en, de, fr"),
        (["--units", "force"], "units: found 'force', allowed quantity=unit"),
        (["--units", "force=kg"], "units.force: found 'kg', allowed one of N"),
    ],
)
def test_what_cannot_be_exported_is_said_in_one_line(
    tmp_path: Path, say: Callable[..., Said], words: list[str], complaint: str
) -> None:
    make_run(tmp_path / "run.h5")
    said = say(tmp_path, *words)
    assert (said.code, said.out) == (2, "")
    assert said.err.startswith(complaint)
    assert said.err.count("\n") == 1


def test_a_run_without_rows_or_record_is_said_in_one_line(tmp_path: Path, say: Callable[..., Said]) -> None:
    said = say(tmp_path)
    assert (said.code, said.err) == (2, f"{tmp_path / 'run.h5'}: no such file or directory\n")
    make_run(tmp_path / "run.h5", [], sampled=False)
    said = say(tmp_path)
    assert said.code == 2
    assert said.err == "run.equilibria: found 'none', allowed a run with a row or more\n"


@pytest.mark.parametrize("kind", ["link", "copy"])
def test_shapes_are_written_under_a_name_that_viewers_know(kind: str, tmp_path: Path, say: Callable[..., Said]) -> None:
    reader = pytest.importorskip("vtkmodules.vtkIOHDF", reason="needs the extra 'test'").vtkHDFReader()
    make_run(tmp_path / "run.h5")
    path = tmp_path / "seen" / "synthetic.vtkhdf"
    for _ in range(2):
        assert say(tmp_path, "--shapes", kind, "--out", tmp_path / "seen") == Said(0, f"shapes: {path}\n", "")
    assert path.samefile(tmp_path / "run.h5") == (kind == "link")
    assert path.read_bytes() == (tmp_path / "run.h5").read_bytes()
    assert [file.name for file in path.parent.iterdir()] == ["synthetic.vtkhdf"]
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetNumberOfSteps() == len(read_run(path).frames()) > 1
    assert reader.GetOutputDataObject(0).GetNumberOfPoints() == len(read_run(path).frames()[0].nodes)


def test_shapes_take_no_option_of_logs(tmp_path: Path, say: Callable[..., Said]) -> None:
    make_run(tmp_path / "run.h5")
    said = say(tmp_path, "--shapes", "copy", "--locale", "de")
    assert (said.code, said.out, said.err.count("\n")) == (2, "", 1)
    assert "--shapes" in said.err
    assert not list(tmp_path.glob("*.vtkhdf"))
