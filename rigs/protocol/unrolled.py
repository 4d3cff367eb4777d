"""Walk the steps of a protocol with repeats counted out, each with its place in the file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from rigs.protocol.steps import Cycle, Hold, Image, Preload, Ramp, Repeat, UntilRupture, Zero, step_name

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigs.protocol.steps import Step
    from rigs.protocol.targets import StepLog, Until

Single: TypeAlias = Zero | Preload | Ramp | Hold | Cycle | UntilRupture | Image


@dataclass(frozen=True, slots=True, kw_only=True)
class UnrolledStep:
    """Hold one step as it is done: a step of a repeat is one leaf each time.

    Attributes
    ----------
    number : int
        Its turn, from 0.
    place : str
        Where it is said, ``steps[2].cycle``.
    step : Single
        The step.
    """

    number: int
    place: str
    step: Single

    @property
    def strokes(self) -> int:
        """Return how many strokes it makes at most."""
        return 2 * self.step.n if isinstance(self.step, Cycle) else 1

    @property
    def tag(self) -> str | None:
        """Return the step's tag."""
        return None if isinstance(self.step, Zero) else self.step.tag

    @property
    def until(self) -> Until | None:
        """Return what ends the step early."""
        return None if isinstance(self.step, Zero | Image) else self.step.until

    @property
    def log(self) -> StepLog | None:
        """Return how the step is logged where it differs from the test."""
        return None if isinstance(self.step, Zero | Image) else self.step.log


def unrolled(steps: Sequence[Step]) -> Iterator[UnrolledStep]:
    """Yield the steps in the order in which they are done."""
    for number, (place, step) in enumerate(_counted_out(steps, "steps")):
        yield UnrolledStep(number=number, place=place, step=step)


def _counted_out(steps: Sequence[Step], under: str) -> Iterator[tuple[str, Single]]:
    """Yield place and step, those of a repeat over and over."""
    for number, step in enumerate(steps):
        place = f"{under}[{number}].{step_name(step)}"
        if isinstance(step, Repeat):
            for _ in range(step.n):
                yield from _counted_out(step.steps, f"{place}.steps")
        else:
            yield place, step
