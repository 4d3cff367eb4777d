"""A second process compiles what the first run needs last, and is gone when the run is."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from app.runs import compile_ahead
from app.runs.compile_ahead import compiling_beside
from knitlab_core.equilibrium import pattern
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.first_calls import call_search
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.rods import stiffness
from knitlab_core.sparse import cholesky, minimum_degree, ordering, sums, supernodes
from tests.knitlab_core.equilibrium.strands import strand, stretched

ROOT = Path(__file__).parents[3]


def children() -> set[int]:
    return {process.pid for process in psutil.Process().children(recursive=True)}


def test_what_is_compiled_ahead_is_what_a_search_calls() -> None:
    call_search()
    model, state = strand()
    found, _ = advance(Workspace(model), state, stretched(state, 0.01))
    assert found is not None
    kernels = {
        kernel.py_func.__qualname__: kernel
        for module in (cholesky, minimum_degree, ordering, pattern, sums, supernodes, stiffness)
        for kernel in vars(module).values()
        if getattr(kernel, "signatures", None) and kernel.py_func.__module__ == module.__name__
    }
    assert {"_factor", "_order", "rod_hessian", "_solve_up", "_fill_rows"} <= set(kernels)
    twice = {name: kernel.signatures for name, kernel in kernels.items() if len(kernel.signatures) > 1}
    assert not twice, "compiled ahead for other types than a search has"


@pytest.mark.parametrize("why", ["no cache", "one thread", "warm"])
def test_no_process_is_started_where_it_cannot_help(monkeypatch: pytest.MonkeyPatch, why: str) -> None:
    monkeypatch.setattr(compile_ahead, "CACHE_FOLDER", None if why == "no cache" else Path())
    monkeypatch.setattr(compile_ahead, "thread_count", lambda: 1 if why == "one thread" else 2)
    monkeypatch.setattr(compile_ahead, "cache_is_cold", lambda: why != "warm")
    before = children()
    with compiling_beside():
        assert children() <= before


@pytest.mark.parametrize("killed", [False, True])
def test_the_process_does_not_outlive_the_run(tmp_path: Path, *, killed: bool) -> None:
    code = (
        "import psutil, sys\n"
        "from app.runs.compile_ahead import compiling_beside\n"
        "with compiling_beside():\n"
        "    print(*(child.pid for child in psutil.Process().children()), flush=True)\n"
        "    sys.stdin.readline()\n"
    )
    parent = subprocess.Popen(  # noqa: S603
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT), "KNITLAB_CACHE": str(tmp_path), "KNITLAB_THREADS": "2"},
    )
    assert parent.stdout is not None
    (child,) = (psutil.Process(int(pid)) for pid in parent.stdout.readline().split())
    if killed:
        parent.kill()
    parent.communicate("\n" if not killed else None)
    assert not [process for process in psutil.wait_procs([child], timeout=60.0)[1] if process.is_running()]
    assert parent.returncode == (-9 if killed else 0)
