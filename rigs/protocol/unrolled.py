"""Steps of a protocol in the order in which they are done: repeats counted out, each with its place in the file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigs.protocol.step import step_name
from rigs.protocol.steps import Repeat

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigs.axes import Axis
    from rigs.protocol.step import Step


@dataclass(frozen=True, slots=True, kw_only=True)
class UnrolledStep:
    """One step as it is done: a step of a repeat is one of these each time.

    Attributes
    ----------
    number : int
        Its index, from 0.
    place : str
        Its place in the file, ``steps[2].cycle``.
    step : Step
        The step.
    """

    number: int
    place: str
    step: Step


def unrolled(steps: Sequence[Step | Repeat]) -> Iterator[UnrolledStep]:
    """Yield the steps in the order in which they are done."""
    for number, (place, step) in enumerate(_counted_out(steps, "steps")):
        yield UnrolledStep(number=number, place=place, step=step)


def stroke_count(steps: Sequence[Step | Repeat]) -> int:
    """Count the strokes that `steps` make, those of a repeat each time [1]."""
    return sum(step.n * stroke_count(step.steps) if isinstance(step, Repeat) else step.stroke_count for step in steps)


def axes_of(steps: Sequence[Step | Repeat], under: str = "steps") -> Iterator[tuple[str, tuple[Axis, ...]]]:
    """Yield the place of the axes of each step, ``steps[2].cycle.axes``, and which they are."""
    for number, step in enumerate(steps):
        place = f"{under}[{number}].{step_name(step)}"
        if isinstance(step, Repeat):
            yield from axes_of(step.steps, f"{place}.steps")
        else:
            yield f"{place}.axes", step.axes


def _counted_out(steps: Sequence[Step | Repeat], under: str) -> Iterator[tuple[str, Step]]:
    """Yield place and step, those of a repeat over and over."""
    for number, step in enumerate(steps):
        place = f"{under}[{number}].{step_name(step)}"
        if isinstance(step, Repeat):
            for _ in range(step.n):
                yield from _counted_out(step.steps, f"{place}.steps")
        else:
            yield place, step
