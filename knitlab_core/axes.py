"""Axes of a knit."""

from typing import Literal, TypeAlias

Axis: TypeAlias = Literal["C", "W", "P"]
"""Course x, wale y, or pile z."""
