"""The example of a periodic cell: what it carries, that its work is kept, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import ProtocolError, load, loads
from app.views.drawing import draw_here
from rigs.analysis.stress_strain import stress_strain
from rigs.protocol.made_specimen import make_specimen
from tests.synthetic_run import BOTH

EXAMPLE = Path(__file__).parents[2] / "examples" / "cell.yaml"
TEXT = EXAMPLE.read_text()


def ran(text: str, folder: Path) -> RunReader:
    """Run a protocol, draw its pictures, and return its record."""
    path = folder / "cell.yaml"
    path.write_text(text)
    assert run_protocol(path, folder / "out", draw=draw_here).outcome == "target"
    assert (folder / "out" / "cell_knit.png").stat().st_size > 10_000
    return RunReader(folder / "out" / "run.h5")


def test_a_cell_is_slack_in_the_wale_and_then_stiffer_than_in_the_course(tmp_path: Path) -> None:
    run = ran(TEXT.replace("loop: 8 mm", "loop: 8 mm\n  nodes_per_loop: 16"), tmp_path)
    columns = run.trace.columns
    curves = {
        axis: stress_strain(columns[f"displacement_{axis}"], columns[f"force_{axis}"], axis, run.size) for axis in BOTH
    }
    strain, course = curves["C"]
    _, wale = curves["W"]
    peak = int(np.argmax(strain))
    slack = strain[: peak + 1] < 0.25
    # Loops that do not touch yet cannot hold each other; along the course the yarn itself is bent.
    assert np.abs(wale[: peak + 1][slack]).max() < 1e-4 * wale[peak]
    assert course[: peak + 1][slack][-1] > 0.02 * course[peak]
    assert wale[peak] > 1.2 * course[peak] > 0.0
    # Friction is all that is lost: the loop of both axes together is what it took.
    area = sum(
        np.trapezoid(force, travel)
        for force, travel in ((columns[f"force_{a}"], columns[f"displacement_{a}"]) for a in "CW")
    )
    assert area == pytest.approx(columns["friction_work"][-1], rel=0.1)
    assert energy_balance_error(run.trace) < 0.01
    np.testing.assert_allclose(columns["cell_C"], run.size.extents["C"] + columns["displacement_C"])
    assert run.size.extents["C"] == pytest.approx(0.016)
    assert run.size.extents["W"] == pytest.approx(2 * 0.86 * 0.008)


def test_a_side_that_nothing_drives_is_free(tmp_path: Path) -> None:
    text = TEXT.replace("rig: biaxial-hook", "rig: uniaxial-frame\nmount: C").replace("axes: [C, W]", "axes: [C]")
    text = text.replace("others: hold", "others: free").replace("upper: 40 %", "upper: 70 %")
    run = ran(text.replace("loop: 8 mm", "loop: 8 mm\n  nodes_per_loop: 16"), tmp_path)
    wale = run.trace.columns["cell_W"] / run.size.extents["W"] - 1.0
    peak = int(np.argmax(run.trace.columns["displacement_C"]))
    assert -0.05 < wale[peak] < -0.003


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "knit: stockinette-default\n  loops: [2, 2]",
            "knit: {filament: 1 mm}\n  loops: [1, 1]",
            "not made of rows that",
        ),
        ("friction: 0.3", "hook: wire", "pin: nothing hangs on hooks in a periodic cell"),
        ("friction: 0.3", "pole_friction: 0.1", "none: nothing hangs on hooks in a periodic cell"),
        ("friction: 0.3", "fused: {gap: 1 mm, patch_radius: 0.1 mm, strength: 20 MPa}", "none in a periodic cell"),
        ("friction: 0.3", "rupture: stop", "off in a periodic cell"),
        ("friction: 0.3", "yarn: {fibres: 3, model: bundle, twist: 2}", "one rod for all fibres"),
        ("friction: 0.3", "grips: clamps", "hooks, which need not be said: a periodic cell has no edges"),
        ("friction: 0.3", "rest_shape: straight\n  laid_in: 0.3 mm", "none of a yarn of fibres, a periodic cell"),
        ("steps:", "extensometer: on\nsteps:", "off: the strain of a periodic cell is the fabric's"),
    ],
)
def test_what_only_a_specimen_with_edges_has_is_refused(old: str, new: str, said: str) -> None:
    text = TEXT.replace(old, new)
    with pytest.raises(ProtocolError, match=said):
        loads(text, "cell.yaml")


def test_what_has_no_edges_is_refused_for_that_beside_other_mistakes() -> None:
    wrong = TEXT.replace("friction: 0.3", "rupture: stop\n  grips: clamps").replace(
        "steps:", "extensometer: on\nsteps:"
    )
    with pytest.raises(ProtocolError) as raised:
        loads(wrong, "cell.yaml")
    rupture, grips, extensometer = (str(one) for one in (raised.value, *raised.value.more))
    assert "off in a periodic cell" in rupture
    assert "a periodic cell has no edges" in grips
    assert "the strain of a periodic cell is the fabric's" in extensometer


@pytest.mark.parametrize(
    ("knit", "loops", "said"),
    [
        ("rib-1x1", "[2, 3]", "3 in a row"),
        ("garter", "[3, 2]", "after which"),
        ("seed", "[2, 1]", "1 in a row"),
        ("seed", "[3, 2]", "after which"),
    ],
)
def test_a_cell_holds_whole_repeats(knit: str, loops: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "cell.yaml"
    path.write_text(TEXT.replace("stockinette-default", knit).replace("[2, 2]", loops))
    with pytest.raises(ProtocolError, match=said):
        run_protocol(path, tmp_path / "out")


@pytest.mark.parametrize("knit", ["rib-1x1", "garter", "seed"])
def test_other_stitches_make_cells(knit: str) -> None:

    spec = replace(load(EXAMPLE).protocol.specimen, knit=knit, nodes_per_loop=16)
    specimen = make_specimen(spec)
    assert specimen.cell is not None
    for strand, (along, _) in zip(specimen.strands, specimen.cell.shifts, strict=True):
        np.testing.assert_allclose(
            strand[-2:] - strand[:2], along * specimen.cell.vectors[:1].repeat(2, axis=0), atol=1e-12
        )
