"""Scales between SI at every public boundary and the solver's own units.

Inside the solver lengths are in fibre radii r and forces in E r^2, so that its
tolerances mean the same at 50 um and at 50 mm, and scale invariance is exact.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Scales:
    """What one unit of the solver is in SI.

    Parameters
    ----------
    radius : float
        Fibre radius [m].
    young_modulus : float
        Young's modulus, or the reference modulus of a yarn by measurement [Pa].
    """

    radius: float
    young_modulus: float

    @property
    def length(self) -> float:
        """One solver length [m]."""
        return self.radius

    @property
    def force(self) -> float:
        """One solver force [N]."""
        return self.young_modulus * self.radius**2

    @property
    def energy(self) -> float:
        """One solver energy [J]."""
        return self.force * self.radius
