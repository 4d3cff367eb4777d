"""Yarns by measurement, shared by tests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from knitlab_core.contact.compression import Compression
from knitlab_core.equilibrium.model import make_model
from knitlab_core.materials import MeasuredYarn, Value
from knitlab_core.rods.section import measured_section

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import Model, State

UNITS: Final = {
    "bending": "N*m**2",
    "axial": "N",
    "twisting": "N*m**2",
    "radius": "m",
    "core": "m",
    "exponent": "1",
    "rigidity": "N/m",
    "friction": "1",
}
ACRYLIC: Final = {
    "bending": 0.045e-6,
    "axial": 100.0,
    "twisting": 0.035e-6,
    "radius": 0.74e-3,
    "core": 0.325e-3,
    "exponent": 2.4,
    "rigidity": 4.8,
    "friction": 0.3,
}
"""Numbers of an acrylic yarn, in SI."""


def measured_yarn(**changed: float) -> MeasuredYarn:
    """Return a yarn with the numbers of acrylic, some of them changed."""
    numbers = {**ACRYLIC, **changed}
    values: dict[str, Any] = {
        name: Value(value=number, unit=UNITS[name], source="test", assumed=False) for name, number in numbers.items()
    }
    return MeasuredYarn(name="yarn", **values)


def yarn_model(
    strands: Sequence[FloatArray], yarn: MeasuredYarn, *, printed: bool = False, friction: float = 0.0
) -> tuple[Model, State]:
    """Make the model of strands of a yarn; their nodes are given in its radii [r]."""
    radius = yarn.radius.value
    return make_model(
        [radius * strand for strand in strands],
        radius=radius,
        young_modulus=yarn.reference_modulus,
        poisson_ratio=0.0,
        friction=friction,
        section=measured_section(yarn),
        compression=Compression.of(yarn),
        printed=printed,
    )
