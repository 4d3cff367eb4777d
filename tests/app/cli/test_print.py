from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest
import trimesh

from app.cli.main import main

if TYPE_CHECKING:
    from collections.abc import Callable

SMALL = Path(__file__).parents[3] / "examples" / "biaxial_small.yaml"


class Said(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def say(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    def command(*words: object) -> Said:
        monkeypatch.setattr(sys, "argv", ["knitlab", "print", *map(str, words)])
        with pytest.raises(SystemExit) as raised:
            main()
        return Said(int(raised.value.code or 0), *capsys.readouterr())

    return command


def changed(folder: Path, old: str, new: str) -> Path:
    text = SMALL.read_text(encoding="utf-8")
    assert old in text
    path = folder / "p.yaml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


def test_print_writes_what_a_printer_takes(say: Callable[..., Said], tmp_path: Path) -> None:
    said = say(SMALL, "--out", tmp_path / "new", "--slices", "--every", 100)
    assert said.code == 0
    assert "printable: yes" in said.out
    assert "NOT MET" not in said.out
    assert "Stratasys J35" in said.out
    assert "(assumed)" in said.out
    names = sorted(str(path.relative_to(tmp_path / "new")) for path in (tmp_path / "new").rglob("*.*"))
    layers = [f"biaxial_small_layers/layer_{number:05d}.png" for number in (50, 150, 250)]
    assert names == ["biaxial_small.3mf", "biaxial_small.stl", *layers, "biaxial_small_slices.png"]
    assert "done" in said.err
    solid = trimesh.load_mesh(tmp_path / "new" / "biaxial_small.stl")
    boxed = trimesh.load_scene(tmp_path / "new" / "biaxial_small.3mf")
    assert isinstance(solid, trimesh.Trimesh)
    assert solid.volume == pytest.approx(boxed.to_mesh().volume, rel=1e-5)


def test_print_as_json_is_in_si(say: Callable[..., Said], tmp_path: Path) -> None:
    said = say(SMALL, "--out", tmp_path, "--format", "stl", "--chord-error", "20 um", "--quiet", "--json")
    assert (said.code, said.err) == (0, "")
    data = json.loads(said.out)
    assert data["printable"] is True
    assert data["surface"]["chord_error_m"] == pytest.approx(20e-6)
    assert data["printer"]["clearance_m"]["assumed"] is True
    assert data["extent_m"][2] == pytest.approx(4.8e-3, abs=2e-5)
    checks = {check["name"]: check for check in data["checks"]}
    assert checks["gap by the mesh"]["found"] == pytest.approx(checks["gap by the centreline"]["found"], abs=40e-6)
    assert checks["gap by the mesh"]["least"] == 0.2e-3
    assert checks["gap by the mesh"]["most"] is None
    assert checks["edges not of two faces"]["found"] == 0
    assert data["files"] == [str(tmp_path / "biaxial_small.stl")]


def test_what_a_printer_cannot_make_is_an_outcome(say: Callable[..., Said], tmp_path: Path) -> None:
    said = say(changed(tmp_path, "loop: 8 mm", "loop: 0.05 mm"), "--out", tmp_path, "--format", "stl", "--quiet")
    assert (said.code, said.err) == (6, "")
    assert "printable: no" in said.out
    refused = [line.split("  ")[0].strip() for line in said.out.splitlines() if "NOT MET" in line]
    assert refused == ["fibre diameter", "gap by the centreline", "gap by the mesh"]
    assert (tmp_path / "biaxial_small.stl").exists()


def test_the_same_knit_is_printable_where_the_paper_printed_it(say: Callable[..., Said], tmp_path: Path) -> None:
    small = changed(tmp_path, "loop: 8 mm", "loop: 0.05 mm")
    said = say(small, "--out", tmp_path, "--printer", "nanoscribe", "--format", "3mf", "--quiet", "--json")
    assert said.code == 0
    assert json.loads(said.out)["layers"] == 150


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--printer", "j36"), "printer: found 'j36', allowed j35, nanoscribe, or the path of a .yaml file"),
        (("--chord-error", "3"), "--chord-error: found '3', allowed a length with its unit"),
        (("--chord-error", "0 mm"), "chord_error: found '0 m', allowed a length above 0 m"),
        (("--chord-error", "1 nm"), "surface: found "),
    ],
)
def test_wrong_words_are_one_line(words: tuple[str, ...], says: str, say: Callable[..., Said], tmp_path: Path) -> None:
    said = say(SMALL, "--out", tmp_path / "none", "--quiet", *words)
    assert (said.code, said.out) == (2, "")
    (line,) = said.err.splitlines()
    assert line.startswith(says)
    assert not (tmp_path / "none").exists()


def test_strands_that_overlap_are_one_line_with_both_places(say: Callable[..., Said], tmp_path: Path) -> None:
    stitch = "{curvature: 1.5, height: 0.8, depth: 0.25, row_spacing: 0.86, fibre_radius: 0.2}"
    said = say(changed(tmp_path, "knit: stockinette-default", f"knit: {stitch}"), "--quiet")
    assert (said.code, said.out) == (2, "")
    (line,) = said.err.splitlines()
    assert "specimen.knit: found strands" in line
    assert line.count("arc length") == 2


def test_a_missing_extra_is_one_line(say: Callable[..., Said], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("app.printing.find_spec", lambda _: None)
    said = say(SMALL, "--out", tmp_path)
    assert (said.code, said.out) == (2, "")
    assert said.err == (
        "printing: found 'an installation without trimesh, lxml, networkx', "
        "allowed one with the extra: pip install 'knitlab[printing]'\n"
    )


def test_help_teaches_with_an_example(say: Callable[..., Said]) -> None:
    said = say("--help")
    assert said.code == 0
    assert "knitlab print examples/biaxial_cycle.yaml --out print --slices" in said.out
