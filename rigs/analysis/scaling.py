"""Test of a scaling that is given beforehand, such as the paper's ξ: whether it brings curves of designs together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError
from rigs.analysis.master_curve import FEWEST, POINTS, TRIALS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.analysis.master_curve import Design
    from rigs.axes import FloatArray

SEED: Final = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class ScalingTest:
    """How well a factor a design makes one curve of all.

    Attributes
    ----------
    before, after : float
        Standard deviation of ln(stress) and of ln(factor · stress) between designs, root mean square over strains [1].
    r_squared : float
        1 - (after / before)²: share of the scatter that the factors explain [1]; below 0 where they add to it.
    left_out : float
        Root mean square error of ln(stress) of a design that is predicted by the mean curve of all others [1].
    p_value : float
        Share of random dealings of the factors to the designs after which curves are as near as with their own [1].
    first, last : float
        Strains between which curves are compared [1].
    curves : int
        How many.
    """

    before: float
    after: float
    r_squared: float
    left_out: float
    p_value: float
    first: float
    last: float
    curves: int


def log_stresses(designs: Sequence[Design], between: tuple[float, float]) -> FloatArray:
    """Return ln(stress) of designs at equally spaced strains, (designs, strains); nan where one has none."""
    places = np.linspace(*between, POINTS)
    return np.array([np.log(one.stress_at(places)) for one in designs])


def scaling_test(designs: Sequence[Design], factors: Sequence[float], between: tuple[float, float]) -> ScalingTest:
    """Test whether stresses of designs, each times its factor, are one curve.

    With y = ln(stress) and f = ln(factor) of design i at strain ε, the scatter is s² = Σ (y + f - mean)² / (n - 1) at
    each strain, mean over the designs. A design left out is predicted as the mean of the others less its own f; its
    error is n / (n - 1) times its deviation from the mean. Factors are dealt to the designs at random `TRIALS` times
    (permutation test: R. A. Fisher, The Design of Experiments, 1935, 21).

    Parameters
    ----------
    designs : sequence of Design
        Curves of any axes.
    factors : sequence of float
        One a design, above 0 [any unit, the same in all].
    between : tuple of two floats
        Strains between which curves are compared [1].

    Raises
    ------
    SpecificationError
        If there are fewer than eight curves, or no strain at which all have a stress.
    """
    if len(designs) < FEWEST:
        raise SpecificationError("designs", len(designs), f"{FEWEST} or more")
    table = log_stresses(designs, between)
    table = table[:, np.isfinite(table).all(axis=0)]
    if not table.size:
        raise SpecificationError("designs", f"no strain from {between[0]:g} to {between[1]:g} at which all pull", "one")
    logs = np.log(np.asarray(factors, dtype=np.float64))[:, None]
    before, after = _scatter(table), _scatter(table + logs)
    deviations = (table + logs) - (table + logs).mean(axis=0)
    count = len(designs)
    as_near = _as_near(table.mean(axis=1), logs[:, 0])
    return ScalingTest(
        before=before,
        after=after,
        r_squared=1.0 - (after / before) ** 2 if before > 0.0 else float("nan"),
        left_out=float(np.sqrt(np.mean((deviations * count / (count - 1)) ** 2))),
        p_value=(1 + as_near) / (1 + TRIALS),
        first=between[0],
        last=between[1],
        curves=count,
    )


def _as_near(levels: FloatArray, logs: FloatArray) -> int:
    """Return how many dealings of ln(factor), (n,), leave curves of mean ln(stress) (n,) as near as their own.

    A factor is the same at all strains, so that s² is a constant plus twice the covariance of both.
    """
    rng = np.random.default_rng(SEED)
    centred = levels - levels.mean()
    own = float(centred @ logs)
    slack = 1e-12 * float(np.linalg.norm(centred) * np.linalg.norm(logs))
    return sum(float(centred @ rng.permutation(logs)) <= own + slack for _ in range(TRIALS))


def _scatter(table: FloatArray) -> float:
    """Return the standard deviation between designs (n, strains), root mean square over strains."""
    return float(np.sqrt(np.mean(table.var(axis=0, ddof=1))))
