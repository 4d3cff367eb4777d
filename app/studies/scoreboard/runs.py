"""Runs of the scoreboard: each test in a folder of its own, found again by the checksum of its protocol."""

from __future__ import annotations

import hashlib
import json
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TYPE_CHECKING

from app.file_names import file_stem
from app.runs.sweeps import is_done
from app.schemas import load, to_data
from app.studies.fit_runs import run_one
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from app.runs.publishing import Progress
    from app.schemas import Loaded
    from app.schemas.document import Data
    from app.studies.scoreboard.plan import Test

MOST_JOBS = 64


def loaded_tests(protocols: Path, tests: Iterable[Test]) -> dict[str, Loaded]:
    """Return the protocol of each test by its name.

    Raises
    ------
    SpecificationError
        If the folder is not there, or a protocol is wrong.
    """
    if not protocols.is_dir():
        expected = "the folder of the paper's protocols, examples/paper of the repository; --protocols names it"
        raise SpecificationError("--protocols", str(protocols), expected)
    return {test.name: load(protocols / test.protocol, dict(test.values)) for test in tests}


def folder_of(out: Path, name: str, loaded: Loaded) -> Path:
    """Return the folder of a test: its name, and a checksum of what its protocol and materials say."""
    said = json.dumps(to_data(loaded.protocol), sort_keys=True) + loaded.materials
    return out / f"{file_stem(name.replace(' ', '_'))}-{hashlib.sha256(said.encode()).hexdigest()[:10]}"


def run_tests(
    protocols: Path, tests: Mapping[Test, Loaded], folders: Mapping[str, Path], progress: Progress, jobs: int
) -> dict[str, str]:
    """Run the tests that are not done, the longest first, and return what could not be run, and why.

    Parameters
    ----------
    protocols : Path
        Folder of the protocols.
    tests : Mapping
        The tests with their protocols.
    folders : Mapping
        Folder of each test by its name.
    progress : callable
        Told the share done [1] and what is being done.
    jobs : int
        Processes that run at once.

    Raises
    ------
    KeyboardInterrupt
        If a run was interrupted; those that are done are kept, and the others go on with the same command.
    SpecificationError
        For another number of processes.
    """
    if not 1 <= jobs <= MOST_JOBS:
        raise SpecificationError("--jobs", jobs, f"a whole number from 1 to {MOST_JOBS}")
    every = sum(test.weight for test in tests)
    todo = [test for test, loaded in tests.items() if not is_done(folders[test.name], loaded)]
    todo.sort(key=lambda test: -test.weight)
    done = every - sum(test.weight for test in todo)
    progress(done / every if every else 1.0, f"{len(tests) - len(todo)} of {len(tests)} tests done before")
    failed: dict[str, str] = {}
    for count, (test, end, message) in enumerate(_all_of(protocols, todo, folders, jobs), 1):
        if end == "abort":
            raise KeyboardInterrupt
        if not end:
            failed[test.name] = message
        done += test.weight
        progress(done / every, f"{count} of {len(todo)}: {test.name} done")
    return failed


def _all_of(
    protocols: Path, todo: Sequence[Test], folders: Mapping[str, Path], jobs: int
) -> Iterator[tuple[Test, str, str]]:
    """Run tests, and yield each with its end and message."""
    tasks = [(test, _task(protocols, test, folders)) for test in todo]
    if jobs == 1:
        for test, task in tasks:
            yield test, *run_one(task)
        return
    with ProcessPoolExecutor(max_workers=jobs, mp_context=get_context("spawn")) as pool:
        running = {pool.submit(run_one, task): test for test, task in tasks}
        try:
            for one in as_completed(running):
                yield running[one], *one.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _task(protocols: Path, test: Test, folders: Mapping[str, Path]) -> tuple[Path, Path, Mapping[str, Data]]:
    return protocols / test.protocol, folders[test.name], dict(test.values)


def command_of(protocols: Path, test: Test) -> str:
    """Return the command that runs a test by itself."""
    chosen = "".join(f" --set {name}={_quoted(value)}" for name, value in test.values.items())
    return f"knitlab run {protocols / test.protocol}{chosen}"


def _quoted(value: object) -> str:
    return f'"{value}"' if " " in str(value) else str(value)
