"""Machines by name: what their channels are called, and the file that holds their numbers."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError
from knitlab_core.registries import register_part
from rigs.axes import AXES

if TYPE_CHECKING:
    from collections.abc import Mapping
    from importlib.resources.abc import Traversable

    from rigs.axes import Axis
    from rigs.protocol.catalogue import MachineName


@dataclass(frozen=True, slots=True, kw_only=True)
class Machine:
    """A machine that can drive axes of a rig.

    Attributes
    ----------
    channels : Mapping
        What stands before `Displacement` and `Force` in the names of the channels of each axis.
    numbers : Traversable
        YAML file in the form of ``rigs/data/biaxial_hook.yaml``, every number with its source; a `Path` is one too.
    """

    channels: Mapping[Axis, str]
    numbers: Traversable


_DATA: Final = files("rigs") / "data"

_MACHINES: Final[dict[MachineName, Machine]] = {
    "biaxial-hook": Machine(channels={"C": "X", "W": "Y"}, numbers=_DATA / "biaxial_hook.yaml"),
    "uniaxial-frame": Machine(channels={"C": "", "W": "", "P": ""}, numbers=_DATA / "uniaxial_frame.yaml"),
    "nanoindenter": Machine(channels={"P": ""}, numbers=_DATA / "nanoindenter.yaml"),
    "shear-stage": Machine(channels={axis: axis for axis in AXES}, numbers=_DATA / "shear_stage.yaml"),
}

MACHINES: Final[Mapping[MachineName, Machine]] = MappingProxyType(_MACHINES)
"""All machines, with those that were registered."""


def machine_named(name: MachineName) -> Machine:
    """Return a machine by its name.

    Raises
    ------
    SpecificationError
        If none has it.
    """
    if name not in MACHINES:
        raise SpecificationError("machine", name, f"one of {', '.join(MACHINES)}")
    return MACHINES[name]


def register_machine(name: MachineName, machine: Machine) -> None:
    """Give a machine a name for as long as this process lives; drives of a rig may use it from then on.

    Raises
    ------
    SpecificationError
        If the name is none, or another machine has it already.
    """
    register_part("machine", _MACHINES, name, machine)
