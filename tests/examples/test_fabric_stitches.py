"""Relaxed fabrics of one yarn: garter extends far more along the wale than stockinette."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import pytest

from app.records.reader import RunReader
from app.runs.use_cases import run_protocol

if TYPE_CHECKING:
    from rigs.axes import Axis, Direction

EXAMPLES: Final = Path(__file__).parents[2] / "examples" / "fabric"
FORCE: Final = 20.0
"""Force per relaxed width at which extensions are compared [N/m]."""


def extension(name: str, axis: Axis, other: Direction, folder: Path) -> float:
    """Return the extension of an example at the force per width that is compared [1]."""
    assert run_protocol(EXAMPLES / f"{name}.yaml", folder / name, draw=None).outcome == "target"
    run = RunReader(folder / name / "run.h5")
    strain = run.trace.columns[f"displacement_{axis}"] / run.size.gauge(axis)
    force = run.trace.columns[f"force_{axis}"] / run.size.extents[other]
    assert force.max() > FORCE
    return float(np.interp(FORCE, force, strain))


@pytest.mark.slow
def test_garter_extends_far_more_along_the_wale_than_stockinette(tmp_path: Path) -> None:
    stockinette, garter = (extension(f"{name}_wale", "W", "C", tmp_path) for name in ("stockinette", "garter"))
    assert garter > 3.0 * stockinette > 0.0


@pytest.mark.slow
def test_rib_extends_far_more_along_the_course_than_stockinette(tmp_path: Path) -> None:
    stockinette, rib = (extension(f"{name}_course", "C", "W", tmp_path) for name in ("stockinette", "rib"))
    assert rib > 3.0 * stockinette > 0.0
