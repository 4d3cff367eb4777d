"""Compiled code must follow its sources."""

from __future__ import annotations

import ast
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from knitlab_core import jit

ROOT = Path(__file__).parents[2]
CALLEE = "from knitlab_core.jit import inline_kernel\n\n@inline_kernel\ndef twice(x):\n    return {factor} * x\n"
CALLER = (
    "from knitlab_core.callee import twice\nfrom knitlab_core.jit import kernel\n\n"
    "@kernel\ndef once_more(x):\n    return twice(x) + 1.0\n"
)
RUN = (
    "from knitlab_core import caller, jit\ncold = jit.cache_is_cold()\nvalue = caller.once_more(1.0)\n"
    "print(cold, value, sum(caller.once_more.stats.cache_hits.values()), jit.cache_is_cold())"
)


def package(root: Path) -> Path:
    """Copy the compiler's files into a package with one caller and one callee."""
    core = root / "knitlab_core"
    core.mkdir()
    (core / "__init__.py").touch()
    for name in ("jit.py", "kernel_cache.py"):
        (core / name).write_bytes((ROOT / "knitlab_core" / name).read_bytes())
    (core / "caller.py").write_text(CALLER)
    (core / "callee.py").write_text(CALLEE.format(factor=2.0))
    return core


def run(root: Path, cache: Path) -> list[str]:
    environment = os.environ | {"KNITLAB_CACHE": str(cache), "PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(  # noqa: S603 - our own interpreter on our own text
        [sys.executable, "-c", RUN], cwd=root, env=environment, check=True, capture_output=True, text=True
    )
    return done.stdout.split()


def test_caller_follows_a_callee_edited_in_another_file(tmp_path: Path) -> None:
    core, cache = package(tmp_path), tmp_path / "cache"
    assert run(tmp_path, cache) == ["True", "3.0", "0", "False"]
    assert run(tmp_path, cache) == ["False", "3.0", "1", "False"], "the second process loads compiled code"
    (core / "callee.py").write_text(CALLEE.format(factor=5.0))
    assert run(tmp_path, cache) == ["True", "6.0", "0", "False"]


def test_without_a_writable_cache_kernels_still_run(tmp_path: Path) -> None:
    package(tmp_path)
    occupied = tmp_path / "a file"
    occupied.touch()
    assert run(tmp_path, occupied) == ["True", "3.0", "0", "True"]


def test_hash_sees_kernel_sources_only(tmp_path: Path) -> None:
    core = package(tmp_path)
    before = jit.source_hash(core)
    (core / "prose.py").write_text('"""No kernels here."""\n')
    assert jit.source_hash(core) == before
    (core / "callee.py").write_text(CALLEE.format(factor=3.0))
    assert jit.source_hash(core) != before


def test_old_folders_go_and_others_stay(tmp_path: Path) -> None:
    day, now = 86400.0, 1e9
    ages = {"kernels-0123456789abcdef": 31.0, "kernels-fedcba9876543210": 29.0, "someone else's": 99.0}
    for name, age in ages.items():
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (now - age * day, now - age * day))
    jit.remove_unused(tmp_path, now)
    assert {path.name for path in tmp_path.iterdir()} == {"kernels-fedcba9876543210", "someone else's"}


@pytest.mark.parametrize(
    ("environment", "system", "expected"),
    [
        ({"KNITLAB_CACHE": "/k", "XDG_CACHE_HOME": "/x"}, "linux", "/k"),
        ({"XDG_CACHE_HOME": "/x"}, "linux", "/x/knitlab"),
        ({}, "linux", "~/.cache/knitlab"),
        ({}, "darwin", "~/Library/Caches/knitlab"),
        ({"LOCALAPPDATA": "/l"}, "win32", "/l/knitlab"),
        ({}, "win32", "~/AppData/Local/knitlab"),
    ],
)
def test_cache_stands_where_each_system_keeps_caches(environment: dict[str, str], system: str, expected: str) -> None:
    assert jit.user_cache_directory(environment, system) == Path(expected).expanduser()


def test_arithmetic_keeps_infinity_and_exact_identities() -> None:
    @jit.kernel
    def ratio(x: float, y: float) -> float:
        return x / y

    @jit.kernel
    def self_cross(y: float, z: float) -> float:
        return y * z - z * y

    assert ratio(1.0, 0.0) == math.inf
    assert math.isnan(ratio(0.0, 0.0))
    assert self_cross(0.1, 0.3) == 0.0


def test_kernel_files_take_constants_from_kernel_files_only() -> None:
    core = ROOT / "knitlab_core"
    kernels = jit.kernel_files(core)
    assert core / "jit.py" in kernels
    for file in kernels:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("knitlab_core"):
                source = ROOT / f"{(node.module or '').replace('.', '/')}.py"
                constants = [alias.name for alias in node.names if alias.name.isupper()]
                assert not constants or source in kernels, f"{file}: {constants} would be frozen into compiled code"


@jit.inner_kernel
def _shifted(x: float, by: int) -> float:
    return x + by


@jit.kernel
def _shifted_thrice(x: float, by: int) -> float:
    return _shifted(_shifted(_shifted(x, by), 1), 2)


def test_an_inner_kernel_is_compiled_once_for_constants_and_variables_and_python_can_call_it() -> None:
    assert _shifted_thrice(1.0, 4) == 8.0
    assert _shifted(1.0, 2) == 3.0
    # Where the kernel around it was kept by an earlier run, Python's call is the first that compiles it.
    assert len(_shifted.signatures) == 1  # type: ignore[attr-defined]
