"""The scoreboard as a whole: tests run, rows scored."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.records.folder import RECORD
from app.records.reader import RunReader
from app.runs.use_cases import has_ended
from app.studies.scoreboard.analysed import analysed, printed
from app.studies.scoreboard.plan import FOLDER, FULL, QUICK, all_tests
from app.studies.scoreboard.rows import ROWS
from app.studies.scoreboard.runs import command_of, folder_of, loaded_tests, run_tests
from knitlab_core.errors import KnitlabError, SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.runs.publishing import Progress
    from app.schemas import Loaded
    from app.studies.scoreboard.analysed import Analysed
    from app.studies.scoreboard.plan import Test
    from app.studies.scoreboard.rows import Row
    from app.studies.scoreboard.verdict import Score, Verdict

VERDICTS: Final[tuple[Verdict, ...]] = ("reproduced", "differs", "not scorable")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """A row with its score, the command that repeats it, and the runs behind it."""

    row: Row
    score: Score
    command: str
    runs: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Board:
    """Rows with their scores.

    Attributes
    ----------
    rows : tuple of Scored
        The rows, by number.
    runs : Mapping
        The tests that were run, by name.
    failed : Mapping
        Why tests could not be run, by name.
    quick : bool
        Whether its specimens are the small ones.
    """

    rows: tuple[Scored, ...]
    runs: Mapping[str, Analysed]
    failed: Mapping[str, str]
    quick: bool

    def count(self, verdict: Verdict, *, fitted: bool | None = None) -> int:
        """Return how many rows have a verdict; of those that were fitted, or were not, if it is said."""
        rows = [one for one in self.rows if one.score.verdict == verdict]
        return sum(fitted is None or bool(one.row.fitted) == fitted for one in rows)


def make_board(
    protocols: Path,
    out: Path,
    progress: Progress,
    *,
    quick: bool = False,
    numbers: Sequence[int] = (),
    jobs: int = 1,
    run: bool = True,
) -> Board:
    """Run the tests that rows need and that are not done, and score the rows.

    Parameters
    ----------
    protocols, out : Path
        Folder of the protocols, and of the runs.
    progress : callable
        Told the share done [1] and what is being done.
    quick : bool
        Small specimens and coarse meshes.
    numbers : sequence of int
        Rows that are wanted; all if there are none.
    jobs : int
        Processes that run at once.
    run : bool
        Whether to run what is missing; otherwise rows are scored from the runs that are there.

    Raises
    ------
    SpecificationError
        For a row that there is not, or a protocol that is wrong.
    """
    rows = _wanted(numbers)
    tests = [test for test in all_tests(QUICK if quick else FULL).values() if any(row.needs(test.name) for row in rows)]
    loaded = loaded_tests(protocols, tests)
    folders = {name: folder_of(out, name, one) for name, one in loaded.items()}
    out.mkdir(parents=True, exist_ok=True)
    simulated = {test: loaded[test.name] for test in tests if test.simulated}
    failed = run_tests(protocols, simulated, folders, progress, jobs) if run else {}
    progress(1.0, "scoring")
    runs = _read(tests, loaded, folders, failed)
    scored = tuple(_scored(row, runs, failed, protocols, tests, quick=quick) for row in rows)
    return Board(rows=scored, runs=runs, failed=failed, quick=quick)


def _wanted(numbers: Sequence[int]) -> list[Row]:
    known = {row.number for row in ROWS}
    for number in numbers:
        if number not in known:
            raise SpecificationError("--row", number, f"a whole number from 1 to {len(ROWS)}")
    return [row for row in ROWS if not numbers or row.number in numbers]


def _read(
    tests: Sequence[Test], loaded: Mapping[str, Loaded], folders: Mapping[str, Path], failed: dict[str, str]
) -> dict[str, Analysed]:
    """Return the tests that were done, and add to `failed` why others cannot be read."""
    found = {}
    for test in tests:
        try:
            if not test.simulated:
                found[test.name] = printed(test.name, loaded[test.name].protocol)
            elif (folders[test.name] / RECORD).exists():
                record = RunReader(folders[test.name] / RECORD)
                if has_ended(record) is None or len(record.trace) < 2:
                    failed.setdefault(test.name, record.outcome.message or "not finished")
                else:
                    found[test.name] = analysed(test.name, record)
        except KnitlabError as error:
            failed.setdefault(test.name, str(error))
    return found


def _scored(
    row: Row,
    runs: Mapping[str, Analysed],
    failed: Mapping[str, str],
    protocols: Path,
    tests: Sequence[Test],
    *,
    quick: bool,
) -> Scored:
    needed = [test for test in tests if row.needs(test.name)]
    command = f"knitlab scoreboard --row {row.number}{' --quick' * quick}"
    if protocols != Path(FOLDER):
        command += f" --protocols {protocols}"
    return Scored(
        row=row,
        score=row.scored(runs, failed),
        command=command,
        runs=tuple(command_of(protocols, test) for test in needed),
    )
