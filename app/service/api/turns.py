"""Let requests for what takes seconds of a processor wait in a line that is short."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from anyio import CapacityLimiter

from app.service.api.problems import ProblemError


@dataclass(slots=True, kw_only=True)
class Turns:
    """Lend turns, one at a time; who waits holds no thread.

    Attributes
    ----------
    what : str
        What is being done with a turn, for people.
    again : int
        When one that is refused may ask again [s].
    most : int
        Requests that have a turn or wait for one.
    limiter : CapacityLimiter
        The turns.
    """

    what: str
    again: int
    most: int = 9
    limiter: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(1))
    _present: int = 0

    @contextmanager
    def line(self) -> Iterator[None]:
        """Stand in line.

        Raises
        ------
        ProblemError
            If the line is full.
        """
        if self._present >= self.most:
            raise self.refusal()
        self._present += 1
        try:
            yield
        finally:
            self._present -= 1

    def refusal(self) -> ProblemError:
        """Return what one too many is told."""
        return ProblemError("busy", self.what, headers={"Retry-After": str(self.again)})
