"""A short queue of requests that take seconds of a processor, the cheapest first."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from itertools import count

import anyio
from anyio import CapacityLimiter

from app.service.api.problems import ProblemError

_number = count()


@dataclass(slots=True, kw_only=True)
class Turns:
    """Turns of one request at a time, the cheapest waiting one next; waiting requests hold no thread.

    Attributes
    ----------
    what : str
        What is being done with a turn, for people.
    again : int
        When one that is refused may ask again [s].
    most : int
        Requests that have a turn or wait for one.
    patience : float or None
        How long a request may wait for its turn [s]; None for any time.
    limiter : CapacityLimiter
        The thread of whoever has the turn.
    """

    what: str
    again: int
    most: int = 9
    patience: float | None = None
    limiter: CapacityLimiter = field(default_factory=lambda: CapacityLimiter(1))
    _present: int = 0
    _taken: bool = False
    _waiting: list[tuple[float, int, anyio.Event]] = field(default_factory=list)

    @contextmanager
    def line(self) -> Iterator[None]:
        """Enter the queue.

        Raises
        ------
        ProblemError
            If the line is full.
        """
        if self._present >= self.most:
            raise self._refusal()
        self._present += 1
        try:
            yield
        finally:
            self._present -= 1

    @asynccontextmanager
    async def turn(self, cost: float = 0.0) -> AsyncIterator[None]:
        """Wait for a turn and hold it.

        Parameters
        ----------
        cost : float
            About how long the turn will take [s].

        Raises
        ------
        ProblemError
            If it did not come in time.
        """
        await self._take(cost)
        try:
            yield
        finally:
            self._pass_on()

    async def _take(self, cost: float) -> None:
        """Take the turn, or wait until it is this request's."""
        if not self._taken:
            self._taken = True
            return
        place = (cost, next(_number), anyio.Event())
        heappush(self._waiting, place)
        try:
            with anyio.fail_after(self.patience):
                await place[2].wait()
        except BaseException as error:
            if place[2].is_set():
                self._pass_on()
            else:
                self._waiting.remove(place)
                heapify(self._waiting)
            if isinstance(error, TimeoutError):
                raise self._refusal() from error
            raise

    def _pass_on(self) -> None:
        """Pass the turn to the cheapest waiting request."""
        if self._waiting:
            heappop(self._waiting)[2].set()
        else:
            self._taken = False

    def _refusal(self) -> ProblemError:
        """Return the error for a request that finds the queue full."""
        return ProblemError("busy", self.what, headers={"Retry-After": str(self.again)})
