"""Whether the curves of many designs are one: fitted exponents, and how far curves lie apart before and after.

Each design is a knit with its own lengths and material and a curve of stress over strain. A scaling is a factor a
design that its stress is multiplied with, and another by which its strain is divided; curves that collapse on each
other are one master curve. All is measured on ln(stress), so that small stresses count as much as large ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigs.axes import Axis, FloatArray

FEWEST: Final = 8
"""Curves from which a spread is told."""

POINTS: Final = 33
"""Places at which curves are compared."""

NORMAL: Final = 1.349
"""Range of the middle half of a normal distribution, in its standard deviation."""

TRIALS: Final = 2000
"""Permutations of a test."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Design:
    """One design and its curve along one axis.

    Attributes
    ----------
    name : str
        What it is called.
    axis : Axis
        Axis that was pulled.
    values : Mapping
        Its parameters, all above 0 [any unit, the same in all designs].
    strain, stress : FloatArray, shape (n,)
        First loading [1], [Pa], strain rising.
    """

    name: str
    axis: Axis
    values: Mapping[str, float]
    strain: FloatArray
    stress: FloatArray

    def stress_at(self, strain: float | FloatArray) -> FloatArray:
        """Return the stress at strains [Pa]; nan beyond the curve, and where it is not above 0."""
        found = np.interp(strain, self.strain, self.stress, left=np.nan, right=np.nan)
        return np.where(found > 0.0, found, np.nan)


class Exponent(NamedTuple):
    """Fitted exponent of a parameter, and half the width of its 95 % confidence interval [1]."""

    name: str
    value: float
    half_width: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerLaw:
    """Fit of ln(stress) at one strain by a constant and the logarithms of the parameters.

    Attributes
    ----------
    exponents : tuple of Exponent
        One a parameter.
    constant : float
        ln(stress) where all parameters are 1 [1].
    r_squared : float
        Share of the variance of ln(stress) that is explained [1].
    left_out : float
        Root mean square of the error of ln(stress) of designs that were left out of the fit, one by one [1].
    p_value : float
        Share of fits to permuted designs that explain as much [1].
    designs : int
        Designs that have a stress there.
    """

    exponents: tuple[Exponent, ...]
    constant: float
    r_squared: float
    left_out: float
    p_value: float
    designs: int

    def stress(self, values: Mapping[str, float]) -> float:
        """Return the stress of a design by its parameters [Pa]."""
        logs = sum(one.value * np.log(values[one.name]) for one in self.exponents)
        return float(np.exp(self.constant + logs))


def power_law(designs: Sequence[Design], names: Sequence[str], at: float, *, seed: int = 0) -> PowerLaw:
    """Fit exponents to the stresses of designs at a strain.

    Ordinary least squares on logarithms; intervals by Student's t; errors of designs left out by the leverages
    (Allen's PRESS, Technometrics 16:125, 1974); the permutation test assigns the stresses to the designs at random
    (Freedman and Lane 1983).

    Parameters
    ----------
    designs : sequence of Design
        Those of one axis.
    names : sequence of str
        Parameters to fit.
    at : float
        Strain [1].
    seed : int
        Of the permutations.

    Raises
    ------
    SpecificationError
        If fewer designs have a stress there than the fit needs, or a parameter has one value in all of them.
    """
    stresses = np.array([float(one.stress_at(at)) for one in designs])
    good = np.isfinite(stresses)
    count, needed = int(good.sum()), len(names) + 3
    if count < needed:
        raise SpecificationError(
            "designs", f"{count} with a stress at {at:.3g}", f"{needed} or more for {len(names)} parameters"
        )
    logs = np.log([[one.values[name] for name in names] for one, used in zip(designs, good, strict=True) if used])
    centred = logs - logs.mean(axis=0)
    same = [name for name, spread in zip(names, np.ptp(centred, axis=0), strict=True) if spread < 1e-9]
    if same:
        raise SpecificationError(same[0], "one value in all designs", "values that differ, or a fit without it")
    matrix = np.column_stack([np.ones(count), centred])
    y = np.log(stresses[good])
    inverse = np.linalg.inv(matrix.T @ matrix)
    found = inverse @ matrix.T @ y
    rest = y - matrix @ found
    free = count - matrix.shape[1]
    total = float(((y - y.mean()) ** 2).sum())
    explained = 1.0 - float((rest**2).sum()) / total
    leverage = np.einsum("ij,jk,ik->i", matrix, inverse, matrix)
    half = _student(free) * np.sqrt(np.diag(inverse) * float((rest**2).sum()) / free)
    rng = np.random.default_rng(seed)
    hat = matrix @ inverse @ matrix.T
    as_good = 0
    for _ in range(TRIALS):
        permuted = rng.permutation(y)
        as_good += 1.0 - float(((permuted - hat @ permuted) ** 2).sum()) / total >= explained
    return PowerLaw(
        exponents=tuple(Exponent(*one) for one in zip(names, map(float, found[1:]), map(float, half[1:]), strict=True)),
        constant=float(found[0] - logs.mean(axis=0) @ found[1:]),
        r_squared=explained,
        left_out=float(np.sqrt(((rest / (1.0 - leverage)) ** 2).mean())),
        p_value=(1 + as_good) / (1 + TRIALS),
        designs=count,
    )


def _student(free: int) -> float:
    """Return the 97.5 % quantile of Student's t."""
    from scipy.stats import t  # noqa: PLC0415 (imported where intervals are wanted)

    return float(t.ppf(0.975, free))


@dataclass(frozen=True, slots=True, kw_only=True)
class Collapse:
    """How far curves lie apart under a scaling.

    Attributes
    ----------
    name : str
        The scaling.
    spread : float
        Spread of ln(scaled stress) between designs: the range of the middle half over 1.349, the standard deviation of
        a normal one; root mean square over the strains that all have [1].
    first, last : float
        Scaled strains between which they are compared [1].
    curves : int
        Curves compared.
    """

    name: str
    spread: float
    first: float
    last: float
    curves: int


def collapse(
    name: str,
    designs: Sequence[Design],
    factors: Sequence[float],
    locks: Sequence[float] | None = None,
    *,
    between: tuple[float, float] | None = None,
) -> Collapse:
    """Return how far curves lie apart whose stresses are multiplied by factors, and strains divided by `locks`.

    Parameters
    ----------
    name : str
        What the scaling is called.
    designs : sequence of Design
        Curves of any axes.
    factors : sequence of float
        One a design, above 0.
    locks : sequence of float, optional
        One a design, above 0; by default strains are not scaled.
    between : tuple of two floats, optional
        Scaled strains between which curves are compared; by default those that all curves have, the upper half.

    Raises
    ------
    SpecificationError
        If there are fewer than eight curves, or no strain that all of them have.
    """
    if len(designs) < FEWEST:
        raise SpecificationError("designs", len(designs), f"{FEWEST} or more")
    scale = np.ones(len(designs)) if locks is None else np.asarray(locks)
    last = min(float(one.strain[-1]) / by for one, by in zip(designs, scale, strict=True))
    first, last = (0.5 * last, last) if between is None else between
    places = np.linspace(first, last, POINTS)
    table = np.array(
        [
            np.log(factor * one.stress_at(np.minimum(places * by, one.strain[-1])))
            for one, factor, by in zip(designs, factors, scale, strict=True)
        ]
    )
    whole = np.isfinite(table).all(axis=0)
    if not whole.any():
        raise SpecificationError("designs", f"no strain from {first:.3g} to {last:.3g} at which all are pulled", "one")
    low, high = np.percentile(table[:, whole], [25.0, 75.0], axis=0)
    spread = float(np.sqrt((((high - low) / NORMAL) ** 2).mean()))
    return Collapse(name=name, spread=spread, first=first, last=last, curves=len(designs))


def paper_factor(values: Mapping[str, float], axis: Axis) -> float:
    """Return xi of the paper, v d^3 a^2 / (E^2 n^2 r^4), v being 0.5 along the course and 1 along the wale.

    It is called a number there, but has the unit 1/(Pa^2 m).
    """
    direction = 0.5 if axis == "C" else 1.0
    geometry = values["d"] ** 3 * values["a"] ** 2
    return direction * geometry / (values["E"] ** 2 * values["n"] ** 2 * values["r"] ** 4)


def bending_factor(values: Mapping[str, float], axis: Axis) -> float:  # noqa: ARG001 (the same along both)
    """Return Sigma over stress: t L l w / (E I) [1/Pa], of yarn of length L a loop, thickness t and second moment I.

    Bending energy of a loop goes like E I / L, and its volume is t l w: dimensional analysis.
    """
    second_moment = values["n"] * np.pi * values["r"] ** 4 / 4.0
    return float(values["t"] * values["L"] * values["l"] * values["w"] / (values["E"] * second_moment))
