"""Say what the program's exit codes mean."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from app.usecases import RunResult

USAGE, SOLVER_FAILED, NO_DATA, NOT_PRINTABLE, INTERRUPTED = 2, 3, 4, 5, 130

_BY_OUTCOME: Final = {"diverged": SOLVER_FAILED, "abort": INTERRUPTED}


def exit_code(result: RunResult) -> int:
    """Return the exit code of a run: an outcome with data is a success, whatever ended it."""
    if result.outcome in {"limit", "rupture", "timeout"} and not result.figures:
        return NO_DATA
    return _BY_OUTCOME.get(result.outcome, 0)
