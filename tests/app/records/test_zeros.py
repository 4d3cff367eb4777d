"""Both zeros of a test in its record, figures, plot and logs: as printed, and where its slack was taken up."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import h5py
import numpy as np
import pytest

from app.records.export import export_run
from app.records.measurements import zeroings_of
from app.records.reader import RunReader
from app.records.results import figures_of
from app.runs.use_cases import run_protocol
from app.views.curves import curves_of
from tests.synthetic_run import BOTH, SIZE, make_run

if TYPE_CHECKING:
    from pathlib import Path

PROTOCOL = """
schema: knitlab/protocol@1
name: taut
rig: uniaxial-frame
mount: W
specimen: {knit: paper-fit, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 16}
others: free
log: {rate: 50 Hz, noise: off}
max_strain_increment: 0.05
steps:
  - zero: {channels: [force]}
  - preload: {axes: [W], force: 0.02 N, rate: 1 mm/s}
  - zero: {channels: [displacement], gauge_length: here}
  - cycle: {axes: [W], lower: 0, upper: 20 %, rate: 1 mm/s, n: 1}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunReader:
    folder = tmp_path_factory.mktemp("taut")
    path = folder / "taut.yaml"
    path.write_text(PROTOCOL, encoding="utf-8")
    result = run_protocol(path, folder / "run", lambda _share, _text: None)
    assert (result.outcome, result.message) == ("target", "")
    return RunReader(result.folder / "run.h5")


def test_the_record_holds_both_zeros(run: RunReader) -> None:
    with h5py.File(run.path) as file:
        zeros = {name: column[()].tolist() for name, column in file["zeros"].items()}
        assert {name: file["zeros"][name].attrs.get("units") for name in ("time", "gauge_length_W", "force_W")} == {
            "time": "s",
            "gauge_length_W": "m",
            "force_W": "N",
        }
    preload = [row for row, phase in enumerate(run.trace.phase) if phase == "Preload"][-1]
    columns = {name: float(column[preload]) for name, column in run.trace.columns.items()}
    printed, travel = run.size.extents["W"], columns["displacement_W"]
    assert travel > 0.02 * printed
    assert zeros.pop("force_W") == pytest.approx([0.0, 0.0, columns["force_W"]], abs=1e-12)
    assert zeros == {
        "place": [b"as printed", b"steps[0].zero", b"steps[2].zero"],
        "time": [0.0, 0.0, columns["time"]],
        "zeroed_force": [0, 1, 0],
        "zeroed_displacement": [0, 0, 1],
        "travel_W": [0.0, 0.0, travel],
        "gauge_length_W": [printed, printed, printed + travel],
    }


def test_figures_and_plot_count_from_the_preload(run: RunReader) -> None:
    figures = {name: value for name, value, _ in figures_of(run)}
    zeroing = zeroings_of(run)[-1]
    gauge, width = zeroing.gauges["W"], run.size.extents["C"]
    assert figures["gauge length W, as printed"] == run.size.extents["W"]
    assert figures["gauge length W, at the zero"] == gauge
    assert figures["travel W from as printed, at the zero"] == zeroing.travel["W"]
    assert figures["force W, at the zero"] == pytest.approx(0.02, rel=5e-3)
    columns = run.trace.columns
    peak = int(np.argmax(columns["displacement_W"]))
    assert columns["displacement_W"][peak] == pytest.approx(zeroing.travel["W"] + 0.2 * gauge)
    # The sides are free: nothing but the printed width is known of them.
    stress = columns["force_W"][peak] / (width * 1e-3)
    assert figures["stress at 20%, W, cycle 1"] == pytest.approx(stress)
    first = zeroing.force["W"] / (width * 1e-3)
    assert figures["secant modulus to peak, W, cycle 1"] == pytest.approx((stress - first) / 0.2)
    (curve,) = curves_of(run)
    loading = [part for part in curve.parts if part.role == "loading"][-1]
    assert [loading.strain[0], loading.strain[-1]] == pytest.approx([0.0, 0.2])
    assert loading.stress[-1] == pytest.approx(stress)


def test_logs_show_the_strain_of_the_gauge_length(run: RunReader, tmp_path: Path) -> None:
    zeroing = zeroings_of(run)[-1]
    (path,) = export_run(run.path, dialect="bluehill3-quoted", out=tmp_path)
    lines = path.read_text(encoding="utf-8").splitlines()[5:]
    table = np.array([[float(field.strip('"')) for field in line.split(",")] for line in lines])
    taken = table[:, 0] > zeroing.time
    for rows, gauge in ((taken, zeroing.gauges["W"]), (~taken, run.size.extents["W"])):
        assert table[rows, 3] == pytest.approx(100.0 * 1e-3 * table[rows, 1] / gauge, abs=1e-4)
    assert table[taken, 3].max() == pytest.approx(20.0, abs=0.15)
    (path,) = export_run(run.path, dialect="bluehill3", out=tmp_path)
    named = f"Dimension : Length,{1e3 * zeroing.gauges['W']:.5f},mm"
    assert path.read_text(encoding="utf-8").splitlines()[2] == named


def test_a_record_without_zeros_counts_from_those_of_its_steps(run: RunReader, tmp_path: Path) -> None:
    shutil.copy(run.path, tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        del file["zeros"]
    old, new = zeroings_of(RunReader(tmp_path / "run.h5")), zeroings_of(run)
    assert [(one.time, one.kinds) for one in old] == [(one.time, one.kinds) for one in new]
    assert not any(one.gauges for one in old)


def test_width_follows_the_other_axis_where_hooks_hold_it(tmp_path: Path) -> None:
    gauges = {axis: 1.25 * SIZE.gauge(axis) for axis in BOTH}
    plain, taken = make_run(tmp_path / "a.h5"), make_run(tmp_path / "b.h5", gauges=gauges)
    for one, two in zip(curves_of(plain), curves_of(taken), strict=True):
        for before, after in zip(one.parts, two.parts, strict=True):
            assert 1.25 * after.strain == pytest.approx(before.strain)
            assert 1.25 * after.stress == pytest.approx(before.stress)
        assert one.log is not None
        assert two.log is not None
        assert 1.25 * two.log.strain == pytest.approx(one.log.strain, nan_ok=True)
        assert 1.25 * two.log.stress == pytest.approx(one.log.stress, nan_ok=True)
    assert not any("gauge length" in name for name, _, _ in figures_of(plain))
