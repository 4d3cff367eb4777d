"""Pictures are drawn once, beside the run, and whoever draws them ends with it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import psutil
import pytest

from app.views.drawing import Drawer, drawer
from tests.synthetic_run import make_run

if TYPE_CHECKING:
    from app.records.reader import RunReader

ROOT = Path(__file__).parents[3]
QUICK = """\
schema: knitlab/protocol@1
name: quick
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 16}
speed_ref: pair
others: hold
log: {rate: 1 Hz, noise: off}
steps:
  - cycle: {axes: [C, W], lower: 0, upper: 2 %, rate: 0.2 mm/s, n: 1}
"""
PICTURES = {"name_stress_strain.png", "name_knit.png"}


@pytest.fixture
def run(tmp_path: Path) -> RunReader:
    return make_run(tmp_path / "run.h5")


def process_of(one: Drawer) -> psutil.Process:
    assert one._process is not None
    return psutil.Process(one._process.pid)


def wait_gone(processes: list[psutil.Process]) -> list[psutil.Process]:
    """Return those that are still there after a while."""
    return [process for process in psutil.wait_procs(processes, timeout=60.0)[1] if process.is_running()]


def pictures_in(folder: Path) -> set[str]:
    return {path.name for path in folder.glob("*.png")}


def test_a_process_draws_what_it_is_asked_for_and_ends(run: RunReader) -> None:
    with Drawer() as draw:
        process = process_of(draw)
        wait = draw(run, "name")
        wait()
        assert pictures_in(run.path.parent) == PICTURES
    assert not wait_gone([process])


def test_where_the_process_is_killed_this_one_draws(run: RunReader) -> None:
    with Drawer() as draw:
        process = process_of(draw)
        process.kill()
        process.wait()
        draw(run, "name")()
    assert pictures_in(run.path.parent) == PICTURES


def test_a_process_that_draws_does_not_outlive_the_one_that_wanted_it() -> None:
    code = (
        "import time; from app.views.drawing import Drawer\nprint(Drawer()._process.pid, flush=True); time.sleep(600.0)"
    )
    parent = subprocess.Popen(  # noqa: S603
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert parent.stdout is not None
    child = psutil.Process(int(parent.stdout.readline()))
    parent.kill()
    parent.communicate()
    assert not wait_gone([child])


def test_no_process_is_started_for_no_pictures() -> None:
    before = {process.pid for process in psutil.Process().children(recursive=True)}
    with drawer(wanted=False) as draw:
        assert draw is None
        assert {process.pid for process in psutil.Process().children(recursive=True)} <= before


@pytest.mark.parametrize("pictures", [False, True])
def test_a_command_says_the_time_it_took_and_draws_once(tmp_path: Path, *, pictures: bool) -> None:
    (tmp_path / "quick.yaml").write_text(QUICK, encoding="utf-8")
    # What would draw in this process fails: the pictures can only come from the other (kernels are compiled by then).
    code = (
        "import sys, app.views.drawing; app.views.drawing.draw_pictures = None\n"
        "from app.cli.main import main; sys.argv[0] = 'knitlab'; main()"
    )
    words = ["run", "quick.yaml", "--out", "run", "--quiet", "--json", *([] if pictures else ["--no-pictures"])]
    began = time.perf_counter()
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-c", code, *words],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    took = time.perf_counter() - began
    figures = {figure["name"]: figure["value"] for figure in json.loads(done.stdout)["figures"]}
    assert figures["solver time"] < figures["wall time"] < took
    drawn = {"quick_stress_strain.png", "quick_knit.png"} if pictures else set()
    assert pictures_in(tmp_path / "run") == drawn


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C of a terminal goes to a group of processes there too")
def test_ctrl_c_in_a_terminal_does_not_reach_the_process_that_draws() -> None:
    with Drawer() as draw:
        assert os.getpgid(process_of(draw).pid) != os.getpgid(0)
