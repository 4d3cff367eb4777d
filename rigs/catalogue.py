"""List the rigs: which carriages each axis has, how they share its travel, what their hooks hold and who reads them.

A rig is data. The functions of `rigs.rig` put the same parts together for all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.steps import Axis

RigName: TypeAlias = Literal["biaxial-hook", "uniaxial-frame"]
MachineName: TypeAlias = Literal["biaxial-hook", "uniaxial-frame"]
Sides: TypeAlias = Literal["hold", "free"]
Others: TypeAlias = Literal["hold", "free", "follow"]
Held: TypeAlias = tuple[bool, bool, bool, bool]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """Describe the two carriages of an axis; of a pair of values the first is that of the negative side, or below.

    Attributes
    ----------
    machine : MachineName
        Whose numbers hold for it, and whose instrument reads it.
    travel : (float, float)
        Share of the axis' travel that each carriage makes, outwards [1].
    cell : (float, float)
        Share of each carriage's pull in what the load cell of the axis shows [1].
    held : tuple of bool
        Which of x, y, z and the edge's angle a hook prescribes to its node.
    pole : Axis
        Direction of the poles, along which hooks slide freely.
    anchored : bool
        Whether the middle hook of the first carriage is tied to its pole. Nothing else holds a specimen with free
        sides against moving along the poles as a whole; the hook carries no force there.
    """

    machine: MachineName
    travel: tuple[float, float]
    cell: tuple[float, float]
    held: Held
    pole: Axis
    anchored: bool

    @property
    def moving(self) -> int:
        """Return how many of the two carriages move."""
        return sum(share > 0.0 for share in self.travel)


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrangement:
    """Describe a rig.

    Attributes
    ----------
    drives : Mapping
        The carriages of each axis that can be driven.
    mounts_one : bool
        Whether only one of these axes is driven, the one along which the specimen is mounted.
    sides : {'hold', 'free'}
        Whether carriages hold every side of a specimen, or the sides that are not pulled are free.
    """

    drives: Mapping[Axis, Drive]
    mounts_one: bool
    sides: Sides

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes that can be driven."""
        return tuple(self.drives)

    @property
    def others(self) -> tuple[Others, ...]:
        """Return what axes can be told to do that a step does not name; free sides have no carriage to hold them."""
        return ("hold", "free", "follow") if self.sides == "hold" else ("free",)


#: A pole lies across the pull, in the plane of a planar knit; a hook holds what is left: the pull, and the second
#: direction across it (out of plane, or for a face along the pile the distance from pole to pole).
_ACROSS: Final[Mapping[Axis, tuple[Held, Axis]]] = {
    "C": ((True, False, True, False), "W"),
    "W": ((False, True, True, False), "C"),
    "P": ((False, True, True, False), "C"),
}


def _drives(
    *axes: Axis, machine: MachineName, travel: tuple[float, float], cell: tuple[float, float], anchored: bool
) -> Mapping[Axis, Drive]:
    """Return like drives for some axes, the hooks of each on poles that lie across it."""
    return {
        axis: Drive(
            machine=machine,
            travel=travel,
            cell=cell,
            held=_ACROSS[axis][0],
            pole=_ACROSS[axis][1],
            anchored=anchored,
        )
        for axis in axes
    }


CATALOGUE: Final[Mapping[RigName, Arrangement]] = MappingProxyType(
    {
        # Carriages that move symmetrically about the specimen's centre, a load cell that reads both.
        "biaxial-hook": Arrangement(
            drives=_drives("C", "W", machine="biaxial-hook", travel=(0.5, 0.5), cell=(0.5, 0.5), anchored=False),
            mounts_one=False,
            sides="hold",
        ),
        # The lower clamp stands, the crosshead carries the upper one and the load cell above it.
        "uniaxial-frame": Arrangement(
            drives=_drives("C", "W", "P", machine="uniaxial-frame", travel=(0.0, 1.0), cell=(0.0, 1.0), anchored=True),
            mounts_one=True,
            sides="free",
        ),
    }
)


def arranged(rig: RigName, mount: Axis | None) -> dict[Axis, Drive]:
    """Return the drives of a rig in use: all of them, or the one along which the specimen is mounted."""
    drives = CATALOGUE[rig].drives
    return dict(drives) if mount is None else {mount: drives[mount]}
