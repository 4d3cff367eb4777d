"""Exit codes of the program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from app.service.errors import ServiceError, UnreachableError
from knitlab_core.errors import SolverError

if TYPE_CHECKING:
    from app.client import Job
    from app.runs.use_cases import RunResult
    from knitlab_core.errors import KnitlabError

USAGE, SOLVER_FAILED, NO_DATA, UNREACHABLE, NOT_PRINTABLE, UNWRITABLE, INTERRUPTED = 2, 3, 4, 5, 6, 7, 130

_BY_OUTCOME: Final = {"diverged": SOLVER_FAILED, "abort": INTERRUPTED}
_CUT_SHORT: Final = frozenset({"limit", "rupture", "slipped", "timeout", "unravelled"})
_BY_STATE: Final = {"failed": SOLVER_FAILED, "cancelled": INTERRUPTED}


def exit_code(result: RunResult) -> int:
    """Return the exit code of a run: 0 for any outcome with data."""
    if result.outcome in _CUT_SHORT and not result.figures:
        return NO_DATA
    return _BY_OUTCOME.get(result.outcome, 0)


def job_exit_code(job: Job) -> int:
    """Return the exit code of a job that has ended: that of its test, if it has one."""
    if job.state in _BY_STATE:
        return _BY_STATE[job.state]
    if job.end in _CUT_SHORT and not job.progress.rows:
        return NO_DATA
    return 0


def error_exit_code(error: KnitlabError) -> int:
    """Return the exit code of an error."""
    if isinstance(error, UnreachableError) or (isinstance(error, ServiceError) and error.status >= 500):
        return UNREACHABLE
    return SOLVER_FAILED if isinstance(error, SolverError) else USAGE
