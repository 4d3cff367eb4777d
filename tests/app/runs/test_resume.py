"""Kill real runs at random points, go on with them, and compare what they leave with a run that was not killed."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import h5py
import numpy as np
import pytest

from app.records.checkpoint import CHECKPOINT, Keeper
from app.records.lock import locked
from app.records.reader import RunReader
from app.runs.use_cases import has_ended, resume_run, run_protocol
from knitlab_core.errors import FormatError, SpecificationError
from rigs.record import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kill -9 is Unix")

ROOT: Final = Path(__file__).parents[3]
SEED: Final = 20260

ELASTIC: Final = """
schema: knitlab/protocol@1
name: elastic
rig: biaxial-hook
specimen:
  {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3, nodes_per_loop: 16}
speed_ref: pair
others: hold
log: {rate: 10 Hz}
max_strain_increment: 0.01
steps:
  - zero: {channels: [force, displacement]}
  - preload: {axes: [C, W], force: 0.05 N, rate: 0.2 mm/s, tag: pre}
  - zero: {channels: [force, displacement], gauge_length: here}
  - hold: {for: 20 s, tag: still}
  - cycle: {axes: [C, W], lower: 0, upper: 0.1, rate: 0.2 mm/s, n: 2, tag: equibiaxial}
"""

CREEPING: Final = (
    ELASTIC.replace("name: elastic", "name: creeping\nmaterials: my-resins.yaml")
    .replace("RGD8530-DM", "creeping-resin, viscoelastic: on")
    .replace("0.05 N", "0.02 N")
)
YIELDING: Final = (
    ELASTIC.replace("name: elastic", "name: yielding")
    .replace("RGD8530-DM", "RGD8530-DM, viscoelastic: on, yield: on")
    .replace("upper: 0.1", "upper: 0.25")
    .replace("speed_ref: pair", "extensometer: on\nspeed_ref: pair")
    .replace("0.01\n", "0.025\n")
)
FEW_ROWS: Final = (
    YIELDING.replace("name: yielding", "name: few_rows").replace("upper: 0.25", "upper: 0.2").replace("n: 2", "n: 1")
)
SHORT: Final = ELASTIC[: ELASTIC.index("  - cycle")]

# The runs here take a second: checkpoints come more often, and no pictures are drawn.
CHILD: Final = (
    "import app.records.checkpoint; app.records.checkpoint.EVERY, app.records.checkpoint.SHARE = 0.05, float('inf')\n"
    "import sys; sys.argv[0] = 'knitlab'\n"
    "from app.cli.main import main; main()"
)


def knitlab(*words: object) -> subprocess.Popen[str]:
    return subprocess.Popen(  # noqa: S603
        [sys.executable, "-P", "-c", CHILD, *map(str, words), "--no-pictures"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )


def rows_in(folder: Path) -> int:
    try:
        with h5py.File(folder / "run.h5", "r", locking=False) as file:
            return len(file["equilibria/time"])
    except (OSError, KeyError):
        return 0


def kill_at(process: subprocess.Popen[str], folder: Path, rows: int, after: float) -> None:
    """Kill a process some seconds after its run has so many rows."""
    while rows_in(folder) < rows:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    time.sleep(after)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL


def contents(record: Path) -> dict[str, Any]:
    """Return every dataset and attribute of a record but when it began and how long it took."""
    found: dict[str, Any] = {}

    def look(name: str, item: h5py.Dataset | h5py.Group) -> None:
        found.update({f"{name}@{key}": value for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset) and name != "equilibria/seconds":
            found[name] = item[()]

    with h5py.File(record, "r") as file:
        found.update({f"@{key}": value for key, value in file.attrs.items() if key != "started"})
        file.visititems(look)
    return found


def assert_alike(folder: Path, whole: Path) -> None:
    one, two = contents(folder / "run.h5"), contents(whole / "run.h5")
    assert one.keys() == two.keys()
    for name, value in two.items():
        exact = np.array_equal(one[name], value, equal_nan=np.asarray(value).dtype.kind == "f")
        assert exact, f"{name}: {one[name]} instead of {value}"
    (log,) = whole.glob("*.csv")
    assert (folder / log.name).read_bytes() == log.read_bytes()


@pytest.fixture
def whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], tuple[Path, Path]]:
    """Return a function that runs a protocol without a kill; it returns the protocol's file and the run folder."""
    monkeypatch.setattr("app.views.drawing.draw_pictures", lambda *_: "")

    def run(text: str) -> tuple[Path, Path]:
        protocol = tmp_path / "protocol.yaml"
        protocol.write_text(text, encoding="utf-8")
        shutil.copy(ROOT / "examples" / "materials" / "my-resins.yaml", tmp_path)
        return protocol, run_protocol(protocol, tmp_path / "whole", lambda _share, _text: None).folder

    return run


@pytest.mark.parametrize(
    "text",
    [FEW_ROWS, *(pytest.param(text, marks=pytest.mark.slow) for text in (ELASTIC, CREEPING, YIELDING))],
    ids=["few rows", "elastic", "creeping", "yielding"],
)
def test_a_killed_run_ends_with_the_rows_of_an_unkilled_one(
    text: str, whole: Callable[[str], tuple[Path, Path]], tmp_path: Path
) -> None:
    protocol, unkilled = whole(text)
    total = len(RunReader(unkilled / "run.h5").trace)
    chance = random.Random(SEED)  # noqa: S311 (not for secrets)
    folder = tmp_path / "killed"
    words: tuple[object, ...] = ("run", protocol, "--out", folder, "--quiet")
    for rows in sorted(chance.randint(2, total - 8) for _ in range(3)):
        after = chance.uniform(0.0, 0.03)
        print(f"kill -9 {1e3 * after:.0f} ms after row {rows} of {total}")  # noqa: T201 (shown if it fails)
        kill_at(knitlab(*words), folder, rows, after)
        assert (folder / CHECKPOINT).exists()
        assert RunReader(folder / "run.h5").outcome.end == "abort"
        words = ("resume", folder, "--quiet")
    process = knitlab(*words)
    out, err = process.communicate(timeout=240.0)
    assert process.returncode == 0, err
    assert str(folder) in out
    assert_alike(folder, unkilled)
    assert {one.name for one in folder.iterdir()} == {one.name for one in unkilled.iterdir()}


def small(folder: Path, monkeypatch: pytest.MonkeyPatch, after: int) -> Path:
    """Interrupt a run after so many checkpoints, as Ctrl-C does; return its folder."""
    protocol = folder / "small.yaml"
    protocol.write_text(SHORT, encoding="utf-8")
    keep, kept = Keeper.keep, []

    def interrupted(*arguments: Any) -> None:  # noqa: ANN401 (handed through)
        keep(*arguments)
        kept.append(1)
        if len(kept) == after:
            raise KeyboardInterrupt

    monkeypatch.setattr("app.records.checkpoint.EVERY", 0.0)
    monkeypatch.setattr("app.records.checkpoint.SHARE", float("inf"))
    monkeypatch.setattr("app.runs.runner.publish", lambda *_, **__: None)
    with monkeypatch.context() as patch:
        patch.setattr(Keeper, "keep", interrupted)
        result = run_protocol(protocol, folder / "run", silent)
    assert (result.outcome, result.message) == ("abort", f"interrupted; {after + 1} equilibria kept")
    return folder / "run"


def silent(_share: float, _text: str) -> None:
    """Show nothing."""


def test_what_may_and_what_may_not_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = small(tmp_path, monkeypatch, 3)
    checkpoint, record = run / CHECKPOINT, run / "run.h5"
    (run / ".unfinished-checkpoint-0.h5").touch()
    copy = shutil.copytree(run, tmp_path / "copy")
    assert has_ended(run) is None

    # Two processes at one run.
    with locked(run), pytest.raises(SpecificationError, match="which another process is writing"):
        resume_run(run, silent)

    # Other numbers than it began with.
    with monkeypatch.context() as patch:
        patch.setattr("app.runs.provenance.platform.python_version", lambda: "2.7")
        with pytest.raises(FormatError, match=r"version\.python = 2\.7 as there is now, found 3\.\S+ as it began"):
            resume_run(run, silent)

    # A checkpoint of another protocol, of another layout, and none at all.
    with h5py.File(record, "r+") as file:
        file["protocol"][()] = file["protocol"].asstr()[()] + "# changed"
    with pytest.raises(FormatError, match="another protocol"):
        resume_run(run, silent)
    with h5py.File(checkpoint, "r+") as file:
        file.attrs["layout"] = 0
    with pytest.raises(FormatError, match=r"checkpoint\.h5:1: expected a checkpoint in layout [0-9]+"):
        resume_run(run, silent)
    checkpoint.write_bytes(b"no checkpoint")
    with pytest.raises(FormatError, match="expected the checkpoint of a run"):
        resume_run(run, silent)

    # From its checkpoint; without one, or without a record that can be read, from the start: alike in the end.
    assert resume_run(copy, silent).outcome == "target"
    assert has_ended(copy) == Outcome(end="target")
    assert capsys.readouterr().err == ""
    checkpoint.unlink()
    assert resume_run(record, silent).outcome == "target"
    assert "starts from the beginning" in capsys.readouterr().err
    assert {one.name for one in run.iterdir()} == {"run.h5"}
    rows = len(RunReader(copy / "run.h5").trace)
    assert len(RunReader(record).trace) == rows
    # What has ended is left alone.
    before = record.read_bytes()
    assert resume_run(run, silent).figures == ()
    assert record.read_bytes() == before


@pytest.mark.parametrize("harm", ["unreadable", "short"])
def test_a_record_that_was_harmed_by_the_kill_is_made_anew(
    harm: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = small(tmp_path, monkeypatch, 2)
    if harm == "unreadable":
        (run / "run.h5").write_bytes(b"half")
    else:
        with h5py.File(run / "run.h5", "r+") as file:
            file["equilibria/time"].resize((1,))
    result = resume_run(run, silent)
    assert "starts from the beginning" in capsys.readouterr().err
    assert result.outcome == "target"
    assert result.figures


def test_a_run_killed_while_it_was_published_is_published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = small(tmp_path, monkeypatch, 2)
    published: list[Path] = []

    def publish(record: RunReader, *_: object, **__: object) -> None:
        published.append(record.path.parent)
        if len(published) == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr("app.runs.runner.publish", publish)
    with pytest.raises(KeyboardInterrupt):
        resume_run(run, silent)
    assert RunReader(run / "run.h5").outcome == Outcome(end="target")
    assert has_ended(run) is None
    assert resume_run(run, silent).figures
    assert published == [run, run]
    assert has_ended(run) == Outcome(end="target")


def test_a_run_in_an_exact_folder_spares_what_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.runs.runner.publish", lambda *_, **__: None)
    protocol, folder = tmp_path / "p.yaml", tmp_path / "job" / "run"
    protocol.write_text(ELASTIC[: ELASTIC.index("  - preload")], encoding="utf-8")
    folder.mkdir(parents=True)
    (folder / "job.log").touch()
    (folder / "run.h5").write_bytes(b"killed before its first row was whole")
    result = run_protocol(protocol, folder, silent, exact=True)
    assert result.folder == folder
    assert {one.name for one in folder.iterdir()} == {"job.log", "run.h5"}
    with pytest.raises(SpecificationError, match="a folder without a run"):
        run_protocol(protocol, folder, silent, exact=True)
