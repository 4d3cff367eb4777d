"""Say what a run was made with: versions, seed, and every number of material and rig with its source."""

from __future__ import annotations

import platform
from dataclasses import fields, is_dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Final

from knitlab_core.materials import DEFAULT_FRICTION, Value, material_named
from rigs.machine import Datum

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigs.catalogue import MachineName
    from rigs.machine import MachineData
    from rigs.protocol import Protocol

Fact = tuple[str, str | int | float]

PACKAGES: Final = ("knitlab", "numpy", "scipy", "numba", "h5py")


def provenance(protocol: Protocol, data: Mapping[MachineName, MachineData]) -> dict[str, str | int | float]:
    """Return what a run was made with, flat: a number stands under its name, its unit and source under `name.source`.

    Parameters
    ----------
    protocol : Protocol
        The test.
    data : Mapping
        The numbers of the rig's machines. Those of the first stand under ``rig.``, of others under their own name.

    Returns
    -------
    dict
        Names and values, fit for attributes of a file.
    """
    material = material_named(protocol.specimen.material)
    friction = Value(value=protocol.specimen.friction, unit="1", source="the protocol")
    if protocol.specimen.friction == DEFAULT_FRICTION.value:
        friction = DEFAULT_FRICTION
    return dict(
        [
            ("name", protocol.name),
            ("rig", protocol.rig),
            *([] if protocol.mount is None else [("mount", protocol.mount)]),
            ("seed", protocol.log.seed),
            ("zero_strain", protocol.specimen.rest_shape),
            ("version.python", platform.python_version()),
            *((f"version.{package}", _version(package)) for package in PACKAGES),
            ("material", material.name),
            *_facts("material", material),
            *_sourced("friction", friction),
            *(
                fact
                for number, (machine, numbers) in enumerate(data.items())
                for fact in _facts(machine if number else "rig", numbers)
            ),
        ]
    )


def _version(package: str) -> str:
    """Return the version of an installed package."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _facts(name: str, part: object) -> Iterator[Fact]:
    """Yield every number with a source that a dataclass or a tuple holds, however deep."""
    if isinstance(part, Datum | Value):
        yield from _sourced(name, part)
    elif is_dataclass(part):
        for field in fields(part):
            yield from _facts(f"{name}.{field.name}", getattr(part, field.name))
    elif isinstance(part, tuple):
        for number, one in enumerate(part):
            yield from _facts(f"{name}[{number}]", one)


def _sourced(name: str, number: Datum | Value) -> Iterator[Fact]:
    yield name, number.value
    yield f"{name}.source", f"{number.unit}; {number.source}{'; assumed' if number.assumed else ''}"
