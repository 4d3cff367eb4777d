"""Surrogate of a test over its parameters by Gaussian processes, and proposals of where to test next.

Coordinates of parameters are from 0 to 1; features are what a test comes to, one number or several points of a curve.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigs.axes import FloatArray

LEAST_POINTS: Final = 4
"""Tests from which on a surrogate says anything."""

DRAWS: Final = 128
"""Draws from the surrogate at a candidate, for the expected improvement."""

MOST_LEFT_OUT: Final = 24
"""Tests that are left out in turn, to see how sure a surrogate may be."""

APART: Final = 0.01
"""Least distance of a candidate from every test, in the largest of the coordinates [1]."""

NORMAL_95: Final = 1.959964
"""Half-width of the 95 % interval of a normal distribution, in its standard deviations."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Goal:
    """Wanted features.

    Attributes
    ----------
    features : FloatArray, shape (m,)
        What a test shall come to.
    scale : float
        Difference of a feature that counts as 1.
    """

    features: FloatArray
    scale: float

    def distance(self, features: FloatArray) -> FloatArray:
        """Return the root mean square difference of features (..., m) from those wanted, in the scale [1], (...)."""
        found: FloatArray = np.sqrt(np.mean(((features - self.features) / self.scale) ** 2, axis=-1))
        return found


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prediction:
    """Features as the surrogate expects them at n coordinates: mean and 95 % interval, each of shape (n, m)."""

    mean: FloatArray
    low: FloatArray
    high: FloatArray


def require_extra() -> None:
    """Raise unless scikit-learn is installed.

    Raises
    ------
    SpecificationError
        How to get it.
    """
    try:
        import sklearn  # noqa: F401, PLC0415 (optional)
    except ImportError as error:
        found, expected = "an installation without scikit-learn", "one with the extra: pip install 'knitlab[design]'"
        raise SpecificationError("design", found, expected) from error


class Surrogate:
    """Gaussian process for each feature, with a Matérn kernel (ν = 5/2) of a length of its own along each coordinate.

    Features that are above 0 throughout are taken in logarithms, for a stiffness spans decades. Its hyperparameters
    maximise the marginal likelihood (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, 5.4.1).

    Parameters
    ----------
    z : FloatArray, shape (n, d)
        Coordinates of the tests.
    features : FloatArray, shape (n, m)
        What they came to.
    widening : FloatArray, shape (m,), optional
        Factor of the deviations; that of `widening_of`, where an interval is to be told.

    Raises
    ------
    SpecificationError
        For fewer than `LEAST_POINTS` tests.
    """

    def __init__(self, z: FloatArray, features: FloatArray, widening: FloatArray | None = None) -> None:
        if len(z) < LEAST_POINTS:
            raise SpecificationError("design", f"{len(z)} tests that can be used", f"{LEAST_POINTS} or more")
        self.logarithmic = bool((features > 0.0).all())
        values = np.log(features) if self.logarithmic else features
        self._processes = [_fitted(z, values[:, k]) for k in range(values.shape[1])]
        self._widening = np.ones(features.shape[1]) if widening is None else widening

    def predict(self, z: FloatArray) -> Prediction:
        """Return the features expected at coordinates (n, d)."""
        mean, deviation = self._normal(z)
        return Prediction(
            mean=self._back(mean),
            low=self._back(mean - NORMAL_95 * deviation),
            high=self._back(mean + NORMAL_95 * deviation),
        )

    def draws(self, z: FloatArray, seed: int = 0) -> FloatArray:
        """Return draws of the features at coordinates (n, d), each by itself, (DRAWS, n, m).

        The same normal numbers serve every coordinate, so that candidates compare without noise of the draws.
        """
        mean, deviation = self._normal(z)
        normal = np.random.default_rng(seed).standard_normal((DRAWS, 1, mean.shape[1]))
        return self._back(mean + deviation * normal)

    def residuals(self, z: FloatArray, features: FloatArray) -> FloatArray:
        """Return how far features (n, m) at coordinates (n, d) are from what is expected, in its deviations."""
        mean, deviation = self._normal(z)
        # What is not above 0 is beyond anything that was expected in logarithms.
        values = np.log(np.maximum(features, 1e-300)) if self.logarithmic else features
        found: FloatArray = (values - mean) / deviation
        return found

    def _normal(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return mean and deviation of the features at coordinates, in logarithms where they are taken so."""
        found = [process.predict(z, return_std=True) for process in self._processes]
        mean = np.stack([one for one, _ in found], axis=1)
        return mean, self._widening * np.stack([deviation for _, deviation in found], axis=1)

    def _back(self, values: FloatArray) -> FloatArray:
        return np.exp(values) if self.logarithmic else values


def widening_of(z: FloatArray, features: FloatArray) -> FloatArray:
    """Return by what to widen the deviations of a surrogate (m,): 1, or more where it is surer than its tests bear out.

    Of few tests the likelihood is often too sure. So each test is left out in turn, and what came of it compared with
    what a surrogate through the others expects: the root mean square of those residuals, in deviations, is the factor.

    Parameters
    ----------
    z, features : FloatArray, shape (n, d) and (n, m)
        The tests; at most `MOST_LEFT_OUT` of them, the last ones, are left out.
    """
    count = len(z)
    if count <= LEAST_POINTS:
        return np.ones(features.shape[1])
    squares = []
    for k in range(max(0, count - MOST_LEFT_OUT), count):
        others = np.arange(count) != k
        squares.append(Surrogate(z[others], features[others]).residuals(z[k : k + 1], features[k : k + 1])[0] ** 2)
    found: FloatArray = np.maximum(1.0, np.sqrt(np.mean(squares, axis=0)))
    return found


def _fitted(z: FloatArray, values: FloatArray) -> Any:  # noqa: ANN401 (scikit-learn ships no types)
    """Return a Gaussian process through values (n,) at coordinates (n, d)."""
    from sklearn.exceptions import ConvergenceWarning  # noqa: PLC0415 (optional)
    from sklearn.gaussian_process import GaussianProcessRegressor  # noqa: PLC0415
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel  # noqa: PLC0415

    shape = Matern(length_scale=np.ones(z.shape[1]), length_scale_bounds=(0.1, 30.0), nu=2.5)
    # What a mesh and steps leave of roughness, in the deviation of the values.
    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * shape + WhiteKernel(1e-5, (1e-8, 1e-1))
    process = GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=1, random_state=0)
    with warnings.catch_warnings():
        # A length at its bound says that a parameter has no influence.
        warnings.simplefilter("ignore", ConvergenceWarning)
        return process.fit(z, values)


def ranked(surrogate: Surrogate, goal: Goal, z: FloatArray, best: float) -> tuple[list[int], list[int]]:
    """Return candidates (n, d) in the order of what they promise: by expected improvement, and by expected distance.

    The expected improvement is E[max(best - distance, 0)] (Jones, Schonlau and Welch, J. Global Optim. 13 (1998) 455)
    over draws of the features; the expected distance is the mean over them.

    Parameters
    ----------
    surrogate : Surrogate
        The surrogate.
    goal : Goal
        What is wanted.
    z : FloatArray, shape (n, d)
        Candidates.
    best : float
        Least distance of a test so far [1].
    """
    distance = goal.distance(surrogate.draws(z))
    improvement = np.maximum(best - distance, 0.0).mean(axis=0)
    expected = distance.mean(axis=0)
    return np.argsort(-improvement, kind="stable").tolist(), np.argsort(expected, kind="stable").tolist()


def candidates(
    tested: FloatArray,
    near: Sequence[FloatArray],
    seed: int,
    snap: Callable[[FloatArray], FloatArray] = lambda z: z,
) -> FloatArray:
    """Return coordinates to choose from (k, d): all over the unit cube, and about the best tests.

    Parameters
    ----------
    tested : FloatArray, shape (n, d)
        Coordinates of all tests; what is nearer to one than `APART` is left out.
    near : sequence of FloatArray, shape (d,)
        The best tests.
    seed : int
        Of the random numbers.
    snap : callable
        Coordinates (k, d) moved to those that there are, where a parameter has few values.
    """
    from scipy.stats import qmc  # noqa: PLC0415 (takes long to import)

    chance, count = np.random.default_rng(seed), tested.shape[1]
    parts = [qmc.Sobol(count, rng=chance).random(1024)]
    for width in (0.15, 0.05, 0.02):
        parts += [np.clip(at + width * chance.standard_normal((128, count)), 0.0, 1.0) for at in near]
    found = snap(np.concatenate(parts))
    gaps = np.abs(found[:, None, :] - tested[None, :, :]).max(axis=2).min(axis=1)
    kept: FloatArray = found[gaps > APART]
    return kept
