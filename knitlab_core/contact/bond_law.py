"""Strength of fused points, as a protocol gives it."""

from dataclasses import dataclass
from math import inf

from knitlab_core.errors import SpecificationError


@dataclass(frozen=True, slots=True, kw_only=True)
class BondLaw:
    """Fused points: which strands are fused, and the strength of their bonds.

    A bond breaks where (sigma / strength)^2 + (tau / shear_strength)^2 reaches 1, with sigma = F / A + 4 M / pi a^3
    the largest tension on the neck (none if pressed) and tau = S / A + 2 T / pi a^3 the largest shear, of pull F,
    shear S, bending moment M and torque T.

    Parameters
    ----------
    fuse_gap : float
        Strands whose surfaces are printed nearer than this are fused [m].
    patch_radius : float
        Radius of a neck [m].
    strength : float
        Tension at which it breaks [Pa].
    shear_strength : float or None
        Shear at which it breaks [Pa]; None is strength / sqrt 3 (von Mises).
    locate : float
        How near to its strength a bond is found before it breaks [1]; those as near break together.

    Raises
    ------
    SpecificationError
        For a number that is not above zero, or a `locate` that is not below 1.
    """

    fuse_gap: float
    patch_radius: float
    strength: float
    shear_strength: float | None = None
    locate: float = 0.01

    def __post_init__(self) -> None:
        """Refuse numbers that no bond can have."""
        for field in ("fuse_gap", "patch_radius", "strength", "shear_strength"):
            value = getattr(self, field)
            if value is not None and not 0.0 < value < inf:
                raise SpecificationError(f"bonds.{field}", value, "a number above 0")
        if not 0.0 < self.locate < 1.0:
            raise SpecificationError("bonds.locate", self.locate, "above 0, below 1")
