"""Moduli of a loading branch between two of its points, and the stress at a strain."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from rigs.axes import FloatArray

FIRST_STRAIN: Final = 0.004
"""The paper's moduli are secants "up to 0.4 % strain"."""


def stress_at(strain: FloatArray, stress: FloatArray, at: float) -> float:
    """Return the stress where a loading branch first reaches a strain, linearly between rows.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The branch; noise may make the strain step back, so its running maximum is used.
    at : float
        Strain asked for [1].

    Returns
    -------
    float
        Stress [Pa]; ``nan`` outside the branch.
    """
    reached = np.maximum.accumulate(strain)
    # A target of 40 % reached to within a rounding error or an encoder step is reached.
    slack = 1e-9 + 1e-4 * abs(at)
    if not len(strain) or not reached[0] - slack <= at <= reached[-1] + slack:
        return float("nan")
    return float(np.interp(at, reached, stress))


def secant_modulus(strain: FloatArray, stress: FloatArray, to: float, start: float = 0.0) -> float:
    """Return E_s = (σ(ε₁) - σ(ε₀)) / (ε₁ - ε₀) of a loading branch.

    Parameters
    ----------
    strain, stress : FloatArray, shape (n,)
        The branch [1], [Pa].
    to, start : float
        Strains ε₁ and ε₀ [1]; the paper quotes the secant from rest "up to 0.4 %".

    Returns
    -------
    float
        Secant modulus [Pa]; ``nan`` if the branch does not reach so far.

    Raises
    ------
    SpecificationError
        If both strains are the same.
    """
    if to == start:
        raise SpecificationError("to", to, f"a strain other than {start}")
    rise = stress_at(strain, stress, to) - stress_at(strain, stress, start)
    return rise / (to - start)
