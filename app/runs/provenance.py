"""Provenance of a run: versions, seed, and every number of material and rig with its source."""

from __future__ import annotations

import platform
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Final

from app.version import version_of
from app.views.labels import beyond_elastic, friction_value, grips_label, yarn_label
from knitlab_core.materials import Value
from rigs.machines.machine import Datum

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigs.machines.machine import MachineData
    from rigs.protocol.catalogue import MachineName
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.specimen import SpecimenSpec

Fact = tuple[str, str | int | float]

_BOND_UNITS: Final = {"fuse_gap": "m", "patch_radius": "m", "strength": "Pa", "shear_strength": "Pa", "locate": "1"}

PACKAGES: Final = ("knitlab", "numpy", "scipy", "numba", "h5py")


def provenance(protocol: Protocol, data: Mapping[MachineName, MachineData]) -> dict[str, str | int | float]:
    """Return the provenance as a flat mapping: a number by its name, its unit and source as `name.source`.

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
    spec = protocol.specimen
    material = spec.substance
    friction = friction_value(spec)
    return dict(
        [
            ("name", protocol.name),
            ("rig", protocol.rig),
            *([] if protocol.mount is None else [("mount", protocol.mount)]),
            ("grips", grips_label(protocol)),
            ("hook", protocol.hook),
            ("speed_ref", protocol.speed_ref),
            ("others", protocol.others),
            *_given_pole_friction(protocol.pole_friction),
            ("seed", protocol.log.seed),
            ("zero_strain", spec.rest_shape),
            ("version.python", platform.python_version()),
            *((f"version.{package}", version_of(package)) for package in PACKAGES),
            ("material", material.name),
            *_facts("material", material),
            *_sourced("friction", friction),
            ("yarn", yarn_label(spec)),
            *_options(spec),
            *(
                fact
                for number, (machine, numbers) in enumerate(data.items())
                for fact in _facts(machine if number else "rig", numbers)
            ),
        ]
    )


def _given_pole_friction(friction: float | None) -> Iterator[Fact]:
    """Yield the pole friction of the protocol, if it gives one; otherwise that of the machines applies."""
    if friction is not None:
        yield from _sourced("pole_friction", Value(value=friction, unit="1", source="the protocol"))


def _options(spec: SpecimenSpec) -> Iterator[Fact]:
    """Yield every option beyond elastic rods, also those that are off, and the numbers of bonds."""
    found = beyond_elastic(spec)
    for option in ("viscoelastic", "yield", "fused points", "rupture"):
        yield option.replace(" ", "_"), found.get(option, "off")
    if spec.fused is not None:
        for one in fields(spec.fused):
            value, unit = getattr(spec.fused, one.name), _BOND_UNITS[one.name]
            if value is not None:
                yield from _sourced(
                    f"fused_points.{one.name}", Value(value=value, unit=unit, source="the protocol", assumed=True)
                )
    limit = None if spec.rupture == "off" else spec.solid.breaking_strain
    if limit is not None:
        yield from _sourced("rupture.strain", limit)


def _facts(name: str, part: object) -> Iterator[Fact]:
    """Yield every number with a source in a dataclass or tuple, recursively."""
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
