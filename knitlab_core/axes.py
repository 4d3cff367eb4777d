"""Axes of a knit."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, Literal, TypeAlias

Axis: TypeAlias = Literal["C", "W", "P"]
"""Course x, wale y, or pile z."""

COORDINATE: Final[Mapping[Axis, int]] = MappingProxyType({"C": 0, "W": 1, "P": 2})
"""Coordinate along each axis."""
