"""The examples of shear: a printed cell that is pre-strained, and a real fabric; and what is refused of a shear."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from app.checks.dry_run import dry_run
from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import ProtocolError, loads

EXAMPLES = Path(__file__).parents[2] / "examples"
TEXT = (EXAMPLES / "shear_cell.yaml").read_text(encoding="utf-8")


def curve(run: RunReader, axis: str) -> tuple[np.ndarray, np.ndarray]:
    """Return strain [1] and stress [Pa] of an axis at every row."""
    return run.strain(axis), run.force(axis) / run.size.section(axis)  # type: ignore[arg-type]


@pytest.fixture(scope="module", name="sheared")
def _sheared(tmp_path_factory: pytest.TempPathFactory) -> RunReader:
    """Run the example of a printed cell, on a coarse mesh, for one cycle."""
    folder = tmp_path_factory.mktemp("shear")
    path = folder / "shear_cell.yaml"
    text = TEXT.replace("loop: 8 mm", "loop: 8 mm\n  nodes_per_loop: 16").replace("n: 2", "n: 1")
    path.write_text(text, encoding="utf-8")
    assert run_protocol(path, folder / "out", draw=None).outcome == "target"
    return RunReader(folder / "out" / "run.h5")


def test_a_pre_strained_cell_resists_shear_both_ways_alike_and_friction_takes_its_loop(sheared: RunReader) -> None:
    strain, stress = curve(sheared, "WC")
    assert (strain.min(), strain.max()) == pytest.approx((-0.2, 0.2))
    # The stitch is its own mirror image; friction remembers little of which side came first.
    assert stress.min() == pytest.approx(-stress.max(), rel=0.01)
    assert stress.max() > 5e3
    last = sheared.trace.columns["cycle"] == sheared.trace.columns["cycle"][-1]
    first = int(np.flatnonzero(last)[0]) - 1
    lost = np.diff(sheared.trace.columns["friction_work"][[first, -1]])[0]
    volume = np.prod(list(sheared.size.extents.values()))
    area = np.trapezoid(stress[first:], strain[first:])
    assert area * volume == pytest.approx(lost, rel=0.03)
    assert area > 0.03 * stress.max() * 0.4
    assert energy_balance_error(sheared.trace) < 0.01


def test_shear_of_a_cell_that_is_held_draws_yarn_from_its_lengths(sheared: RunReader) -> None:
    strain, _ = curve(sheared, "WC")
    columns = sheared.trace.columns
    upright = np.flatnonzero((columns["step"] == 3) & (np.abs(strain) < 1e-9))
    for axis in ("C", "W"):
        force = columns[f"force_{axis}"]
        assert force[np.argmax(strain)] > 1.5 * np.abs(force[upright]).max()
    np.testing.assert_allclose(columns["cell_WC"], columns["displacement_WC"], atol=1e-15)
    held = columns["step"] >= 2
    np.testing.assert_allclose(columns["cell_W"][held], 1.28 * sheared.size.extents["W"])


def test_the_log_of_a_shear_has_shear_strain_and_stress(sheared: RunReader) -> None:
    with (sheared.path.with_name("shear_cell_shear.csv")).open(encoding="utf-8", newline="") as file:
        heading, units, *rows = csv.reader(file)
    found = {name: np.array([float(row[k]) for row in rows]) for k, name in enumerate(heading)}
    assert dict(zip(heading, units, strict=True))["Shear stress WC"] == "(kPa)"
    strain, stress = curve(sheared, "WC")
    assert found["Shear strain WC"].min() == pytest.approx(strain.min(), rel=1e-3)
    assert 1e3 * found["Shear stress WC"].max() == pytest.approx(stress.max(), rel=0.01)
    # Of a planar knit, 1 mm thick by convention, the stress in kPa is the force per width in N/m.
    width = sheared.size.extents["C"]
    np.testing.assert_allclose(found["Shear stress WC"], found["Force WC"] / width, atol=1e-4 / width)


def test_friction_carries_most_of_the_shear_of_a_real_fabric(tmp_path: Path) -> None:
    assert run_protocol(EXAMPLES / "fabric" / "acrylic_shear.yaml", tmp_path / "run", draw=None).outcome == "target"
    run = RunReader(tmp_path / "run" / "run.h5")
    strain, stress = curve(run, "WC")
    columns = run.trace.columns
    second = columns["cycle"] == 2
    up, down = (np.flatnonzero(second & (np.array(run.trace.phase) == phase)) for phase in ("Stretch", "Recover"))
    # Half the width of the loop at no strain against half its height at the ends: what friction and what loops carry.
    width, height = np.interp(0.0, strain[up], stress[up]), stress[up].max()
    assert np.interp(0.0, strain[down[::-1]], stress[down[::-1]]) == pytest.approx(-width, rel=0.03)
    assert 0.3 < width / height < 0.7
    assert np.ptp(stress[second]) == pytest.approx(2.0 * height, rel=0.02)
    # Stuck, the fabric is several times as stiff as sliding.
    stuck, sliding = (
        (np.interp(b, strain[up], stress[up]) - np.interp(a, strain[up], stress[up])) / (b - a)
        for a, b in ((-0.139, -0.13), (-0.02, 0.08))
    )
    assert stuck > 3.0 * sliding > 0.0
    # Its lengths are free, and change little.
    for axis in ("C", "W"):
        assert np.abs(columns[f"cell_{axis}"] / run.size.extents[axis] - 1.0).max() < 0.05
    assert energy_balance_error(run.trace) < 0.01


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("periodic: on", "periodic: off", r":5:6: rig: .* one that holds edges: biaxial-shear drives a periodic cell"),
        ("upper: 20 %", "upper: 95 %", r":19:46: .*upper: found 0.95, allowed a shear strain from -0.9 to 0.9"),
        ("to: -20 %", "to: -7 mm", r"found -0.007 m on axis WC, allowed a displacement from -0.0061"),
        ("to: -20 %", "to: 20 kg", r":18:28: .*ramp.to: found '20 kg', allowed a target"),
        (
            "to: -20 %, rate: 8.34e-3 /s",
            "to: -20 %, rate: 2 N/s",
            r":18:41: .*found 2 N/s, allowed a speed or a strain",
        ),
        ("rig: biaxial-shear", "rig: biaxial-hook", r":18:18: .*axes: found WC, allowed what is driven: C and W"),
        ("rig: biaxial-shear", "rig: triaxial-shear", "one with faces across C, W and P, which triaxial-shear pulls"),
        ("rig: biaxial-shear", "rig: shear-frame", "mount: found nothing, allowed WC: the axis along the frame"),
        ("rig: biaxial-shear", "rig: shear-frame\nmount: W", ":6:8: mount: found W, allowed WC"),
        ("others: hold", "others: follow", ":13:9: others: found follow, allowed hold or free on biaxial-shear"),
        ("friction: 0.3", "shear: free", ":12:10: specimen.shear: found free, allowed held: biaxial-shear drives"),
        ("[WC]", "[CW]", r":18:19: .*found 'CW', allowed C, W or WC \(did you mean WC\?\)"),
    ],
)
def test_a_shear_that_cannot_be_is_one_line_with_its_place(old: str, new: str, said: str) -> None:
    assert old in TEXT
    with pytest.raises(ProtocolError, match=said):
        dry_run(loads(TEXT.replace(old, new), "shear.yaml"))
