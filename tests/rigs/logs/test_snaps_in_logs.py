"""A real knit that snaps: its peak and its drop, from the solver to every log, the plot and the results table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.export import export_run
from app.records.reader import RunReader, read_run
from app.runs.use_cases import run_protocol
from app.schemas import loads
from app.views.curves import curves_of
from rigs.jumps import jumped
from rigs.logs.catalogue import LOGS
from tests.logged_forces import logged_forces

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import FloatArray

RATE, LONGEST = 50.0, 2.5
"""Samples per second, and the longest step [%]."""

SLACK = """
schema: knitlab/protocol@1
rig: uniaxial-frame
mount: P
specimen:
  {knit: volumetric-default, loops: [1, 1, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3, nodes_per_loop: 16}
speed_ref: pair
others: free
max_strain_increment: 2.5 %
log: {rate: 50 Hz, noise: off}
steps:
  - ramp: {axes: [P], to: {strain: 40 %}, rate: 1e-2 1/s}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunReader:
    """Pull two slack layers, whose loops slip over each other between 35 and 37.5 % of strain."""
    done = run_protocol(loads(SLACK), tmp_path_factory.mktemp("snap") / "slack", draw=None)
    assert done.outcome == "target"
    return read_run(done.folder)


def ends(run: RunReader) -> tuple[int, float, float]:
    """Return the last row before the snap, and the forces before and after it [N]."""
    rows, force = np.flatnonzero(jumped(run.trace)), run.trace.columns["force_P"]
    assert len(rows) == 1
    return int(rows[0]) - 1, float(force[rows[0] - 1]), float(force[rows[0]])


def assert_drops_at_once(run: RunReader, force: FloatArray) -> None:
    """Assert that samples show the largest force, and the snap as a fall from one sample to the next."""
    _, before, after = ends(run)
    rise, last = 0.01, int(np.argmin(np.diff(force)))
    assert force.max() == pytest.approx(run.trace.columns["force_P"].max(), abs=rise)
    assert force[last] == pytest.approx(before, abs=rise)
    assert force[last + 1] == pytest.approx(after, abs=rise)
    # None in between: a slope over the step that snaps would have a hundred.
    assert not np.any((force[last // 2 :] > 1.1 * after) & (force[last // 2 :] < force[last // 2]))


def test_a_snap_lies_between_two_rows_close_together(run: RunReader) -> None:
    before, force, after = ends(run)
    strain = 100.0 * run.strain("P")
    assert 35.0 < strain[before] < strain[before + 1] < 37.5
    assert strain[before + 1] - strain[before] == pytest.approx(LONGEST / 64.0, rel=1e-6)
    assert after < 0.6 * force
    # Over so short a step the force changes by less than 2 % of the drop.
    change = run.trace.columns["force_P"][before] - run.trace.columns["force_P"][before - 1]
    slope = abs(change) / (strain[before] - strain[before - 1])
    assert slope * LONGEST / 64.0 < 0.02 * (force - after)


@pytest.mark.parametrize("dialect", LOGS)
def test_every_dialect_shows_its_drop_within_a_sample(run: RunReader, dialect: str) -> None:
    assert_drops_at_once(run, logged_forces(dialect, run.trace, axis="P", rate=RATE))


def test_the_logs_of_the_run_show_it_and_its_results_table_the_maximum(run: RunReader, tmp_path: Path) -> None:
    samples = run.samples["uniaxial-frame"].measured["Force"]
    assert_drops_at_once(run, samples)
    (path,) = export_run(run.path, dialect="bluehill3-results", out=tmp_path)
    table = path.read_text(encoding="utf-8-sig")
    assert f"{samples.max():.5f}" in table


def test_the_plot_draws_it_upright(run: RunReader) -> None:
    last, before, after = ends(run)
    (curve,) = curves_of(run)
    drawn = {
        name: np.concatenate([getattr(part, name) for part in curve.parts]) for name in ("time", "strain", "force")
    }
    at = int(np.argmin(np.diff(drawn["force"])))
    assert drawn["force"][at : at + 2] == pytest.approx([before, after], abs=1e-9)
    assert drawn["time"][at : at + 2] == pytest.approx([run.trace.columns["time"][last]] * 2, abs=1e-9)
    assert drawn["strain"][at] == drawn["strain"][at + 1]
    assert drawn["force"].max() == pytest.approx(run.trace.columns["force_P"].max(), abs=1e-9)
