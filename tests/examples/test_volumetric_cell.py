"""The example of a volumetric cell: pre-strain in the plane stiffens its pile, as it does that of large specimens."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import ProtocolError, load, loads, to_yaml
from app.views.drawing import draw_here
from rigs.analysis.stress_strain import stress_strain
from rigs.axes import DIRECTIONS

if TYPE_CHECKING:
    from app.views.drawing import Draw

EXAMPLE = Path(__file__).parents[2] / "examples" / "volumetric_cell.yaml"
TEXT = EXAMPLE.read_text()
CYCLE = "cycle: {axes: [P], lower: 0, upper: 25 %, rate: 0.2 mm/s, n: 1, tag: pile}"
COARSE = TEXT.replace("loop: 8 mm", "loop: 8 mm\n  nodes_per_loop: 16").replace(
    "others: hold", "others: hold\nmax_strain_increment: 2.5 %"
)
"""The example with a coarse mesh and long steps."""


def to(strain: str, text: str = COARSE) -> str:
    """Return a protocol that ends where the pile is stretched to a strain."""
    assert CYCLE in text
    return text.replace(CYCLE, f"ramp: {{axes: [P], to: {strain}, rate: 0.2 mm/s}}")


def ran(text: str, folder: Path, draw: Draw | None = None) -> RunReader:
    """Run a protocol and return its record."""
    path = folder / "cell.yaml"
    path.write_text(text)
    assert run_protocol(path, folder / "out", draw=draw).outcome == "target"
    return RunReader(folder / "out" / "run.h5")


def pile_at(run: RunReader, strain: float) -> float:
    """Return the stress along the pile at a strain on the way up [Pa]."""
    columns = run.trace.columns
    strains, stress = stress_strain(columns["displacement_P"], columns["force_P"], "P", run.size)
    up = slice(int(np.argmax(strains)) + 1)
    return float(np.interp(strain, strains[up], stress[up]))


@pytest.fixture(scope="module", name="held")
def _held(tmp_path_factory: pytest.TempPathFactory) -> RunReader:
    folder = tmp_path_factory.mktemp("held")
    run = ran(to("12 %"), folder, draw_here)
    assert (folder / "out" / "volumetric_cell_knit.png").stat().st_size > 10_000
    return run


def test_the_record_has_the_cell_along_all_three_axes(held: RunReader) -> None:
    columns, extents = held.trace.columns, held.size.extents
    assert extents == pytest.approx({"C": 0.016, "W": 1.1 * 0.008, "P": 2 * 1.25 * 0.008})
    for axis in DIRECTIONS:
        driven = extents[axis] + columns[f"displacement_{axis}"]
        np.testing.assert_allclose(columns[f"cell_{axis}"], driven)
    assert {name for name in columns if name.startswith("cell_")} == {"cell_C", "cell_W", "cell_P"}
    assert energy_balance_error(held.trace) < 0.01
    # The pile takes yarn from course and wale, whose sides are held.
    peak, before = int(np.argmax(columns["force_P"])), int(np.argmax(columns["displacement_C"]))
    assert columns["force_W"][peak] > 2.0 * columns["force_W"][before] > 0.0


@pytest.mark.slow
def test_pre_strain_in_the_plane_stiffens_the_pile(tmp_path: Path) -> None:
    runs = []
    for strain in ("10 %", "0.1 %"):
        folder = tmp_path / strain
        folder.mkdir()
        runs.append(ran(to("20 %").replace("to: 10 %", f"to: {strain}"), folder))
    strained, plain = runs
    assert pile_at(strained, 0.2) > 1.5 * pile_at(plain, 0.2) > 0.0


@pytest.mark.slow
def test_a_cell_that_is_free_to_shear_leans_and_is_no_stiffer(tmp_path: Path) -> None:
    """Pile loops stand out to one side of their row, so that a pile in tension leans along the wale."""
    sides_free = (
        to("35 %").replace("rig: triaxial", "rig: uniaxial-frame\nmount: P").replace("others: hold", "others: free")
    )
    text = "\n".join(line for line in sides_free.splitlines() if "pre-strain}" not in line)
    runs = []
    for shear in ("held", "free"):
        folder = tmp_path / shear
        folder.mkdir()
        runs.append(ran(text.replace("shear: held", f"shear: {shear}"), folder))
    upright, leaning = runs
    columns = leaning.trace.columns
    peak = int(np.argmax(columns["displacement_P"]))
    assert columns["cell_PW"][peak] / columns["cell_P"][peak] < -0.01
    assert abs(columns["cell_PC"][peak] / columns["cell_P"][peak]) < 1e-3
    assert pile_at(leaning, 0.35) < 1.005 * pile_at(upright, 0.35)
    assert energy_balance_error(leaning.trace) < 0.01


def test_shear_is_written_and_read_again() -> None:
    free = load(EXAMPLE).protocol.specimen
    assert free.shear == "held"
    text = to_yaml(loads(TEXT.replace("shear: held", "shear: free"), "cell.yaml").protocol)
    assert "shear: free" in text
    assert loads(text, "cell.yaml").protocol.specimen.shear == "free"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[1, 1, 2]", "[1, 1, 3]", "an even number: layers lean along the wale and against it in turn"),
        ("periodic: on", "periodic: off", "held: only a periodic cell is sheared"),
        (
            "rig: triaxial",
            "rig: sem-microgripper",
            "one without plates, into which sem-microgripper takes the faces of a knit",
        ),
    ],
)
def test_what_a_volumetric_cell_cannot_be_is_refused(old: str, new: str, said: str) -> None:
    text = TEXT.replace(old, new)
    if "periodic: off" in new:
        text = text.replace("shear: held", "shear: free")
    if "sem" in new:
        text = text.replace("[C, W]", "[P]").replace("others: hold", "others: free")
    with pytest.raises(ProtocolError, match=said):
        loads(text, "cell.yaml")
