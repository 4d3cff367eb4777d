"""Cache of compiled kernels on disk; no state of the disk can harm a run.

numba trusts the files of its cache: an emptied one ends in a traceback, a garbled one inside LLVM. Here every file
begins with a digest of the rest. A file that does not match it is compiled again and replaced; where files cannot be
written the kernels work all the same and are compiled in every process. Each of the two is said once a process.
"""

from __future__ import annotations

import hashlib
import io
import logging
import os
import pickle
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import llvmlite.binding as llvm
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    UserProvidedCacheLocator,
)
from numba.core.environment import Environment, lookup_environment
from numba.core.runtime.nrt import rtsys

if TYPE_CHECKING:
    from collections.abc import Callable

_DIGEST_BYTES: Final = 16
_log: Final = logging.getLogger(__name__)
_said: Final[set[str]] = set()


class _DamagedError(Exception):
    """Report that a file of the cache is not what was written."""


def say_once(kind: str, message: str) -> None:
    """Log a warning unless one of its kind was logged in this process before."""
    if kind not in _said:
        _said.add(kind)
        _log.warning("kernel cache: %s", message)


def not_kept(folder: Path | None, error: Exception) -> None:
    """Write why compiled kernels are not kept in a folder; None where there is none to name."""
    reason = (error.strerror if isinstance(error, OSError) else None) or str(error).rstrip(".")
    where = "" if folder is None else f"{folder}: "
    say_once("unkept", f"{where}{reason.lower()}; kernels are compiled without keeping (KNITLAB_CACHE names a folder)")


def _digest(name: str, data: bytes) -> bytes:
    """Return the digest of a file; its name counts, so that no file can be taken for another."""
    return hashlib.blake2b(name.encode() + b"\0" + data, digest_size=_DIGEST_BYTES).digest()


def _read(path: Path) -> bytes:
    """Return the content after a file's digest.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    _DamagedError
        If it cannot be read or does not match its digest.
    """
    try:
        whole = path.read_bytes()
    except FileNotFoundError:
        raise
    except OSError as error:
        raise _DamagedError from error
    data = whole[_DIGEST_BYTES:]
    if whole[:_DIGEST_BYTES] != _digest(path.name, data):
        raise _DamagedError
    return data


def _environment(_module: str, constants: list[Any], name: str) -> Environment:
    """Return the environment of a compiled function, with its constants alone.

    numba also imports the function's module: for NumPy's functions those of numba that compile them, and SciPy's linear
    algebra with them. Kernels, which are never in object mode, do not look there.
    """
    found = lookup_environment(name)  # type: ignore[no-untyped-call] # numba's own, as below
    if isinstance(found, Environment):
        return found
    made = Environment({})
    made.consts[:] = constants
    made.env_name = name
    Environment._memo[name] = made  # noqa: SLF001 (as numba's own does)
    return made


class _KernelUnpickler(pickle.Unpickler):
    """Load a kernel, and nothing with which numba would compile it."""

    def find_class(self, module: str, name: str) -> Any:  # noqa: ANN401 (whatever is in it)
        """Return the object of a name in a pickle."""
        if (module, name) == ("numba.core.environment", "_rebuild_env"):
            return _environment
        return super().find_class(module, name)


class _File(IndexDataCacheFile):
    """Index and data files of one kernel, each with its digest."""

    def _load_index(self) -> dict[Any, str]:
        """Return the names of the data files by signature; nothing if the index is missing, damaged or outdated."""
        path = Path(self._index_path)
        try:
            version, stamp, overloads = pickle.loads(_read(path))  # noqa: S301 (what this wing wrote: its digest says so)
        except FileNotFoundError:
            return {}
        except _DamagedError:
            self._damaged(path)
            return {}
        return dict(overloads) if (version, stamp) == (self._version, self._source_stamp) else {}

    def _load_data(self, name: str) -> Any:  # noqa: ANN401 (numba's own type)
        path = Path(self._cache_path) / name
        try:
            return _KernelUnpickler(io.BytesIO(_read(path))).load()
        except _DamagedError as error:
            self._damaged(path)
            raise FileNotFoundError(path) from error

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _save_data(self, name: str, data: Any) -> None:  # noqa: ANN401 (numba's own type)
        self._write(os.path.join(self._cache_path, name), data)  # noqa: PTH118 (numba's paths are text)

    def _write(self, path: str, content: object) -> None:
        data: bytes = self._dump(content)  # type: ignore[no-untyped-call] # numba's own
        with self._open_for_write(path) as file:
            file.write(_digest(Path(path).name, data) + data)

    def _damaged(self, path: Path) -> None:
        """Write a line about it, and remove the file so that nothing reads it again."""
        say_once("damaged", f"{path}: damaged, as others may be; compiled again")
        try:
            path.unlink()
        except OSError as error:
            not_kept(path.parent, error)


class _Locator(UserProvidedCacheLocator):
    """The folder of a kernel's source file within the cache, made when there is something to write."""

    def ensure_cache_path(self) -> None:
        """Make no folder and no trial file for every kernel on import; what cannot be written is found when writing."""


def _names_alone(bitcode: bytes) -> bytes:
    """Return a module of LLVM that defines what another does, all of it empty."""
    module = llvm.parse_bitcode(bitcode)
    lines = [f'define void @"{one.name}"() {{ ret void }}' for one in module.functions if not one.is_declaration]
    lines += [f'@"{one.name}" = global i8 0' for one in module.global_variables if not one.is_declaration]
    return bytes(llvm.parse_assembly("\n".join(lines)).as_bitcode())


class _Implementation(CompileResultCacheImpl):
    """What is kept of a kernel: its machine code, and its code of LLVM for kernels that are compiled later and call it.

    numba parses the second whenever it loads the first, which takes longer than all else. It looks for names in it, so
    those are kept a second time, and the whole is parsed when a kernel is linked with it.
    """

    _locator_classes = [_Locator]  # noqa: RUF012 (as numba has it)

    def reduce(self, data: Any) -> Any:  # noqa: ANN401 (numba's own types)
        """Return what is kept of a kernel."""
        (name, kind, (machine_code, bitcode)), *more = super().reduce(data)  # type: ignore[no-untyped-call] # as below
        return bitcode, ((name, kind, (machine_code, _names_alone(bitcode))), *more)

    def rebuild(self, target_context: Any, payload: Any) -> Any:  # noqa: ANN401 (numba's own types)
        """Return a kernel from what was kept of it."""
        bitcode, shortened = payload
        result = super().rebuild(target_context, shortened)  # type: ignore[no-untyped-call] # numba's own
        parse = lru_cache(maxsize=1)(partial(llvm.parse_bitcode, bitcode))
        result.library._get_module_for_linking = parse  # noqa: SLF001 (no other way to have it wait)
        return result


class KernelCache(FunctionCache):
    """Compiled code of one kernel: what numba keeps, and no error of a disk.

    Parameters
    ----------
    function : callable
        The kernel in Python.
    """

    _impl_class = _Implementation

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call] # numba's own
        self._cache_file = _File(  # type: ignore[no-untyped-call] # numba's own
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self._impl.locator.get_source_stamp(),
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:  # noqa: ANN401 (numba's own types)
        """Return a kernel that was kept, or None.

        numba would first load all that it can compile, which takes as long as the kernels of a run do; a kernel that
        has to be compiled after all has numba do it then.
        """
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call] # numba's own

    def save_overload(self, sig: Any, data: Any) -> None:  # noqa: ANN401 (numba's own types)
        """Keep what was compiled; where that fails, write one line and keep nothing more in this process."""
        if "unkept" in _said:
            return
        try:
            os.makedirs(self._cache_path, exist_ok=True)  # noqa: PTH103 (numba's paths are text)
            super().save_overload(sig, data)  # type: ignore[no-untyped-call] # numba's own
        except OSError as error:
            not_kept(Path(self._cache_path).parent, error)
