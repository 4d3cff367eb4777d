"""A real fabric predicted from its yarn: forces and contraction beside the measured repeats."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import load
from knitlab_core.knits import Counts

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigs.axes import Axis, Direction

EXAMPLES: Final = Path(__file__).parents[2] / "examples" / "fabric"

#: Mean force per width [N/mm] and strain across of repeats 2 to 5, at strains (docs/fabrics.md).
MEASURED: Final = {
    "course": {
        "strain": [0.10, 0.20, 0.30, 0.40, 0.50],
        "force": [0.0369, 0.0685, 0.1152, 0.2016, 0.401],
        "across": [-0.0288, -0.0776, -0.1338, -0.1835, -0.2296],
    },
    "wale": {
        "strain": [0.05, 0.10, 0.15, 0.20, 0.25],
        "force": [0.0296, 0.0652, 0.104, 0.1628, 0.2506],
        "across": [-0.0222, -0.0491, -0.0737, -0.0958, -0.1171],
    },
}


@pytest.mark.slow
@pytest.mark.parametrize(("along", "axis", "other"), [("course", "C", "W"), ("wale", "W", "C")])
def test_the_acrylic_stockinette_is_predicted_from_its_yarn(
    bar: Callable[..., None], along: str, axis: Axis, other: Direction, tmp_path: Path
) -> None:
    assert run_protocol(EXAMPLES / f"acrylic_{along}.yaml", tmp_path / "run", draw=None).outcome == "target"
    run = RunReader(tmp_path / "run" / "run.h5")
    columns, extents = run.trace.columns, run.size.extents
    strain = run.strain(axis)
    up = int(np.argmax(strain)) + 1
    at = MEASURED[along]["strain"]
    force = np.interp(at, strain[:up], 1e-3 * columns[f"force_{axis}"][:up] / extents[other])
    across = np.interp(at, strain[:up], columns[f"cell_{other}"][:up] / extents[other] - 1.0)
    source = "Singal et al. 2024, repeats 2 to 5"
    bar(f"acrylic, {along}: force per width", np.abs(force / MEASURED[along]["force"] - 1.0).max(), 0.25, "1", source)
    bar(f"acrylic, {along}: strain across", np.abs(across - MEASURED[along]["across"]).max(), 0.04, "1", source)
    assert energy_balance_error(run.trace) < 0.01
    # A stitch has the length of yarn that was measured; the fabric at rest pulls at nothing.
    spec = load(EXAMPLES / f"acrylic_{along}.yaml").protocol.specimen
    assert spec.fabric.loop_length(Counts(2, 2)) * spec.loop_width == pytest.approx(11.28e-3, rel=1e-3)
    assert abs(columns[f"force_{axis}"][0]) < 1e-4 * columns[f"force_{axis}"].max()
