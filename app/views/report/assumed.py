"""What a run rests on: defaults that its protocol took, numbers that are assumed, its mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from app.views.curves import prefixed
from rigs.protocol.specimen import MESH_ERRORS, MESHES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigs.protocol.specimen import SpecimenSpec

PLAIN: Final = frozenset({"1", "s", "degC"})
"""Units that take no prefix."""

MARK: Final = "; assumed"
"""End of the source of a number that is assumed, in a record."""

_ONLY_IF: Final = (("material.relaxation", "viscoelastic"), ("material.yield_curve", "yield"))
"""Numbers of a material that count only where an option is on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AssumedNumber:
    """A number of material or rig that is assumed: its name, value with unit, and where it comes from."""

    name: str
    value: str
    source: str


def assumed_numbers(provenance: Mapping[str, object]) -> Iterator[AssumedNumber]:
    """Yield the numbers of a record that are assumed, those of options that are off left out."""
    for place, text in provenance.items():
        source = str(text)
        name = place.removesuffix(".source")
        if name == place or not source.endswith(MARK):
            continue
        if any(name.startswith(part) and provenance.get(option) == "off" for part, option in _ONLY_IF):
            continue
        unit, _, words = source.removesuffix(MARK).partition("; ")
        yield AssumedNumber(name=name, value=_with_unit(provenance[name], unit), source=words)


def _with_unit(value: object, unit: str) -> str:
    """Return a value of a record with its unit, with a prefix where units of its kind take one."""
    if not isinstance(value, float):
        return str(value) if unit == "1" else f"{value} {unit}"
    factor, letter = (1.0, "") if unit in PLAIN else prefixed(value, least=0.1)
    return f"{factor * value:.5g}" if unit == "1" else f"{factor * value:.5g} {letter}{unit}"


def mesh_label(spec: SpecimenSpec) -> str:
    """Return the mesh of a specimen and the error that is stated for it.

    Examples
    --------
    >>> from rigs.protocol.specimen import SpecimenSpec
    >>> mesh_label(SpecimenSpec(knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM"))
    '48 nodes per loop (default): peak forces of printed knits at 40 % strain err by at most 1 %'
    """
    count = spec.nodes_per_loop
    name = next((f" ({one})" for one, nodes in MESHES.items() if nodes == count), "")
    known = [error for nodes, error in MESH_ERRORS.items() if nodes <= count]
    if not known:
        return f"{count} nodes per loop: coarser than any mesh whose error is stated; forces err by more than 3 %"
    most = f"at most {100.0 * min(known):.2g} %"
    return f"{count} nodes per loop{name}: peak forces of printed knits at 40 % strain err by {most}"
