"""Rigs: which carriages each axis has, how they share its travel, what their hooks hold and which machine reads them.

A rig is data. The functions of `rigs.machines.rig` put the same parts together for all of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from knitlab_core.errors import SpecificationError
from knitlab_core.registries import register_part
from rigs.axes import AXES, DIRECTIONS, FACE, SHEARS
from rigs.protocol.bounds import require

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis, Direction

RigName: TypeAlias = str
MachineName: TypeAlias = str
Sides: TypeAlias = Literal["hold", "free"]
Others: TypeAlias = Literal["hold", "free", "follow"]
Grips: TypeAlias = Literal["hooks", "clamps"]
Fixture: TypeAlias = Grips | Literal["plates", "cell"]
Hook: TypeAlias = Literal["pin", "wire"]
Held: TypeAlias = tuple[bool, bool, bool, bool]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """The two carriages of an axis; of a pair of values the first is that of the negative side, or below.

    Attributes
    ----------
    machine : MachineName
        Whose numbers hold for it, and whose instrument reads it.
    travel : (float, float)
        Share of the axis' travel that each carriage makes, outwards [1].
    cell : (float, float)
        Share of each carriage's pull in what the load cell of the axis shows [1].
    held : tuple of bool
        Which of x, y, z and the edge's angle it prescribes to the nodes that it holds.
    fixture : {'hooks', 'clamps', 'plates', 'cell'}
        Whether it holds the boundary sites of its face by hooks, the stitches of its edge by the jaws of a clamp, by a
        plate all that is printed into one, or no edge at all: a vector of a periodic cell.
    pole : Axis or None
        Direction of the poles, along which hooks slide freely; None for a clamp or a plate.
    anchored : bool
        Whether the middle hook of the first carriage is tied to its pole. Nothing else holds a specimen with free
        sides against moving along the poles as a whole; the hook carries no force there.
    """

    machine: MachineName
    travel: tuple[float, float]
    cell: tuple[float, float]
    held: Held
    fixture: Fixture = "hooks"
    pole: Axis | None = None
    anchored: bool = False

    @property
    def moving(self) -> int:
        """Return how many of the two carriages move."""
        return sum(share > 0.0 for share in self.travel)


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrangement:
    """Rig: its drives and the sides of its specimen.

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
        """Return what axes can be told to do that a step does not name; free sides have no carriage to hold them.

        The strain of a stretch is none that a shear could follow.
        """
        if self.sides == "free":
            return ("free",)
        return ("hold", "free") if self.shears else ("hold", "free", "follow")

    @property
    def directions(self) -> tuple[Direction, ...]:
        """Return the directions that it stretches a specimen along."""
        return tuple(direction for direction in DIRECTIONS if direction in self.drives)

    @property
    def shears(self) -> bool:
        """Return whether it shears a specimen."""
        return any(axis in SHEARS for axis in self.drives)

    @property
    def cells_only(self) -> bool:
        """Return whether it holds a periodic cell alone."""
        return any(drive.fixture == "cell" for drive in self.drives.values())


#: A pole is across the pull, in the plane of a planar knit; a hook holds what is left: the pull, and the second
#: direction across it (out of plane, or for a face along the pile the distance from pole to pole).
_ACROSS: Final[Mapping[Axis, tuple[Held, Axis]]] = {
    "C": ((True, False, True, False), "W"),
    "W": ((False, True, True, False), "C"),
    "P": ((False, True, True, False), "C"),
}

#: Where all three axes are driven poles spread as well, and a hook holds the pull alone (decision 12).
_ALONG: Final[Mapping[Axis, tuple[Held, Axis]]] = {
    axis: ((axis == "C", axis == "W", axis == "P", False), pole) for axis, (_, pole) in _ACROSS.items()
}

#: Carriages that move symmetrically about the specimen's centre, a load cell that reads both.
_STAGE: Final = Drive(machine="biaxial-hook", travel=(0.5, 0.5), cell=(0.5, 0.5), held=(False,) * 4)

#: The lower clamp is fixed, the crosshead carries the upper one and the load cell above it.
_FRAME: Final = Drive(machine="uniaxial-frame", travel=(0.0, 1.0), cell=(0.0, 1.0), held=(False,) * 4)

#: Ideal grips of a periodic cell: of each of its vectors the end is moved and carries the load cell.
_CELL: Final = Drive(machine="shear-stage", travel=(0.0, 1.0), cell=(0.0, 1.0), held=(False,) * 4, fixture="cell")


def _hung(drive: Drive, hooks: Mapping[Axis, tuple[Held, Axis]], *axes: Axis) -> dict[Axis, Drive]:
    """Return a drive for each of some axes, with the hooks and poles that belong to its faces."""
    return {axis: replace(drive, held=hooks[axis][0], pole=hooks[axis][1]) for axis in axes}


_RIGS: Final[dict[RigName, Arrangement]] = {
    "biaxial-hook": Arrangement(drives=_hung(_STAGE, _ACROSS, "C", "W"), mounts_one=False, sides="hold"),
    "uniaxial-frame": Arrangement(
        drives=_hung(replace(_FRAME, anchored=True), _ACROSS, "C", "W", "P"), mounts_one=True, sides="free"
    ),
    # The stage carried on the frame: two machines on one specimen.
    "triaxial": Arrangement(
        drives={**_hung(_STAGE, _ALONG, "C", "W"), **_hung(_FRAME, _ALONG, "P")}, mounts_one=False, sides="hold"
    ),
    # The lower plate is on the substrate; the gripper on the indenter takes the upper one and has the load cell.
    "sem-microgripper": Arrangement(
        drives={
            "P": Drive(machine="nanoindenter", travel=(0.0, 1.0), cell=(0.0, 1.0), held=(True,) * 4, fixture="plates")
        },
        mounts_one=False,
        sides="free",
    ),
    "biaxial-shear": Arrangement(drives=dict.fromkeys(("C", "W", "WC"), _CELL), mounts_one=False, sides="hold"),
    # The cell's lengths are free: it shears at no normal force.
    "shear-frame": Arrangement(drives=dict.fromkeys(SHEARS, _CELL), mounts_one=True, sides="free"),
    "triaxial-shear": Arrangement(drives=dict.fromkeys(AXES, _CELL), mounts_one=False, sides="hold"),
}


CATALOGUE: Final[Mapping[RigName, Arrangement]] = MappingProxyType(_RIGS)
"""All rigs, with those that were registered."""


def rig_named(name: RigName) -> Arrangement:
    """Return a rig by its name.

    Raises
    ------
    SpecificationError
        If none has it.
    """
    if name not in CATALOGUE:
        raise SpecificationError("rig", name, f"one of {', '.join(CATALOGUE)}")
    return CATALOGUE[name]


def require_others(rig: RigName, others: str) -> None:
    """Raise unless the axes of a rig that a step does not name can do so."""
    allowed = " or ".join(", ".join(rig_named(rig).others).rsplit(", ", 1))
    require(others in rig_named(rig).others, "others", others, f"{allowed} on {rig}")


def register_rig(name: RigName, rig: Arrangement) -> None:
    """Give a rig a name for as long as this process lives; protocols may use it from then on.

    Raises
    ------
    SpecificationError
        If the name is none, or another rig has it already.
    """
    register_part("rig", _RIGS, name, rig)


def arranged(rig: RigName, mount: Axis | None, grips: Grips | Mapping[Axis, Grips] = "hooks") -> dict[Axis, Drive]:
    """Return the drives of a rig in use: all of them, or the one along which the specimen is mounted.

    With clamps in the place of hooks a carriage prescribes every unknown of the nodes that it holds. An axis that a
    mapping of grips leaves out has hooks.
    """
    every = CATALOGUE[rig].drives
    drives = {axis: drive for axis, drive in every.items() if mount in {None, axis}}
    clamped = set(drives) if grips == "clamps" else set()
    if not isinstance(grips, str):
        clamped = {axis for axis, grip in grips.items() if grip == "clamps"}
    return {axis: _clamped(drive) if axis in clamped else drive for axis, drive in drives.items()}


def clamped_axes(fixtures: Mapping[Axis, Fixture]) -> tuple[Direction, ...]:
    """Return the directions across whose faces clamps are."""
    return tuple(FACE[axis] for axis, fixture in fixtures.items() if fixture == "clamps")


def _clamped(drive: Drive) -> Drive:
    """Return a drive with clamps where it has hooks."""
    if drive.fixture != "hooks":
        return drive
    return replace(drive, fixture="clamps", held=(True,) * 4, pole=None, anchored=False)
