"""Figures of the cycles of a test, axis by axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.analysis.branches import branch
from rigs.analysis.moduli import FIRST_STRAIN, secant_modulus, stress_at
from rigs.analysis.work import cycle_work, hysteresis, is_closed, loop_area, work_put_in
from rigs.axes import SHEARS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray, IntArray
    from rigs.record import Phase

LEVELS: Final = (0.2, 0.3, 0.4)
"""Strains at which a cycle's stress is quoted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleFigures:
    """Figures of one axis over one cycle.

    Attributes
    ----------
    axis : str
        Course, wale or pile, or what a file calls it.
    cycle : int
        Counter of the set, from 1.
    stress : dict of float to float
        Stress on loading [Pa] by strain [1]; ``nan`` where the branch does not reach.
    loading_work : float
        Work of loading [J/m³]; of a shear all that the cycle takes, either way.
    loop_area : float
        Dissipated energy density [J/m³]; ``nan`` if the cycle did not come back to where it set out from.
    hysteresis : float
        Share of the loading work that was dissipated [1].
    initial_secant, peak_secant : float
        Secant moduli of loading from where the cycles set out: over the first `FIRST_STRAIN`, and to the largest
        strain [Pa]; ``nan`` where the branch does not reach so far.
    """

    axis: str
    cycle: int
    stress: dict[float, float]
    loading_work: float
    loop_area: float
    hysteresis: float
    initial_secant: float
    peak_secant: float


def cycle_figures(
    axis: str,
    strain: FloatArray,
    stress: FloatArray,
    phase: Sequence[Phase],
    cycle: IntArray,
    closed_within: float = 1e-3,
) -> tuple[CycleFigures, ...]:
    """Work out the figures of every cycle that was loaded.

    Parameters
    ----------
    axis : str
        Course, wale or pile, or what a file calls it.
    strain, stress : FloatArray, shape (n,)
        The whole test on this axis [1], [Pa].
    phase : sequence of Phase, length n
        Phase of every row.
    cycle : IntArray, shape (n,)
        Cycle of every row.
    closed_within : float
        Share of a cycle's range of strain within which it came back [1]; of a log with noise more than of a record.

    Returns
    -------
    tuple of CycleFigures
        One per cycle, in order.
    """
    found = []
    for number in np.unique(cycle[np.isin(np.asarray(phase), ["Stretch"])]):
        up = branch(phase, cycle, int(number), ["Stretch"])
        loop = branch(phase, cycle, int(number), ["Stretch", "Hold", "Recover"])
        closed = is_closed(strain[loop], closed_within)
        start, peak = float(strain[up[0]]), float(strain[up].max())
        area = loop_area(strain[loop], stress[loop]) if closed else float("nan")
        share = hysteresis(strain[loop], stress[loop]) if closed else float("nan")
        work = cycle_work(strain[up], stress[up])
        if axis in SHEARS:
            work = work_put_in(strain[loop], stress[loop])
            share = area / work if work > 0.0 else float("nan")
        found.append(
            CycleFigures(
                axis=axis,
                cycle=int(number),
                stress={at: stress_at(strain[up], stress[up], at) for at in LEVELS},
                loading_work=work,
                loop_area=area,
                hysteresis=share,
                initial_secant=secant_modulus(strain[up], stress[up], start + FIRST_STRAIN, start),
                peak_secant=secant_modulus(strain[up], stress[up], peak, start) if peak > start else float("nan"),
            )
        )
    return tuple(found)
