"""Members that every step of a protocol has: what the planner, the controller, stop criteria and logs ask of it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol, TypeAlias

from rigs.protocol.bounds import require

if TYPE_CHECKING:
    from rigs.axes import Axis
    from rigs.protocol.strokes import Situation, Stroke
    from rigs.protocol.targets import Channel, StepLog, Until

Pictures: TypeAlias = float | Literal["one", "off"]
"""A series of pictures with this time between two [s], one picture, or the end of a series."""


class Step(Protocol):
    """A step of a protocol.

    Attributes
    ----------
    axes : tuple of Axis
        The axes that it names.
    tag : str or None
        Its name in the log.
    until : Until or None
        What ends it before its target.
    log : StepLog or None
        How it is logged where it differs from the test.
    stroke_count : int
        How many strokes it makes at most.
    moves : bool
        Whether it drives its axes.
    pulls : bool
        Whether it goes outwards as a whole, so that a bare level of `until` is reached from below in all its strokes.
    cyclic : bool
        Whether it is logged as cycles, of which a log may leave some out.
    to_rupture : bool
        Whether it is meant to end with a rupture: its target is a limit, and the test's outcome is its own.
    tares : tuple of Channel
        Channels that it sets to zero.
    pictures : Pictures or None
        Pictures that it asks for as it begins.
    """

    @property
    def axes(self) -> tuple[Axis, ...]: ...  # noqa: D102

    @property
    def tag(self) -> str | None: ...  # noqa: D102

    @property
    def until(self) -> Until | None: ...  # noqa: D102

    @property
    def log(self) -> StepLog | None: ...  # noqa: D102

    @property
    def stroke_count(self) -> int: ...  # noqa: D102

    @property
    def moves(self) -> bool: ...  # noqa: D102

    @property
    def pulls(self) -> bool: ...  # noqa: D102

    @property
    def cyclic(self) -> bool: ...  # noqa: D102

    @property
    def to_rupture(self) -> bool: ...  # noqa: D102

    @property
    def tares(self) -> tuple[Channel, ...]: ...  # noqa: D102

    @property
    def pictures(self) -> Pictures | None: ...  # noqa: D102

    def stroke(self, index: int, situation: Situation) -> Stroke | None:
        """Return stroke `index` of the step, from 0 to `stroke_count`; None where nothing moves and no time passes.

        Raises
        ------
        SpecificationError
            If hooks would pass through each other.
        """
        ...


class StepDefaults:
    """Members of `Step` that are the same in most steps; a step's class defines those that differ."""

    __slots__ = ()

    moves: ClassVar[bool] = True
    pulls: ClassVar[bool] = False
    cyclic: ClassVar[bool] = False
    to_rupture: ClassVar[bool] = False

    @property
    def stroke_count(self) -> int:
        """Return how many strokes it makes at most."""
        return 1

    @property
    def tares(self) -> tuple[Channel, ...]:
        """Return the channels that it sets to zero."""
        return ()

    @property
    def pictures(self) -> Pictures | None:
        """Return the pictures that it asks for."""
        return None


def step_name(step: object) -> str:
    """Return what a file calls a kind of step.

    Examples
    --------
    >>> from rigs.protocol.steps import UntilRupture
    >>> step_name(UntilRupture(axes=("C",), rate=1e-4))
    'until_rupture'
    """
    return re.sub(r"(?<=.)([A-Z])", r"_\1", type(step).__name__).lower()


def require_no_cycles(log: StepLog | None) -> None:
    """Raise if a step without cycles keeps some of them."""
    every = None if log is None else log.every_cycle
    require(every is None, "log.every_cycle", every, "no such field: only a step cycle has cycles")
