"""Make measurements by formula."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigs.analysis.branches import strokes_of
from rigs.measurement import Measurement

if TYPE_CHECKING:
    from rigs.axes import FloatArray

GAUGE, SECTION = 0.05, 4e-5


def measurement(strain: FloatArray, stress: FloatArray, name: str = "made", axis: str = "C") -> Measurement:
    """Return a measurement of a specimen 50 mm long with a section of 40 mm x 1 mm, a row a second."""
    cycle, phase = strokes_of(strain)
    return Measurement(
        name=name,
        axis=axis,
        time=np.arange(len(strain), dtype=np.float64),
        travel=GAUGE * strain,
        force=SECTION * stress,
        strain=strain,
        stress=stress,
        transverse=-0.3 * strain,
        cycle=cycle,
        phase=phase,
    )


def cycles(count: int = 2, top: float = 0.4, rows: int = 101) -> tuple[FloatArray, FloatArray]:
    """Return strain and stress of cycles: up along 1e5 ε, back along 1e5 ε² / top."""
    up = np.linspace(0.0, top, rows)
    strain = np.concatenate([up, up[-2::-1]] * count)
    stress = np.concatenate([1e5 * up, (1e5 / top) * up[-2::-1] ** 2] * count)
    return strain, stress
