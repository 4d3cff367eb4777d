"""Make every compiled kernel, here and nowhere else.

numba's on-disk cache looks only at the file of a kernel: edit a function it *calls* in another
file and the old machine code is loaded again. So the cache folder is named by a hash of all files of
kernels together; any edit starts a fresh folder. Compiled code is the only thing this wing writes.

A constant that a kernel uses is compiled into it, so it must be in a file of kernels too.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

import llvmlite.binding as llvm
import numba
import numpy as np
from numba.core.registry import CPUDispatcher

from knitlab_core.kernel_cache import KernelCache, not_kept

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

FunctionT = TypeVar("FunctionT", bound="Callable[..., Any]")

UNUSED_DAYS: Final = 30.0
"""Age [days] at which the compiled code of an older source is removed."""

# Results must have the same bits on every x86-64 processor. Reciprocals in place of divisions are
# chosen by processor, so kernels write out those that pay. Contraction gains nothing and would cost
# exact identities (a x a = 0); NaN and infinity must keep their meaning.
FASTMATH: Final = frozenset({"nsz"})

_SOURCE_ROOT: Final = Path(__file__).resolve().parent
_KERNEL_FILE: Final = re.compile(
    rb"^(?:from knitlab_core\.jit import|from knitlab_core import .*\bjit\b|import knitlab_core\.jit)", re.MULTILINE
)
_COMPILER_FILES: Final = frozenset({"jit.py", "kernel_cache.py", "angles.py"})
"""Files that kernels are made from or kept by without a word of this one in them."""
_FOLDER: Final = re.compile(r"kernels-[0-9a-f]{16}")
_defined: list[str] = []
_settings: Final[Any] = numba.config

# Straight-line code on 4 x 4 blocks becomes vector code: the factor takes half the time. It is read
# when a kernel is first called, so it cannot be set around a decorator.
_settings.SLP_VECTORIZE = 1


def user_cache_directory(environment: Mapping[str, str], system: str) -> Path:
    """Return the folder in which knitlab may keep what it can compute again.

    Parameters
    ----------
    environment : Mapping[str, str]
        Environment variables; ``KNITLAB_CACHE`` overrides the rule of the system.
    system : str
        Name of the system as ``sys.platform`` gives it.

    Examples
    --------
    >>> user_cache_directory({"KNITLAB_CACHE": "here"}, "linux").name
    'here'
    """
    if chosen := environment.get("KNITLAB_CACHE"):
        return Path(chosen).expanduser()
    if system == "win32":
        base = environment.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif system == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = environment.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "knitlab"


def kernel_files(root: Path) -> list[Path]:
    """Return the files under a package that define kernels or compile and keep them, sorted.

    Parameters
    ----------
    root : Path
        Folder of the ``knitlab_core`` package.
    """
    files = sorted(root.rglob("*.py"))
    own = {root / name for name in _COMPILER_FILES}
    return [file for file in files if file in own or _KERNEL_FILE.search(file.read_bytes())]


def source_hash(root: Path) -> str:
    """Return 16 hexadecimal digits that change with any kernel source, compiler or processor.

    Parameters
    ----------
    root : Path
        Folder of the ``knitlab_core`` package; its place counts, as numba files by it.
    """
    digest = hashlib.sha256()
    target = _settings.CPU_NAME or llvm.get_host_cpu_name(), _settings.CPU_FEATURES or ""
    versions = (platform.python_version(), numba.__version__, np.__version__, *target, str(root))
    digest.update("\n".join(versions).encode())
    for file in kernel_files(root):
        content = file.read_bytes()
        digest.update(f"\n{file.relative_to(root).as_posix()} {len(content)}\n".encode())
        digest.update(content)
    return digest.hexdigest()[:16]


def remove_unused(cache: Path, now: float) -> None:
    """Remove compiled code that no run has touched for `UNUSED_DAYS`.

    Parameters
    ----------
    cache : Path
        Folder that holds one ``kernels-<hash>`` folder per state of the sources.
    now : float
        Time now [s since the epoch].
    """
    for folder in cache.iterdir():
        try:
            age = now - folder.stat().st_mtime
        except FileNotFoundError:  # another process was quicker
            continue
        if _FOLDER.fullmatch(folder.name) and age > UNUSED_DAYS * 86400.0:
            shutil.rmtree(folder, ignore_errors=True)


def _prepare() -> Path | None:
    """Create and mark as used the folder of these sources; None where nothing can be written, which is said."""
    folder = None
    try:
        cache = user_cache_directory(os.environ, sys.platform)
        folder = cache / f"kernels-{source_hash(_SOURCE_ROOT)}"
        folder.mkdir(parents=True, exist_ok=True)
        remove_unused(cache, time.time())
        os.utime(folder)
    except (OSError, RuntimeError) as error:  # a user without a home folder raises the second
        if not _readable(folder):
            not_kept(folder, error)
            return None
    return folder


def _readable(folder: Path | None) -> bool:
    """Return whether a folder that is not written to holds kernels to load all the same."""
    try:
        return folder is not None and any(folder.iterdir())
    except OSError:
        return False


CACHE_FOLDER: Final = _prepare()
"""Where compiled kernels are kept; None compiles them in every process."""


class _Kernel(CPUDispatcher):
    """A compiled function that is compiled once for whole numbers, be they variables or constants of its callers."""

    def enable_caching(self) -> None:
        """Keep what is compiled where a damaged file or a full disk does no harm."""
        self._cache = KernelCache(self.py_func)

    def get_call_template(self, args: Any, kws: Any) -> Any:  # noqa: ANN401 (numba's own types)
        """Return how a kernel calls this one; by itself numba would compile again for each constant argument."""
        plain: Any = numba.types.unliteral
        return super().get_call_template(
            tuple(plain(kind) for kind in args), {name: plain(kind) for name, kind in dict(kws).items()}
        )


class _InnerKernel(_Kernel):
    """A kernel without an entry for Python, which takes longer to compile than a short kernel itself.

    A call from Python goes through an outer kernel, compiled in that process and not kept.
    """

    _outer: Callable[..., Any] | None = None

    def __call__(self, *arguments: Any) -> Any:  # noqa: ANN401 (whatever the kernel takes)
        """Call the kernel from Python, as tests do."""
        if self._outer is None:
            inner = self

            def outer(*arguments: Any) -> Any:  # noqa: ANN401
                return inner(*arguments)

            self._outer = _Kernel(outer, targetoptions=_options())
        return self._outer(*arguments)


def _options(**more: bool) -> dict[str, Any]:
    """Return the options of the compiler that every kernel shares, and more."""
    return {
        "nopython": True,
        "boundscheck": None,
        "error_model": "numpy",
        "nogil": True,
        "fastmath": set(FASTMATH),
        "no_cfunc_wrapper": True,  # no kernel is called from C
        **more,
    }


def _compile(function: FunctionT, dispatcher: type[_Kernel], **more: bool) -> FunctionT:
    """Wrap a function for compilation when it is first called."""
    _defined.append(function.__qualname__)
    compiled = dispatcher(function, targetoptions=_options(**more))
    if CACHE_FOLDER is not None:
        before = _settings.CACHE_DIR
        _settings.CACHE_DIR = str(CACHE_FOLDER)
        try:
            compiled.enable_caching()
        finally:  # other users of numba in this process keep their own place
            _settings.CACHE_DIR = before
    return cast("FunctionT", compiled)


def kernel(function: FunctionT) -> FunctionT:
    """Compile a function of scalars, tuples and arrays, once per machine.

    Division by zero gives infinity or NaN instead of raising, and the interpreter's lock is released.

    Parameters
    ----------
    function : callable
        A function that never raises and never allocates inside its loops.
    """
    return _compile(function, _Kernel)


def inner_kernel(function: FunctionT) -> FunctionT:
    """Compile a function that only kernels call; it takes less to compile than one that Python calls too.

    Parameters
    ----------
    function : callable
        As for `kernel`.
    """
    return _compile(function, _InnerKernel, no_cpython_wrapper=True)


def inline_kernel(function: FunctionT) -> FunctionT:
    """Compile a tiny function of scalars and tuples, always inlined into the kernels that call it.

    Parameters
    ----------
    function : callable
        A few lines of arithmetic, such as a dot product.
    """
    return _compile(function, _InnerKernel, no_cpython_wrapper=True, forceinline=True)


def cache_is_cold() -> bool:
    """Return whether most of the kernels defined so far have yet to be compiled on this machine."""
    if CACHE_FOLDER is None:
        return True
    compiled = sum(1 for _ in CACHE_FOLDER.rglob("*.nbi"))
    return compiled == 0 or 2 * compiled < len(_defined)
