"""Run the swept examples small: pre-strain across an axis, then cycles along it."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

import pytest

from app.cli.main import main
from app.records.checkpoint import CHECKPOINT
from app.records.reader import RunReader
from app.runs.sweeps import SweepResult, run_sweep
from app.runs.use_cases import run_protocol
from app.schemas import load, load_sweep, loads
from knitlab_core.errors import SpecificationError

EXAMPLES = Path(__file__).parents[2] / "examples"
SMALL = {
    "[6, 6]": "[2, 2]",
    "friction: 0.3": "nodes_per_loop: 24\n  friction: 0.3",
    "params:": "max_strain_increment: 4 %\nparams:",
    "[0, 0.1, 0.2, 0.3, 0.4]": "[0, 0.4]",
    "noise: on": "noise: off",
}


def small(name: str, folder: Path, **more: str) -> Path:
    text = (EXAMPLES / "fig3d" / f"{name}.yaml").read_text(encoding="utf-8")
    for old, new in {**SMALL, **more}.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def silent(_share: float, _text: str) -> None:
    """Show nothing."""


def figures(result: SweepResult) -> list[dict[str, float]]:
    return [{name: value for name, value, _ in one.figures} for one in result.points]


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, SweepResult]:
    folder = tmp_path_factory.mktemp("course")
    path = small("fig3d_course", folder)
    return path, run_sweep(path, folder / "out", silent)


@pytest.mark.parametrize("which", ["course", pytest.param("wale", marks=pytest.mark.slow)])
def test_a_prestrain_across_stiffens_what_is_cycled(which: str, tmp_path: Path, request: Any) -> None:  # noqa: ANN401
    axis = {"course": "C", "wale": "W"}[which]
    if which == "course":
        _, result = request.getfixturevalue("course")
    else:
        result = run_sweep(small(f"fig3d_{which}", tmp_path), tmp_path / "out", silent)
    assert [one.outcome for one in result.points] == ["target", "target"]
    without, strained = figures(result)
    for cycle in (1, 2):
        peak = f"secant modulus to peak, {axis}, cycle {cycle}"
        assert strained[peak] > 2.0 * without[peak] > 0.0
    # Cycles count from their own step's start: the pre-strain is no part of them.
    assert f"secant modulus to 0.4%, {axis}, cycle 1" in strained
    assert not [name for name in strained if "cycle 3" in name]
    assert strained[f"loop area, {axis}, cycle 1"] > 0.0


def test_every_point_has_its_folder_and_all_have_one_table_and_plot(course: tuple[Path, SweepResult]) -> None:
    _, result = course
    assert [one.folder.name for one in result.points] == ["pre=0", "pre=0.4"]
    with result.table_file.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["point"], row["pre"], row["outcome"]) for row in rows] == [
        ("pre=0", "0", "target"),
        ("pre=0.4", "0.4", "target"),
    ]
    name = "secant modulus to peak, C, cycle 1"
    assert float(rows[1][f"{name} [Pa]"]) == pytest.approx(figures(result)[1][name])
    assert result.plot_file.read_bytes()[:4] == b"\x89PNG"


def test_a_record_says_its_point_again(course: tuple[Path, SweepResult]) -> None:
    path, result = course
    run = RunReader(result.points[1].folder / "run.h5")
    assert run.protocol.startswith("# fig3d_course.yaml with pre = 0.4\n")
    assert loads(run.protocol).protocol == load(path, {"pre": 0.4}).protocol
    assert [(step.place, step.tag, step.end) for step in run.steps] == [
        ("steps[0].zero", None, "target"),
        ("steps[1].ramp", "prestrain", "target"),
        ("steps[2].hold", None, "target"),
        ("steps[3].cycle", "orthogonal", "target"),
    ]
    assert run.steps[1].time == pytest.approx(0.4 * run.size.extents["W"] / 2e-4)
    assert set(run.trace.columns["step"]) == {0.0, 1.0, 2.0, 3.0}


def test_a_sweep_skips_what_is_done_and_refuses_what_is_another(course: tuple[Path, SweepResult]) -> None:
    path, before = course
    stamps = [(one.folder / "run.h5").stat().st_mtime_ns for one in before.points]
    again = run_sweep(path, before.folder, silent)
    assert [one.skipped for one in again.points] == [True, True]
    assert [(one.folder / "run.h5").stat().st_mtime_ns for one in again.points] == stamps
    other = path.with_name("other.yaml")
    other.write_text(path.read_text(encoding="utf-8").replace("n: 2", "n: 1"), encoding="utf-8")
    with pytest.raises(SpecificationError, match="found 'the run of another protocol'"):
        run_sweep(other, before.folder, silent)


SINGLE = """\
schema: knitlab/protocol@1
name: s
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [1, 1], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 16}
others: hold
log: {rate: 10 Hz, noise: off}
params: {peak: 4 %}
sweep: {peak: [0.5 %, 1.5 %]}
steps:
  - ramp: {axes: [C, W], to: "${peak}", rate: 0.2 mm/s}
"""


def contents(folder: Path) -> dict[str, tuple[bytes, int]]:
    """Return what the files of all points hold, and when they were written."""
    files = [path for path in folder.glob("*/*") if path.is_file()]
    return {path.relative_to(folder).as_posix(): (path.read_bytes(), path.stat().st_mtime_ns) for path in files}


def test_a_sweep_that_is_given_more_values_keeps_its_points(tmp_path: Path) -> None:
    first, more, other = (tmp_path / f"{name}.yaml" for name in ("first", "one more value", "other"))
    first.write_text(SINGLE, encoding="utf-8")
    run_sweep(first, tmp_path / "out", silent)
    before = contents(tmp_path / "out")
    # In the middle, in a file of another name, with what had been a default said, and laid out otherwise.
    said = SINGLE.replace("[0.5 %, 1.5 %]", "[0.5 %, 1 %, 1.5 %]").replace("name: s\n", "name: s # as before\n")
    more.write_text(said.replace("others: hold", "others: hold\nspeed_ref: pair"), encoding="utf-8")
    result = run_sweep(more, tmp_path / "out", silent)
    assert [(one.folder.name, one.skipped) for one in result.points] == [
        ("peak=0.5_", True),
        ("peak=1_", False),
        ("peak=1.5_", True),
    ]
    after = contents(tmp_path / "out")
    assert {name: after[name] for name in before} == before
    with result.table_file.open(newline="") as file:
        assert [row["peak"] for row in csv.DictReader(file)] == ["0.5 %", "1 %", "1.5 %"]
    # Anything but more values is another sweep, and one line says what differs.
    for old, new, says in (
        ("0.2 mm/s", "0.3 mm/s", "steps[0].ramp.rate: '0.3 mm/s' as in this sweep, not '0.2 mm/s'"),
        ("name: s", "name: t", "name: 't' as in this sweep, not 's'"),
        ("steps:", "steps:\n  - zero: {channels: [force]}", "steps: 2 of them as in this sweep, not 1 of them"),
        ("nodes_per_loop: 16", "nodes_per_loop: 18", "specimen.nodes_per_loop: 18 as in this sweep, not 16"),
    ):
        other.write_text(SINGLE.replace(old, new), encoding="utf-8")
        with pytest.raises(SpecificationError) as raised:
            run_sweep(other, tmp_path / "out", silent)
        assert says in str(raised.value)
        assert "\n" not in str(raised.value)
    assert contents(tmp_path / "out") == after


@pytest.mark.slow
def test_a_sweep_goes_on_with_what_was_cut_off(tmp_path: Path, course: tuple[Path, SweepResult]) -> None:
    path = small("fig3d_course", tmp_path)
    _, whole = course
    rows = 0

    def interrupt(share: float, _text: str) -> None:
        nonlocal rows
        rows += 0.0 < share < 0.9
        if rows == 12:
            rows += 1
            raise KeyboardInterrupt

    stopped = run_sweep(path, tmp_path / "out", interrupt)
    assert [one.outcome for one in stopped.points] == ["abort"]
    cut = tmp_path / "out" / "pre=0"
    assert RunReader(cut / "run.h5").outcome.end == "abort"
    assert (cut / CHECKPOINT).exists()
    result = run_sweep(path, tmp_path / "out", silent)
    assert [(one.outcome, one.skipped) for one in result.points] == [("target", False)] * 2
    for one, other in zip(result.points, whole.points, strict=True):
        made, wanted = (RunReader(point.folder / "run.h5").trace for point in (one, other))
        assert made.columns["force_C"].tolist() == wanted.columns["force_C"].tolist()
        assert made.phase == wanted.phase


def said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: object) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["knitlab", *map(str, words)])
    with pytest.raises(SystemExit) as raised:
        main()
    captured = capsys.readouterr()
    return int(raised.value.code or 0), captured.out, captured.err


def test_the_command_line_sweeps_analyses_and_checks(
    course: tuple[Path, SweepResult], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, result = course
    out = result.folder
    code, text, err = said(capsys, monkeypatch, "sweep", path, "--out", out, "--quiet", "--json")
    assert (code, err) == (0, "")
    assert [point["values"] for point in json.loads(text)["points"]] == [{"pre": 0}, {"pre": 0.4}]
    code, text, _ = said(capsys, monkeypatch, "analyse", out / "pre=0.4", "--json")
    data = json.loads(text)
    assert (code, data["outcome"], len(data["steps"])) == (0, "target", 4)
    names = {figure["name"] for figure in data["figures"]}
    assert {"secant modulus to 0.4%, C, cycle 2", "loop area, C, cycle 1"} <= names
    code, text, _ = said(capsys, monkeypatch, "check", path, "--json")
    points = json.loads(text)["points"]
    assert (code, list(points)) == (0, ["pre=0", "pre=0.4"])
    assert points["pre=0.4"]["largest_strain"] > points["pre=0"]["largest_strain"]
    code, text, _ = said(capsys, monkeypatch, "check", path, "--set", "pre=0.1", "--json")
    assert code == 0
    assert json.loads(text)["strokes"][1]["end_m"]["W"] == pytest.approx(0.1 * 2 * 8e-3 * 1.18, rel=0.02)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("run",), "17:1: sweep: found a sweep of 2 points, allowed one test: run all with `knitlab sweep"),
        (
            ("run", "--set", "pro=1"),
            "16:9: --set: found 'pro', allowed NAME=VALUE with a name under params: pre (did you",
        ),
        (("run", "--set", "pre"), "--set: found 'pre', allowed NAME=VALUE, such as pre=0.1"),
        (("check", "--set", "pre=9"), "steps[1].ramp.to.strain: found 9.0, allowed a strain from -0.9 to 5"),
        (("sweep", "--quiet", "--jobs", "0"), "--jobs: found 0, allowed a whole number from 1 to 64"),
    ],
)
def test_what_cannot_be_swept_is_one_line(
    words: tuple[str, ...],
    says: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = small("fig3d_course", tmp_path)
    code, _, err = said(capsys, monkeypatch, words[0], path, *words[1:])
    assert code == 2
    assert says in err
    assert len(err.strip().splitlines()) == 1


def test_of_four_cycles_driven_together_the_later_ones_repeat(tmp_path: Path) -> None:
    text = (EXAMPLES / "fig3a" / "fig3a.yaml").read_text(encoding="utf-8")
    for old, new in (("[6, 6]", "[2, 2]"), ("40 %", "25 %"), ("noise: on", "noise: off")):
        text = text.replace(old, new)
    path = tmp_path / "fig3a.yaml"
    path.write_text(text.replace("steps:", "max_strain_increment: 2.5 %\nsteps:"), encoding="utf-8")
    result = run_protocol(path, tmp_path / "run", silent)
    found = {name: value for name, value, _ in result.figures}
    for axis in ("C", "W"):
        loops = [found[f"loop area, {axis}, cycle {cycle}"] for cycle in (1, 2, 3, 4)]
        assert min(loops) > 0.0
        assert loops[1:] == pytest.approx([loops[1]] * 3, rel=0.05)


def test_a_protocol_without_a_sweep_is_not_swept(tmp_path: Path) -> None:
    with pytest.raises(SpecificationError, match="sweep: found nothing, allowed a sweep"):
        run_sweep(EXAMPLES / "fig3a" / "fig3a.yaml", tmp_path, silent)


def test_several_names_make_their_product(tmp_path: Path) -> None:
    swept = "params: {pre: 0.2, top: 40 %}\nsweep: {pre: [0, 0.1], top: [10 %, 20 %, 30 %]}"
    path = small("fig3d_course", tmp_path, **{"params: {pre: 0.2}\nsweep: {pre: [0, 0.4]}": swept})
    path.write_text(path.read_text().replace("upper: 40 %", 'upper: "${top}"'))
    labels = [point.label for point, _ in load_sweep(path)]
    assert labels[:2] == ["pre=0,top=10_", "pre=0,top=20_"]
    assert len(labels) == 6
