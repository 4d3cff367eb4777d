"""Devices of a live rig for Bluesky: axes that a plan moves, and load cells that it reads.

They meet Bluesky's protocols (`bluesky.protocols`: Movable, Locatable, Stoppable, Readable) by their methods alone, so
that nothing of Bluesky is imported here. One thread moves the rig: moves that a plan asks for at once are done one
after the other.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from knitlab_core.errors import KnitlabError
from rigs.protocol.targets import Target

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from concurrent.futures import Executor, Future

    from app.live.rig import LiveRig
    from rigs.axes import Axis
    from rigs.protocol.targets import Rate


@dataclass(frozen=True, slots=True, eq=False)
class MoveStatus:
    """Status of a move, as Bluesky asks for it."""

    future: Future[None]

    @property
    def done(self) -> bool:
        """Return whether the move is over."""
        return self.future.done()

    @property
    def success(self) -> bool:
        """Return whether it reached its target."""
        return self.done and self.future.exception() is None

    def __repr__(self) -> str:
        """Return how the move goes; Bluesky shows this where a plan fails."""
        error = self.future.exception() if self.done else None
        return f"<move {'under way' if not self.done else 'done' if error is None else f'failed: {error}'}>"

    def add_callback(self, callback: Callable[[Any], None]) -> None:
        """Call a function with this status when the move is over."""
        self.future.add_done_callback(lambda _: callback(self))

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        """Return why the move failed, waiting for its end at most so long [s]; None if it did not."""
        return self.future.exception(timeout)


class _Device:
    """Readable of a rig: its name, and for each field where it is in a reading, and its unit."""

    parent = None

    def __init__(self, rig: LiveRig, name: str, fields: Mapping[str, tuple[str, Axis, str]]) -> None:
        self.name = name
        self._rig, self._fields = rig, fields

    @property
    def hints(self) -> dict[str, list[str]]:
        """Return the fields that a plot shows."""
        return {"fields": list(self._fields)}

    def read(self) -> dict[str, dict[str, float]]:
        """Return the value of each field, in SI, and when it was read."""
        reading, now = self._rig.read(), time.time()
        return {
            name: {"value": float(getattr(reading, what)[axis]), "timestamp": now}
            for name, (what, axis, _) in self._fields.items()
        }

    def describe(self) -> dict[str, dict[str, Any]]:
        """Return the unit of each field, and what it is read from."""
        return {
            name: {"source": f"knitlab:{what}_{axis}", "dtype": "number", "shape": [], "units": unit}
            for name, (what, axis, unit) in self._fields.items()
        }

    def read_configuration(self) -> dict[str, Any]:
        """Return nothing: a rig is configured by its protocol."""
        return {}

    def describe_configuration(self) -> dict[str, Any]:
        """Return nothing."""
        return {}


class LoadCells(_Device):
    """Load cells of a rig as one readable: ``force_C``, ``force_W`` [N]."""

    def __init__(self, rig: LiveRig) -> None:
        super().__init__(rig, "cells", {f"force_{axis}": ("force", axis, "N") for axis in rig.axes})


class MovableAxis(_Device):
    """Axis of a rig as a movable in metres since the last zero; it reads its displacement [m] and strain [1].

    Parameters
    ----------
    rig : LiveRig
        The rig.
    axis : Axis
        The axis; also the device's name.
    rate : Rate or str
        How fast it moves.
    moves : Executor
        Where the rig moves.
    """

    def __init__(self, rig: LiveRig, axis: Axis, rate: Rate | str, moves: Executor) -> None:
        super().__init__(rig, axis, {axis: ("displacement", axis, "m"), f"strain_{axis}": ("strain", axis, "1")})
        self._axis, self._rate, self._moves = axis, rate, moves
        self._setpoint = rig.read().displacement[axis]

    @property
    def hints(self) -> dict[str, list[str]]:
        """Return the field that a plot shows."""
        return {"fields": [self._axis]}

    def set(self, value: float) -> MoveStatus:
        """Move to a displacement [m]; the status fails where the move ends elsewhere."""
        self._setpoint = float(value)
        return MoveStatus(self._moves.submit(self._move, self._setpoint))

    def locate(self) -> dict[str, float]:
        """Return where it was sent, and where it is [m]."""
        return {"setpoint": self._setpoint, "readback": self._rig.read().displacement[self._axis]}

    def stop(self, *, success: bool = True) -> None:  # noqa: ARG002 (Bluesky's protocol)
        """Stop at the next equilibrium."""
        self._rig.stop()

    def _move(self, level: float) -> None:
        done = self._rig.move(self._axis, to=Target(kind="displacement", value=level), rate=self._rate)
        if done.end != "target":
            raise KnitlabError(f"{done.place}: {done.end}: {done.message}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RigDevices:
    """Devices of a rig.

    Attributes
    ----------
    axes : Mapping
        Each axis as a movable.
    cells : LoadCells
        The load cells as one readable.
    """

    axes: Mapping[Axis, MovableAxis]
    cells: LoadCells


def devices_of(rig: LiveRig, *, rate: Rate | str) -> RigDevices:
    """Return the Bluesky devices of a rig, whose axes move at a rate; a bare number is a speed [m/s]."""
    moves = ThreadPoolExecutor(1, "knitlab-moves")
    return RigDevices(axes={axis: MovableAxis(rig, axis, rate, moves) for axis in rig.axes}, cells=LoadCells(rig))
