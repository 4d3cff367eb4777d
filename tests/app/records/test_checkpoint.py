from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np
import pytest

from app.records.checkpoint import Keeper, Origin, Saved, read_checkpoint, require_same, save
from app.records.h5_tree import fetch, store
from app.records.layout import cut, lengths, reaches
from app.records.lock import LOCK, locked
from app.records.reader import RunReader
from app.records.writer import RunWriter
from knitlab_core.contact.bonds import BondState
from knitlab_core.equilibrium.model import State
from knitlab_core.equilibrium.solver_state import SolverState
from knitlab_core.errors import FormatError, SpecificationError
from rigs.control.checkpoint import Checkpoint
from rigs.control.controller import Memory
from rigs.control.resume_point import END, START, PathPosition, ResumePoint
from rigs.instruments.zeros import Zeroing
from rigs.protocol.strokes import History
from tests.app.records.test_records import writer
from tests.knitlab_core.equilibrium.strands import strand
from tests.synthetic_run import frame, row

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).parents[3]
ORIGIN = Origin(name="ü", protocol="name: ü\n", materials="", facts={"seed": 1, "version.numpy": "2.0", "speed": 0.1})


def saved(**more: object) -> Saved:
    _, state = strand()
    cursor = ResumePoint(
        memory=Memory(
            history=History(
                origin={"C": 0.1 + 0.2, "W": -1e-300}, gauges={"C": 0.1 / 3.0, "W": 0.02}, cycle=2, free=("W",)
            ),
            tare={"C": 1.0 / 7.0},
            shown={},
            first={"C": 0.0},
            peak={"C": 5e-324},
            image_tag="ü",
        ),
        leaf=1,
        stroke=3,
        begun=1.5,
        segment=2,
        origin={"C": 1.0 / 3.0, "W": 0.0},
        place=PathPosition(begin=0.1, at=0.7, step=0.05),
        variables={"share": 0.3, "stop_C": 1e-3},
        last=replace(row(2.0, 0.1, 1, "Stretch"), residual=float("inf"), tag="ü"),
    )
    checkpoint = Checkpoint(
        cursor=cursor,
        state=replace(state, bonds=BondState.printed(2)),
        solver_state=SolverState(state.q + 1.0, None, 1e-8),
        mounted=state.q.copy(),
        severed=(7, 5),
    )
    zeroing = Zeroing(
        time=0.0,
        kinds=frozenset({"force", "displacement"}),
        place="steps[1].zero",
        travel={"C": 0.1 + 0.2},
        force={"C": -1e-300},
        gauges={"C": 0.1 / 3.0},
    )
    return replace(
        Saved(origin=ORIGIN, checkpoint=checkpoint, lengths={"tags": 2}, zeroings=(zeroing,), seconds=3.5),
        **more,  # type: ignore[arg-type]
    )


def test_a_checkpoint_is_read_as_it_was_written(tmp_path: Path) -> None:
    one = saved()
    save(tmp_path / "checkpoint.h5", one)
    two = read_checkpoint(tmp_path / "checkpoint.h5")
    assert [path.name for path in tmp_path.iterdir()] == ["checkpoint.h5"]
    assert (two.origin, two.lengths, two.zeroings, two.seconds) == (one.origin, one.lengths, one.zeroings, one.seconds)
    assert two.checkpoint.cursor == one.checkpoint.cursor
    assert two.checkpoint.severed == (7, 5)
    assert two.checkpoint.solver_state.hold is None
    assert two.checkpoint.solver_state.shift == 1e-8
    state = two.checkpoint.state
    assert state.history is None
    assert np.array_equal(state.q, one.checkpoint.state.q)
    assert np.array_equal(state.frames.director, one.checkpoint.state.frames.director)
    assert state.memory.key.dtype == np.int64
    assert type(state.contacts) is int
    assert type(state.bonds.released) is float


def test_a_tree_without_a_field_is_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "tree.h5", "w") as file:
        store(file.create_group("state"), saved().checkpoint.state)
        del file["state/memory/slip"]
        with pytest.raises(KeyError):
            fetch(file["state"], State)


@pytest.mark.parametrize(("place", "share"), [(START, 0.0), (END, 1.0), (PathPosition(begin=0.4, at=0.5), 0.7)])
def test_a_place_says_how_far_it_is(place: PathPosition, share: float) -> None:
    assert place.share == pytest.approx(share, abs=1e-15)
    assert replace(place, at=1.0).share == 1.0


def test_changed_facts_are_named(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.h5"
    require_same(path, ORIGIN.facts, dict(ORIGIN.facts))
    with pytest.raises(FormatError, match=r"checkpoint\.h5:1: expected seed = 2 as there is now, found 1 as it began"):
        require_same(path, ORIGIN.facts, {**ORIGIN.facts, "seed": 2})
    with pytest.raises(FormatError, match=r"speed = None as there is now"):
        require_same(path, ORIGIN.facts, {"seed": 1, "version.numpy": "2.0"})


def fill(run: RunWriter, count: int) -> None:
    for k in range(count):
        run.append(replace(row(float(k), 0.1, 1, "Stretch"), tag=f"tag {k // 4}"))
        if k % 5 == 0:
            shape = replace(frame(float(k), 0.1, 1, "Stretch"), nodes=np.ones((4, 3)), axial_strain=np.ones(3))
            run.add_frame(replace(shape, bending_strain=np.ones(3), contact_force=np.ones(4)))


def test_a_record_goes_on_from_where_its_checkpoint_says(tmp_path: Path) -> None:
    path, whole = tmp_path / "run.h5", tmp_path / "whole.h5"
    with writer(path) as run:
        fill(run, 12)
        then = run.lengths()
        fill(run, 9)
    assert then["equilibria/time"] == 12
    assert then["tags"] == 3
    assert reaches(path, then)
    with RunWriter(path, then) as run:
        assert run.rows == 12
        assert run.lengths() == then
        fill(run, 3)
    with writer(whole) as run:
        fill(run, 12)
        fill(run, 3)
    one, two = RunReader(path), RunReader(whole)
    assert one.trace.tag == two.trace.tag
    assert one.trace.columns["time"].tolist() == two.trace.columns["time"].tolist()
    assert [shape.time for shape in one.frames()] == [shape.time for shape in two.frames()]
    assert one.outcome == two.outcome
    assert not reaches(path, {**then, "equilibria/time": 99})


def test_counts_in_attributes_are_lengths_too(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file.create_group("Steps").attrs["NSteps"] = 5
        file.create_dataset("Steps/Values", data=np.arange(5.0), maxshape=(None,))
        file["fixed"] = np.arange(3)
        assert lengths(file) == {"Steps@NSteps": 5, "Steps/Values": 5}
        cut(file, {"Steps@NSteps": 2, "Steps/Values": 2})
        assert lengths(file) == {"Steps@NSteps": 2, "Steps/Values": 2}
        assert len(file["fixed"]) == 3


def test_checkpoints_come_at_once_and_then_now_and_then(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clock, written = [100.0], []

    def save_slowly(_path: Path, one: Saved) -> None:
        clock[0] += 0.1
        written.append((clock[0], one.seconds, one.lengths["equilibria/time"]))

    monkeypatch.setattr("app.records.checkpoint.perf_counter", lambda: clock[0])
    monkeypatch.setattr("app.records.checkpoint.save", save_slowly)
    with writer(tmp_path / "run.h5") as run:
        keeper = Keeper(path=tmp_path / "checkpoint.h5", origin=ORIGIN, began=90.0)
        for _ in range(30):
            clock[0] += 1.0
            fill(run, 1)
            keeper.keep(saved().checkpoint, run, [])
    # At once; then, at a tenth of a second each, no more than one in ten seconds.
    assert [rows for _, _, rows in written] == [1, 11, 21]
    assert written[0][1] == pytest.approx(11.0)


HOLD = """
import sys
from pathlib import Path
from app.records.lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.readline()
"""


@pytest.mark.parametrize("end", ["ends", "killed"])
def test_a_folder_is_one_processs_until_it_is_gone(end: str, tmp_path: Path) -> None:
    command = [sys.executable, "-P", "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(  # noqa: S603
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT, env={"PYTHONPATH": str(ROOT)}, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        with pytest.raises(SpecificationError, match="which another process is writing"), locked(tmp_path):
            pytest.fail("held by two")
        if end == "killed":
            process.kill()
        else:
            process.communicate("\n")
    with locked(tmp_path):
        assert (tmp_path / LOCK).exists()
    assert not (tmp_path / LOCK).exists()


def test_a_block_that_fails_gives_the_lock_back(tmp_path: Path) -> None:
    def fail() -> None:
        with locked(tmp_path):
            raise ZeroDivisionError

    attempts: list[Callable[[], None]] = [fail, fail]
    for attempt in attempts:
        with pytest.raises(ZeroDivisionError):
            attempt()


SUM = "import app, numpy; a = numpy.random.default_rng(0).standard_normal(10**6); print(float(numpy.vdot(a, a)).hex())"


def test_long_sums_are_the_same_whatever_threads_there_are() -> None:
    sums = [
        subprocess.run(  # noqa: S603
            [sys.executable, "-P", "-c", SUM],
            env={"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            check=True,
        ).stdout
        for threads in ("1", "2", "3")
    ]
    assert len(sums[0]) > 10
    assert len(set(sums)) == 1
