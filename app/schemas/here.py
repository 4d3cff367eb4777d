"""Words of the protocol language that one protocol's rig and knit allow."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from knitlab_core.knits import fabric_named, fabric_names
from rigs.axes import spans
from rigs.protocol.catalogue import CATALOGUE

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from app.schemas.document import Data, Place
    from rigs.axes import Axis, Direction
    from rigs.protocol.catalogue import Arrangement

#: Other names of the axes.
_AXES: Final[Mapping[str, Axis]] = MappingProxyType(
    {"x": "C", "y": "W", "z": "P", "course": "C", "wale": "W", "pile": "P", "shear": "WC", "cw": "WC", "s": "WC"}
)


def allowed_here(data: Data, place: Place, known: Iterable[str]) -> list[str]:
    """Return those of the known words for a place that the protocol's rig and knit allow.

    Parameters
    ----------
    data : Data
        The protocol as in the file; what is wrong in it restricts nothing.
    place : tuple
        Place of the word; for an unknown field that of its mapping, and ``""``.
    known : iterable of str
        Every word that some protocol may have there.
    """
    words = list(known)
    name = next((part for part in reversed(place) if isinstance(part, str)), "")
    knit, rig = _knit_axes(data), _rig(data)
    found = words
    match name:
        case "rig" if knit is not None:
            cell = _value(data, "specimen", "periodic") not in (None, False, "off")
            able = [
                one for one, named in CATALOGUE.items() if _can_pull(named, knit) and (cell or not named.cells_only)
            ]
            found = [one for one in able if one in words]
        case "hook" if knit is not None and "P" in knit:
            found = ["pin"]
        case "control" if "until_rupture" in place:
            found = [word for word in words if word != "force"]
        case _ if rig is not None:
            found = [word for word in words if _suits(rig, name, word, _value(data, "mount"), knit)]
        case _:
            pass
    return found


def _suits(rig: Arrangement, name: str, word: str, mount: Data, knit: Sequence[Direction] | None) -> bool:
    """Return whether a rig allows a word as the value of a field."""
    match name:
        case "knit":
            return word not in fabric_names() or _can_pull(rig, fabric_named(word).axes)
        case "axes":
            return word == mount if rig.mounts_one and mount in rig.axes else word in rig.axes
        case "mount":
            return any(word == axis and (knit is None or spans(axis) <= {*knit}) for axis in rig.axes)
        case "others":
            return word in rig.others
        case _:
            return bool(name) or word not in _idle(rig)


def axis_meant(word: str, allowed: Sequence[str]) -> str | None:
    """Return the axis that goes by another name; None if none does, or it is not allowed.

    Examples
    --------
    >>> axis_meant("X", ["C", "W"]), axis_meant("pile", ["C", "W"])
    ('C', None)
    """
    axis = _AXES.get(word.casefold())
    return axis if axis in allowed else None


def _idle(rig: Arrangement) -> set[str]:
    """Return the fields that mean nothing on a rig."""
    one_clock = len({drive.machine for drive in rig.drives.values()}) == 1
    return {*(() if rig.mounts_one else ("mount",)), *(("clock_offset", "clock_skew") if one_clock else ())}


def _can_pull(rig: Arrangement, knit: Sequence[Direction]) -> bool:
    """Return whether a rig can pull a knit with faces across some axes."""
    able = [spans(axis) <= {*knit} for axis in rig.axes]
    return any(able) if rig.mounts_one else all(able)


def _value(data: Data, *place: str) -> Data:
    """Return the value at a place of the file; None if there is none."""
    for name in place:
        data = data.get(name) if isinstance(data, dict) else None
    return data


def _rig(data: Data) -> Arrangement | None:
    """Return the rig of a protocol; None if it is none of the catalogue."""
    named = _value(data, "rig")
    return next((rig for name, rig in CATALOGUE.items() if name == named), None)


def _knit_axes(data: Data) -> tuple[Direction, ...] | None:
    """Return the axes across which the knit has faces; None if it is none of those that have a name."""
    named = _value(data, "specimen", "knit")
    return fabric_named(named).axes if isinstance(named, str) and named in fabric_names() else None
