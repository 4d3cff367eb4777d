"""How a yarn resists being flattened: its law in quantities that are measured, and its fit to a test between plates.

With D twice the outer radius, h the distance of two centrelines and psi the potential of `contact.law`, the double line
integral gives, for long straight yarns,

- crossed at an angle a: the force 2 pi h psi(D - h) / sin a, exactly;
- parallel: by length the force f(h) = 2 h ∫_h^D psi'(D - x) / sqrt(x^2 - h^2) dx (Abel's integral), whose inverse is
  psi(D - h) = 1 / pi ∫_h^D f(x) / sqrt(x^2 - h^2) dx.

The plane midway between two like parallel yarns is one of symmetry: a yarn between two flat plates a gap h apart feels
the same f(h), as long as what one plate does is independent of the other. So f over the compression D - h is what a
test of one yarn between plates measures, by length of yarn.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log, sqrt
from typing import TYPE_CHECKING, Final, Self

import numpy as np
from scipy.optimize import minimize_scalar

from knitlab_core.contact.law import ContactLaw, make_yarn_law, pair_potential
from knitlab_core.errors import SpecificationError
from knitlab_core.jit import kernel
from knitlab_core.materials import yarns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.materials import MeasuredYarn
    from knitlab_core.units import Scales

WORST_DEVIATION: Final = 0.3
"""Largest deviation of a table from the law fitted to it, as the root mean square of relative ones [1]."""

THIN: Final = 0.8
"""Overlap [r] at which cores meet, below which contact samples have to be nearer to each other."""

DEEP: Final = 0.9
"""Share of the way to the core up to which contact is resolved [1]."""

STEEP: Final = 0.2
"""Value of w h / (n + 1) at that depth [r^2], below which samples have to be nearer too.

Force drops along a strand over the root of a tenth of it; with n = 6 samples 2r/9 apart would err by up to 5 %.
"""

FEWEST_POINTS: Final = 4
_DIGITS: Final = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Compression:
    """Law by which a yarn is flattened.

    Parameters
    ----------
    radius : float
        Outer radius, at which contact begins [m].
    core : float
        Radius to which no force can compress the yarn [m].
    exponent : float
        n: how steeply the force grows where yarns begin to touch and towards the core; psi = k [p / (w - p)]^n [1].
    rigidity : float
        Force by length [N/m] that compresses the yarn between plates, or two parallel yarns against each other, to
        halfway between radius and core.
    """

    radius: float
    core: float
    exponent: float
    rigidity: float

    @classmethod
    def of(cls, yarn: MeasuredYarn) -> Self:
        """Return the law of a yarn by measurement."""
        return cls(
            radius=yarn.radius.value,
            core=yarn.core.value,
            exponent=yarn.exponent.value,
            rigidity=yarn.rigidity.value,
        )

    @property
    def largest(self) -> float:
        """Return the compression at which the cores meet, 2 (radius - core) [m]."""
        return 2.0 * (self.radius - self.core)

    @property
    def narrow(self) -> bool:
        """Return whether contact needs narrow samples: a thin shell, or a force that is very steep near the core."""
        largest = self.largest / self.radius
        steep = largest * (2.0 - DEEP * largest) / (self.exponent + 1.0)
        return largest < THIN or steep < STEEP

    @property
    def potential(self) -> float:
        """Return k, psi halfway to the core [N/m]."""
        law = _unit_law(self.exponent, self.core / self.radius)
        return self.rigidity / parallel_force(1.0 + self.core / self.radius, law)

    def line_force(self, compression: float) -> float:
        """Return the force by length [N/m] between plates, or two parallel yarns, at a compression 2 radius - h [m]."""
        law = _unit_law(self.exponent, self.core / self.radius)
        return self.potential * parallel_force(2.0 - compression / self.radius, law)

    def crossed_force(self, compression: float) -> float:
        """Return the force [N] between yarns crossed at right angles at a compression 2 radius - h [m]."""
        law = _unit_law(self.exponent, self.core / self.radius)
        psi = self.potential * pair_potential(compression / self.radius, law)[0]
        return 2.0 * np.pi * (2.0 * self.radius - compression) * psi

    def law(self, scales: Scales, friction: float, slip: float) -> ContactLaw:
        """Return the contact law in the solver's units."""
        coefficient = self.potential / (scales.length * scales.young_modulus)
        return make_yarn_law(coefficient, self.exponent, self.core / self.radius, friction, slip=slip)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """Law fitted to a table of compressions and forces.

    Parameters
    ----------
    compression : Compression
        The law, its two numbers rounded to six digits.
    deviation : float
        Root mean square of the logarithms of force over law: the relative deviation of the table [1].
    points : int
        Rows that were fitted.
    """

    compression: Compression
    deviation: float
    points: int


def fit_compression(table: Sequence[tuple[float, float]], *, radius: float, core: float) -> Fit:
    """Fit exponent and rigidity of a yarn to a test between plates.

    Minimises the sum of squares of ln F_i - ln(rigidity f_n(c_i) / f_n(c_half)) over both, so that every row counts by
    its relative deviation. For an exponent n the best rigidity is the geometric mean of what each row asks for, so
    that a search along n is left.

    Parameters
    ----------
    table : sequence of pairs
        Compression 2 radius - gap [m] and force by length of yarn [N/m], both rising; a first row of zeros is left out.
    radius, core : float
        Outer radius and core of the yarn [m].

    Raises
    ------
    SpecificationError
        For rows that do not rise, reach the core or are fewer than four, and where no law comes within 30 %.
    """
    rows = list(table[1:] if table and table[0] == (0.0, 0.0) else table)
    _require_rows(rows, len(table) - len(rows), 2.0 * (radius - core))
    heights = [2.0 - compression / radius for compression, _ in rows]
    forces = [log(force) for _, force in rows]

    def missed(exponent: float) -> tuple[float, float]:
        """Return the variance of ln F - ln f, and its mean."""
        law = _unit_law(exponent, core / radius)
        half = parallel_force(1.0 + core / radius, law)
        ratios = [f - log(parallel_force(h, law) / half) for h, f in zip(heights, forces, strict=True)]
        mean = sum(ratios) / len(ratios)
        return sum((one - mean) ** 2 for one in ratios) / len(ratios), mean

    found = minimize_scalar(
        lambda exponent: missed(exponent)[0],
        bounds=(yarns.SMALLEST_EXPONENT, yarns.LARGEST_EXPONENT),
        options={"xatol": 1e-7},
    )
    exponent = _rounded(float(found.x))
    variance, mean = missed(exponent)
    deviation = sqrt(variance)
    if deviation > WORST_DEVIATION:
        allowed = f"one that the law follows to {WORST_DEVIATION:.0%}: are radius and core those of this yarn?"
        raise SpecificationError(
            "yarn.compression.table", f"a table that the best law misses by {deviation:.0%}", allowed
        )
    law = Compression(radius=radius, core=core, exponent=exponent, rigidity=_rounded(exp(mean)))
    return Fit(compression=law, deviation=deviation, points=len(rows))


def _require_rows(rows: Sequence[tuple[float, float]], first: int, largest: float) -> None:
    """Raise unless compressions and forces rise from above zero to below the core; rows are counted from `first`."""
    if len(rows) < FEWEST_POINTS:
        allowed = f"{FEWEST_POINTS} or more above zero"
        raise SpecificationError("yarn.compression.table", f"{len(rows)} rows", allowed)
    before = (0.0, 0.0)
    for number, (compression, force) in enumerate(rows, first):
        field = f"yarn.compression.table[{number}]"
        if not before[0] < compression < largest:
            allowed = f"above {1e3 * before[0]:.4g} mm and below {1e3 * largest:.4g} mm, where cores meet"
            raise SpecificationError(field, f"a compression of {1e3 * compression:.4g} mm", allowed)
        if not before[1] < force < float("inf"):
            allowed = f"above {1e-3 * before[1]:.4g} N/mm: the force rises"
            raise SpecificationError(field, f"a force of {1e-3 * force:.4g} N/mm", allowed)
        before = (compression, force)


def _rounded(number: float) -> float:
    """Return a number to six digits: the last bits of a search are those of one processor."""
    return float(f"{number:.{_DIGITS}g}")


def _unit_law(exponent: float, core: float) -> ContactLaw:
    """Return the law of unit radius with psi = 1 halfway to the core."""
    return make_yarn_law(1.0, exponent, core, 0.0)


@kernel
def parallel_force(height: float, law: ContactLaw) -> float:
    """Return the force by length of two parallel strands at a distance [r] below that of contact [E r].

    Abel's integral with x = h + (D - h) u (2 - u) and u = v^4, by Simpson's rule: dense near v = 0, where forces near
    the core are, and with p = (D - h) (1 - u)^2, whose powers of n - 1 are smooth at touch, v = 1.
    """
    intervals = 1024
    depth = law.distance - height
    total = 0.0
    for i in range(1, intervals):
        v = i / intervals
        u = v * v * v * v
        _, slope, _ = pair_potential(depth * (1.0 - u) * (1.0 - u), law)
        below = 2.0 * height + depth * u * (2.0 - u)
        total += (4.0 if i % 2 else 2.0) * slope * v * (1.0 - u) / sqrt((2.0 - u) * below)
    return 16.0 * height * sqrt(depth) * total / (3.0 * intervals)
