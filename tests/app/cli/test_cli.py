from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

import pytest

from app.cli.main import main
from knitlab_core.errors import ConvergenceError, FormatError, SpecificationError
from tests.synthetic_run import make_run

if TYPE_CHECKING:
    from collections.abc import Callable

    from app.schemas import Loaded
    from rigs.analysis.clasps import ClaspLoss
    from rigs.analysis.material_limits import LimitCrossing
    from rigs.step_record import StepRecord

EXAMPLES = Path(__file__).parents[3] / "examples"
MAIN_JOB = EXAMPLES / "biaxial_cycle.yaml"
SMALL = EXAMPLES / "biaxial_small.yaml"


class Said(NamedTuple):
    """What a command answered."""

    code: int
    out: str
    err: str


@pytest.fixture
def say(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    def command(*words: object) -> Said:
        monkeypatch.setattr(sys, "argv", ["knitlab", *map(str, words)])
        with pytest.raises(SystemExit) as raised:
            main()
        code = raised.value.code
        return Said(0 if code is None else int(code), *capsys.readouterr())

    return command


@dataclass(frozen=True, kw_only=True)
class Ended:
    """The end of a run that was not run."""

    outcome: str = "target"
    message: str = "all steps done"
    folder: Path = Path("runs/x")
    figures: tuple[tuple[str, float, str], ...] = (("stress C at 20 %", 1234.5, "Pa"),)
    steps: tuple[StepRecord, ...] = ()
    crossings: tuple[LimitCrossing, ...] = ()
    losses: tuple[ClaspLoss, ...] = ()


@pytest.fixture
def end_with(monkeypatch: pytest.MonkeyPatch) -> Callable[[Ended | BaseException], list[object]]:
    """Put a run in place of the real one; it says what it was called with."""

    def put(end: Ended | BaseException) -> list[object]:
        calls: list[object] = []

        def run_protocol(
            loaded: Loaded,
            out: Path | None,
            progress: Callable[[float, str], None],
            *,
            draw: object,
            began: float,
        ) -> Ended:
            assert draw is not None
            assert began < time.perf_counter()
            calls.extend([Path(loaded.document.path), out])
            progress(0.5, "halfway")
            if isinstance(end, BaseException):
                raise end
            return end

        module = ModuleType("app.runs.use_cases")
        vars(module)["run_protocol"] = run_protocol
        monkeypatch.setitem(sys.modules, "app.runs.use_cases", module)
        return calls

    return put


def spoilt(folder: Path, old: str, new: str, source: Path = SMALL) -> Path:
    text = source.read_text(encoding="utf-8")
    assert old in text
    path = folder / "p.yaml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


def test_help_teaches_with_examples(say: Callable[..., Said]) -> None:
    said = say("--help")
    assert said.code == 0
    assert "knitlab run examples/biaxial_cycle.yaml" in said.out
    for command in ("check", "preview", "run", "export", "plot", "materials", "schema"):
        assert command in said.out
        assert "knitlab " + command in say(command, "--help").out


@pytest.mark.parametrize(
    ("words", "heavy"),
    [
        (["--help"], {"numpy", "scipy", "numba", "matplotlib", "pint", "pydantic", "h5py", "ruamel.yaml"}),
        # Strokes and clearance of a knit need neither the solver nor anything that draws.
        (
            ["check", str(EXAMPLES / "biaxial_small.yaml")],
            {"scipy", "numba", "llvmlite", "matplotlib", "pint", "h5py", "fastapi", "sqlalchemy"},
        ),
    ],
)
def test_help_and_check_load_nothing_heavy(words: list[str], heavy: set[str]) -> None:
    code = (
        f"import sys; sys.argv = {['knitlab', *words]!r}\n"
        "from app.cli.main import main\n"
        "try: main()\n"
        f"finally: print('heavy:', sorted({heavy!r} & set(sys.modules)))"
    )
    out = subprocess.run(  # noqa: S603 (our own interpreter and text)
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=EXAMPLES.parent
    )
    assert out.stdout.splitlines()[-1] == "heavy: []"


def test_version(say: Callable[..., Said]) -> None:
    said = say("--version")
    assert said.code == 0
    assert said.out.startswith("knitlab ")


def test_materials_are_listed_with_their_sources(say: Callable[..., Said]) -> None:
    said = say("materials", EXAMPLES / "materials" / "my-resins.yaml")
    assert (said.code, said.err) == (0, "")
    for text in ("RGD8530-DM", "8.2e+08 Pa", "creeping-resin", "relaxation time 3", "(assumed)"):
        assert text in said.out
    data = json.loads(say("materials", "--json").out)
    assert data["IP-Dip"]["young_modulus"]["value"] == 3e9
    assert "creeping-resin" not in data
    wrong = say("materials", MAIN_JOB)
    assert wrong.code == 2
    assert wrong.err.startswith(f"{MAIN_JOB}:")
    assert "Traceback" not in wrong.err


def test_schemas_of_both_kinds_of_file(say: Callable[..., Said]) -> None:
    assert "steps" in json.loads(say("schema").out)["required"]
    assert "materials" in json.loads(say("schema", "--kind", "material").out)["required"]


def test_check_prints_the_plan_of_the_main_job(say: Callable[..., Said]) -> None:
    said = say("check", MAIN_JOB)
    assert said.code == 0
    (line,) = said.err.splitlines()
    assert "WARNING: material: strength of 29 MPa (assumed) would be passed" in line
    # 40 % of six loop widths of 8 mm at 0.2 mm/s, four times.
    assert "planned duration 384 s, 3841 rows at 10 Hz" in said.out
    assert "no limit would be passed" not in said.out
    assert "arc-length budget" in said.out
    assert "assumed" in said.out


def test_check_prints_levels_with_their_sides(say: Callable[..., Said], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "240")
    said = say("check", Path(__file__).parents[3] / "docs" / "site" / "examples" / "steps.yaml")
    assert (said.code, said.err) == (0, "")
    for words in ("until force > 2 N", "until strain > 0.2", "until force 1 N", "until drop 0.6"):
        assert words in " ".join(said.out.split())


def test_check_as_json_is_in_si(say: Callable[..., Said]) -> None:
    said = say("check", MAIN_JOB, "--json")
    plan = json.loads(said.out)
    assert plan["specimen"]["loop_width_m"] == 8e-3
    assert plan["specimen"]["gauge_lengths_m"]["C"] == pytest.approx(0.048)
    assert [stroke["phase"] for stroke in plan["strokes"]] == ["Zero"] + ["Stretch", "Recover"] * 2
    assert plan["duration_s"] == pytest.approx(384.0)
    (warning,) = plan["warnings"]
    assert warning.startswith("material: strength of 29 MPa (assumed) would be passed")
    assert plan["largest_strain"] == plan["budget"]["largest"] == pytest.approx(0.4)
    assert plan["budget"]["locking"] == plan["specimen"]["locking_strain"]


def test_going_past_the_locking_strain_is_a_warning(say: Callable[..., Said], tmp_path: Path) -> None:
    said = say("check", spoilt(tmp_path, "peak: 20 %", "peak: 80 %"))
    assert said.code == 0
    line, material, elongation = said.err.splitlines()
    assert "WARNING: arc-length budget: the protocol goes to 80.0% as equibiaxial strain, past the estimated" in line
    assert "WARNING: material: strength of 29 MPa" in material
    assert "WARNING: material: elongation at break of 15 %" in elongation


def test_limits_of_the_rig_are_warnings(say: Callable[..., Said], tmp_path: Path) -> None:
    path = spoilt(tmp_path, "loop: 8 mm", "loop: 0.9 m")
    path.write_text(path.read_text().replace("0.2 mm/s", "0.5 m/s"))
    said = say("check", path)
    assert said.code == 0
    assert [line.split(": ")[2] for line in said.err.splitlines()] == ["travel", "travel", "speed"]
    assert "no limit would be passed" not in said.out


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_log_faster_than_the_stage_is_one_line_with_its_place(
    command: str, say: Callable[..., Said], end_with: Callable[..., list[object]], tmp_path: Path
) -> None:
    calls = end_with(Ended())
    said = say(command, spoilt(tmp_path, "10 Hz", "10 kHz"))
    assert said.code == 2
    (line,) = said.err.splitlines()
    assert "log.rate: found 10000 Hz, allowed 100 Hz or less: biaxial-hook samples no faster" in line
    assert calls == []


@pytest.mark.parametrize("command", ["check", "preview", "run"])
def test_overlapping_strands_are_one_line_with_the_place_of_the_knit(
    command: str, say: Callable[..., Said], end_with: Callable[..., list[object]], tmp_path: Path
) -> None:
    calls = end_with(Ended())
    stitch = "{curvature: 1.5, height: 0.8, depth: 0.25, row_spacing: 0.86, fibre_radius: 0.2}"
    path = spoilt(tmp_path, "knit: stockinette-default", f"knit: {stitch}")
    said = say(command, path)
    assert said.code == 2
    (line,) = said.err.splitlines()
    assert line.startswith(f"{path}:5:18: specimen.knit: found ")
    assert ", allowed " in line
    assert calls == []


@pytest.mark.parametrize("command", ["check", "preview", "run"])
def test_bad_input_is_one_line_and_code_2(
    command: str, say: Callable[..., Said], end_with: Callable[..., list[object]], tmp_path: Path
) -> None:
    end_with(Ended())
    for path, says in (
        (spoilt(tmp_path, "loop: 8 mm", "loop: 8 s"), ":5:60: specimen.loop: found '8 s', allowed a length"),
        (tmp_path / "none.yaml", ":1:1: protocol: found no such file or directory, allowed a YAML file"),
        (tmp_path, ":1:1: protocol: found is a directory"),
    ):
        said = say(command, path)
        assert (said.code, said.out) == (2, "")
        (line,) = said.err.splitlines()
        assert line.startswith(f"{path}{says}")


def test_wrong_usage_is_code_2(say: Callable[..., Said]) -> None:
    assert say("check").code == 2
    assert say("knit", MAIN_JOB).code == 2


def test_preview_draws_the_knit(say: Callable[..., Said], tmp_path: Path) -> None:
    said = say("preview", SMALL, "--out", tmp_path / "new", "--json")
    assert said.code == 0
    facts = json.loads(said.out)
    picture = Path(facts["picture"])
    assert picture.parent == tmp_path / "new"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert facts["clearance_m"] > 0
    assert facts["yarn_length_m"] > 4 * 4.7 * 8e-3


def test_run_prints_figures_and_hands_on_its_arguments(
    say: Callable[..., Said], end_with: Callable[..., list[object]], tmp_path: Path
) -> None:
    calls = end_with(Ended())
    said = say("run", SMALL, "--out", tmp_path / "r", "--quiet")
    assert (said.code, said.err) == (0, "")
    assert "stress C at 20 %" in said.out
    assert calls == [SMALL, tmp_path / "r"]


def test_run_shows_progress_on_stderr_alone(say: Callable[..., Said], end_with: Callable[..., list[object]]) -> None:
    end_with(Ended())
    said = say("run", SMALL, "--json")
    assert "halfway" in said.err
    assert json.loads(said.out) == {
        "outcome": "target",
        "message": "all steps done",
        "folder": "runs/x",
        "crossings": [],
        "losses": [],
        "figures": [{"name": "stress C at 20 %", "value": 1234.5, "unit": "Pa"}],
        "steps": [],
    }


@pytest.mark.parametrize(
    ("end", "code"),
    [
        (Ended(), 0),
        (Ended(outcome="limit"), 0),
        (Ended(outcome="rupture"), 0),
        (Ended(outcome="limit", figures=()), 4),
        (Ended(outcome="diverged"), 3),
        (Ended(outcome="abort", figures=()), 130),
        (ConvergenceError("no equilibrium near row 3, loop 2"), 3),
        (SpecificationError("out", "runs/x", "a folder without a run"), 2),
        (FormatError("rig.yaml", 3, "a number"), 2),
        (PermissionError(13, "Permission denied", "runs"), 2),
        (KeyboardInterrupt(), 130),
    ],
    ids=str,
)
def test_the_exit_code_says_how_a_run_ended(
    end: Ended | BaseException, code: int, say: Callable[..., Said], end_with: Callable[..., list[object]]
) -> None:
    end_with(replace(end, message="why it ended") if isinstance(end, Ended) else end)
    said = say("run", SMALL, "--quiet")
    assert said.code == code
    lines = said.err.splitlines()
    assert len(lines) == (0 if isinstance(end, KeyboardInterrupt) or end == Ended() else 1)
    if isinstance(end, Ended) and lines:
        hint = "; go on with: knitlab resume runs/x" if end.outcome == "abort" else ""
        assert lines[0] == f"{SMALL}: {end.outcome}: why it ended{hint}"


def test_resume_leaves_a_run_that_has_ended(say: Callable[..., Said], tmp_path: Path) -> None:
    make_run(tmp_path / "run.h5")
    before = (tmp_path / "run.h5").read_bytes()
    for run in (tmp_path, tmp_path / "run.h5"):
        said = say("resume", run)
        assert (said.code, said.out, said.err) == (0, "", f"{run}: has ended already: target\n")
    assert (tmp_path / "run.h5").read_bytes() == before


def test_resume_of_what_is_no_run_is_code_2(say: Callable[..., Said], tmp_path: Path) -> None:
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "run.h5").write_bytes(b"no run")
    for words, says in (
        (["resume"], "RUN"),
        (["resume", tmp_path / "none"], "no such file or directory"),
        (["resume", tmp_path / "bad"], "expected the record of a run"),
    ):
        said = say(*words)
        assert said.code == 2
        assert says in said.err


def test_plot_writes_one_figure_of_runs(say: Callable[..., Said], tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    make_run(tmp_path / "a" / "run.h5")
    out = tmp_path / "both.png"
    said = say("plot", tmp_path / "a", tmp_path / "a" / "run.h5", "--out", out)
    assert (said.code, said.out) == (0, f"plot: {out}\n")
    assert out.read_bytes().startswith(b"\x89PNG")


def test_plot_of_what_is_no_run_is_code_2(say: Callable[..., Said], tmp_path: Path) -> None:
    for words, says in ((["plot"], "RUN"), (["plot", tmp_path], "no such file or directory")):
        said = say(*words)
        assert said.code == 2
        assert says in said.err


@pytest.mark.parametrize(("name", "axis", "passed"), [("uniaxial_course", "C", 0), ("fig4c/fig4c_pile_4", "P", 1)])
def test_check_prints_the_plan_of_a_test_on_the_frame(
    name: str, axis: str, passed: int, say: Callable[..., Said]
) -> None:
    said = say("check", EXAMPLES / f"{name}.yaml")
    assert said.code == 0
    assert said.err.count("WARNING: material: strength of 29 MPa (assumed) would be passed") == passed
    assert said.err.count("WARNING: material:") == len(said.err.splitlines())
    assert "along the frame" in said.out
    assert f"along {axis}, sides free" in said.out
    assert ("no limit would be passed" in said.out) == (passed == 0)


def test_limits_of_the_frame_are_warnings(say: Callable[..., Said], tmp_path: Path) -> None:
    path = spoilt(tmp_path, "0.2 mm/s", "0.01 um/s", EXAMPLES / "uniaxial_course.yaml")
    path.write_text(path.read_text().replace("10 Hz", "0.1 Hz"))
    said = say("check", path)
    assert [line.split(": ")[2:] for line in said.err.splitlines()] == [
        ["speed", "a pair would move at 1e-05 mm/s, at least 1.667e-05 mm/s"]
    ]


def test_schema_is_json(say: Callable[..., Said]) -> None:
    said = say("schema")
    assert said.code == 0
    assert json.loads(said.out)["title"] == "ProtocolModel"
