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
        Wall time [s].
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
    """Seconds and calls per named part."""

    seconds: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        """Time the body of a `with` statement under a name."""
        start = perf_counter()
        try:
            yield
        finally:
            self.seconds[part] = self.seconds.get(part, 0.0) + perf_counter() - start
            self.calls[part] = self.calls.get(part, 0) + 1
