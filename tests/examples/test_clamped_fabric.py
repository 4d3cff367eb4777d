"""A specimen of the measured acrylic between clamps, beside the periodic cell and the measured fabric."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import load, loads, to_yaml
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import BoundEdges
from rigs.analysis.clasps import clasps_of
from rigs.protocol.extensometer import Extensometer
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.steps import Preload
from tests.examples.test_fabric import EXAMPLES, MEASURED

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rigs.protocol.protocol import Protocol


def run_of(protocol: Protocol, folder: Path) -> RunReader:
    """Run a protocol to its end."""
    folder.mkdir()
    (folder / "fabric.yaml").write_text(to_yaml(protocol), encoding="utf-8")
    result = run_protocol(folder / "fabric.yaml", folder / "run", draw=None)
    assert result.outcome == "target"
    return RunReader(result.folder / "run.h5")


@pytest.mark.slow
def test_a_specimen_of_relaxed_loops_keeps_their_pitch_and_comes_to_no_force(tmp_path: Path) -> None:
    whole = load(EXAMPLES / "clamped_wale.yaml").protocol
    spec = replace(whole.specimen, rows=4, loops=3, nodes_per_loop=12)
    made = make_specimen(spec)
    # A stitch keeps its yarn; 11.28 mm of it relax to about 3.1 mm by 1.9 mm.
    yarn = made.fabric.loop_length(made.counts) * made.loop_width
    assert yarn == pytest.approx(11.28e-3, rel=0.01)
    assert made.loop_width == pytest.approx(3.1e-3, rel=0.05)
    preload = tuple(step for step in whole.steps if isinstance(step, Preload))
    pins = Extensometer(wale=(1, 2))
    run = run_of(replace(whole, specimen=spec, steps=preload, extensometer=pins), tmp_path / "specimen")
    columns = run.trace.columns
    assert set(clasps_of(run.trace)["rows"]) == {9}
    # The edges push the clamps apart before these give way, by a small part of what the fabric bears.
    assert -0.5 < columns["force_W"][0] < 0.0
    assert columns["force_W"][-1] == pytest.approx(1e-3, abs=1e-4)
    assert columns["pin_distance_W"][-1] == pytest.approx(1.9e-3, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "clasps"), [("clamped_wale", 40), ("held_wale", 30)])
def test_inner_stitches_of_a_clamped_specimen_stretch_as_the_cell_and_the_measured_fabric(
    name: str, clasps: int, bar: Callable[..., None], tmp_path: Path
) -> None:
    cell = load(EXAMPLES / "acrylic_wale.yaml").protocol
    cell = replace(cell, specimen=replace(cell.specimen, nodes_per_loop=16))
    fabric = run_of(cell, tmp_path / "cell")
    specimen = run_of(load(EXAMPLES / f"{name}.yaml").protocol, tmp_path / "specimen")
    pitch = fabric.size.extents["C"] / 2.0
    peak = int(np.argmax(fabric.strain("W"))) + 1
    columns = specimen.trace.columns
    zero = int(np.flatnonzero(columns["step"] < columns["step"].max())[-1])
    pins = columns["pin_distance_W"][zero:]
    counts = specimen.test.specimen
    width = counts.loops * pitch
    at = [0.05, 0.10, 0.15, 0.20]
    inner = np.interp(at, pins / pins[0] - 1.0, 1e-3 * columns["force_W"][zero:] / width)
    periodic = np.interp(at, fabric.strain("W")[:peak], 1e-3 * fabric.force("W")[:peak] / fabric.size.extents["C"])
    measured = np.interp(at, MEASURED["wale"]["strain"], MEASURED["wale"]["force"])
    note = f"{counts.rows} rows of {counts.loops} loops"
    for what, other in (("the cell", periodic), ("the measured fabric", measured)):
        bar(f"acrylic, {name}: force per width by {what}", np.abs(inner / other - 1).max(), 0.15, "1", note)
    assert energy_balance_error(specimen.trace) < 0.01
    assert set(clasps_of(specimen.trace)["rows"]) == {clasps}


@pytest.mark.slow
def test_a_specimen_with_slack_chains_stretches_along_the_course_as_the_measured_fabric(
    bar: Callable[..., None], tmp_path: Path
) -> None:
    protocol = load(EXAMPLES / "clamped_course.yaml").protocol
    made = make_specimen(protocol.specimen)
    assert isinstance(made.fabric, BoundEdges)
    width = made.counts.rows * made.fabric.knit.row_spacing * made.loop_width
    specimen = run_of(protocol, tmp_path / "specimen")
    columns = specimen.trace.columns
    zero = int(np.flatnonzero(columns["step"] < columns["step"].max())[-1])
    pins = columns["pin_distance_C"][zero:]
    at = [0.1, 0.2, 0.3]
    force = np.interp(at, pins / pins[0] - 1.0, 1e-3 * columns["force_C"][zero:] / width)
    measured = np.interp(at, MEASURED["course"]["strain"], MEASURED["course"]["force"])
    note = "6 rows of 6 loops, slack 10 %"
    bar("acrylic, clamped_course: force per width", np.abs(force / measured - 1.0).max(), 0.25, "1", note)
    # Chains so slack neither pull nor push on the rows.
    assert abs(columns["force_C"][0]) < 0.01
    assert {name: set(held) for name, held in clasps_of(specimen.trace).items()} == {
        "rows": {30},
        "bound_off": {10},
        "cast_on": {9},
    }


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rest_shape: straight", "rest_shape: as-printed", "a yarn that is straight at rest"),
        ("grips: clamps", "periodic: on", "nothing in a periodic cell, which is relaxed itself"),
        (
            "{curvature: 1.5, height: 0.55, depth: 0.3, row_spacing: 0.69, fibre_radius: 0.05}",
            "garter",
            "none of this knit",
        ),
    ],
)
def test_what_cannot_be_made_of_relaxed_loops_is_refused(old: str, new: str, said: str) -> None:
    text = (EXAMPLES / "clamped_wale.yaml").read_text(encoding="utf-8")
    materials = (EXAMPLES / "materials" / "acrylic.yaml").read_text(encoding="utf-8")
    assert old in text
    with pytest.raises(SpecificationError, match=said):
        loads(text.replace(old, new).replace("extensometer: on", "extensometer: off"), materials=materials)
