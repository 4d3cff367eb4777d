"""Where the time goes: iterations, factorisations, and seconds per part of the solver."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter


@dataclass(frozen=True, slots=True)
class Cost:
    """What searches cost.

    Attributes
    ----------
    iterations, factorisations : int
        Newton iterations and factorisations, those of failed searches included.
    seconds : float
        Wall time in searches [s].
    """

    iterations: int = 0
    factorisations: int = 0
    seconds: float = 0.0

    def __add__(self, other: "Cost") -> "Cost":
        return Cost(
            self.iterations + other.iterations,
            self.factorisations + other.factorisations,
            self.seconds + other.seconds,
        )

    def __sub__(self, other: "Cost") -> "Cost":
        return Cost(
            self.iterations - other.iterations,
            self.factorisations - other.factorisations,
            self.seconds - other.seconds,
        )


@dataclass(slots=True)
class Stopwatch:
    """Seconds and calls per named part, and what was counted.

    A part within a part counts in the inner one alone, so that all parts add up to the whole.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)
    iterations: int = 0
    factorisations: int = 0
    _inner: list[float] = field(default_factory=list)

    @property
    def cost(self) -> Cost:
        """Return all that was counted up to now, outside of any part."""
        return Cost(self.iterations, self.factorisations, sum(self.seconds.values()))

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        """Time the body of a `with` statement under a name."""
        start = perf_counter()
        self._inner.append(0.0)
        try:
            yield
        finally:
            whole = perf_counter() - start
            self.seconds[part] = self.seconds.get(part, 0.0) + whole - self._inner.pop()
            self.calls[part] = self.calls.get(part, 0) + 1
            if self._inner:
                self._inner[-1] += whole
