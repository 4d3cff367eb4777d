"""No state of a disk keeps a kernel from giving its value, and what is wrong is said in one line."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.knitlab_core.test_jit import RUN, package

if TYPE_CHECKING:
    from collections.abc import Callable

CHANCE = random.Random(25)  # noqa: S311 (not for secrets)
# The limit comes after numba is there: it may write bytecode of its own.
SMALL_FILES = "import numba, resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
NOBODY = "import numba, os; os.setgid(54321); os.setuid(54321)\n"


def run(root: Path, before: str = "", **environment: str) -> tuple[list[str], list[str]]:
    """Return what the kernel of the package came to, and the lines that were said."""
    home = {
        name: value for name, value in os.environ.items() if name not in {"HOME", "XDG_CACHE_HOME", "KNITLAB_CACHE"}
    }
    home |= {"PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    done = subprocess.run(  # noqa: S603 - our own interpreter on our own text
        [sys.executable, "-c", before + RUN], cwd=root, env=home, check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split(), done.stderr.splitlines()


def runs_as_nobody(folder: str) -> bool:
    """Tell whether a user without a name can start this interpreter at all."""
    command = [sys.executable, "-c", NOBODY + "import ctypes, json, xml.dom"]
    return not subprocess.run(command, cwd=folder, capture_output=True, check=False).returncode  # noqa: S603


@pytest.mark.slow
def test_damaged_files_are_compiled_again_with_a_word(tmp_path: Path) -> None:
    package(tmp_path)
    cache = tmp_path / "Cache"
    assert run(tmp_path, KNITLAB_CACHE=str(cache)) == (["True", "3.0", "0", "False"], [])
    harms: list[tuple[str, Callable[[bytes], bytes]]] = [
        ("*.nbi", lambda _: b""),
        ("*.nbc", lambda whole: CHANCE.randbytes(len(whole))),
        ("*.nbi", lambda whole: whole[: len(whole) // 2]),
        ("*.nbc", lambda whole: whole[:-40] + b"x" * 40),
    ]
    for files, harm in harms:
        for path in cache.rglob(files):
            path.write_bytes(harm(path.read_bytes()))
        (cold, value, hits, _), said = run(tmp_path, KNITLAB_CACHE=str(cache))
        assert (cold, value, hits) == ("False", "3.0", "0")
        (line,) = said
        assert line.startswith(f"kernel cache: {cache}")
        assert "damaged" in line
    assert run(tmp_path, KNITLAB_CACHE=str(cache)) == (["False", "3.0", "1", "False"], [])
    # A whole file under another's name is damage too: it is the code of another kernel.
    one, two = sorted(cache.rglob("*.nbc"))
    one.write_bytes(two.read_bytes())
    (_, value, _, _), said = run(tmp_path, KNITLAB_CACHE=str(cache))
    assert value == "3.0"


@pytest.mark.skipif(sys.platform == "win32", reason="limits of file sizes are Unix")
def test_a_cache_without_room_is_done_without(tmp_path: Path) -> None:
    package(tmp_path)
    (_, value, _, _), said = run(tmp_path, SMALL_FILES, KNITLAB_CACHE=str(tmp_path / "Cache"))
    assert value == "3.0"
    (line,) = said
    assert "Cache" in line
    assert "file too large; kernels are compiled without keeping" in line
    assert not [path for path in (tmp_path / "Cache").rglob("*") if path.is_file()]


@pytest.mark.skipif(
    sys.platform == "win32" or os.geteuid() != 0, reason="to be a user without a name takes the rights of root"
)
@pytest.mark.parametrize("where", [{}, {"HOME": "/"}, {"HOME": "/nonexistent"}, {"KNITLAB_CACHE": "/Cache"}])
def test_a_user_without_name_and_home_compiles_without_keeping(where: dict[str, str]) -> None:
    with tempfile.TemporaryDirectory() as folder:  # pytest's own are closed to others
        Path(folder).chmod(0o755)
        package(Path(folder))
        if not runs_as_nobody(folder):
            pytest.skip("others may not read this interpreter")
        (cold, value, _, _), said = run(Path(folder), NOBODY, **where)
    assert (cold, value) == ("True", "3.0")
    (line,) = said
    assert "kernels are compiled without keeping" in line


@pytest.mark.skipif(sys.platform == "win32", reason="accounts are Unix")
def test_without_any_home_kernels_are_compiled_without_keeping(tmp_path: Path) -> None:
    package(tmp_path)
    unknown = "import pwd\ndef unknown(_):\n    raise KeyError('uid not found')\npwd.getpwuid = unknown\n"
    (cold, value, _, _), said = run(tmp_path, unknown)
    assert (cold, value) == ("True", "3.0")
    (line,) = said
    assert line.startswith("kernel cache: could not determine home directory")


def test_a_kernel_that_was_kept_is_linked_with_one_that_is_compiled_anew(tmp_path: Path) -> None:
    package(tmp_path)
    cache = tmp_path / "Cache"
    assert run(tmp_path, KNITLAB_CACHE=str(cache))[0][1] == "3.0"
    kept = sorted(path.name for path in cache.rglob("*.nbc"))
    callers = [path for path in cache.rglob("*") if path.name.startswith("caller.once_more")]
    assert len(callers) == len(kept) == 2
    for path in callers:
        path.unlink()
    assert run(tmp_path, KNITLAB_CACHE=str(cache)) == (["False", "3.0", "0", "False"], [])
    assert run(tmp_path, KNITLAB_CACHE=str(cache)) == (["False", "3.0", "1", "False"], [])


NUMPY = """
import numpy as np
from knitlab_core.jit import kernel

@kernel
def largest(values):
    return np.max(np.sort(values)) + np.sqrt(np.sum(values * values)) + np.full(3, 1.0).sum()
"""


def test_a_kernel_that_was_kept_loads_nothing_that_compiles(tmp_path: Path) -> None:
    core = package(tmp_path)
    (core / "caller.py").write_text(NUMPY)
    code = (
        "import sys, numpy as np\nfrom knitlab_core import caller\nprint(caller.largest(np.array([3.0, 4.0])))\n"
        "print({'numba.np.arraymath', 'scipy.linalg', 'numba.cpython.unicode'} & set(sys.modules) == set())"
    )
    environment = os.environ | {"KNITLAB_CACHE": str(tmp_path / "Cache"), "PYTHONPATH": str(tmp_path)}
    for loaded in ("False", "True"):
        done = subprocess.run(  # noqa: S603 - our own interpreter on our own text
            [sys.executable, "-c", code], cwd=tmp_path, env=environment, check=True, capture_output=True, text=True
        )
        assert done.stdout.split() == ["12.0", loaded]
