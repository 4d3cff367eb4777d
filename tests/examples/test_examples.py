"""Run every example as a user would, and hold it to what mechanics says."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import RunResult, run_protocol
from app.schemas import from_yaml, to_yaml
from app.studies.scoreboard.plan import FULL, all_tests
from app.views.drawing import draw_here
from rigs.analysis.branches import branch
from rigs.analysis.stress_strain import stress_strain
from rigs.protocol.made_specimen import make_specimen
from tests.synthetic_run import BOTH

if TYPE_CHECKING:
    from rigs.axes import Axis, FloatArray
    from rigs.record import Phase

EXAMPLES = Path(__file__).parents[2] / "examples"


@dataclass
class Ran:
    """An example that ran."""

    result: RunResult
    run: RunReader

    def curve(self, axis: Axis, cycle: int, way: Phase) -> tuple[FloatArray, FloatArray]:
        """Return strain [1] and stress [Pa] of one branch, strain rising."""
        columns = self.run.trace.columns
        travel, force = columns[f"displacement_{axis}"], columns[f"force_{axis}"]
        strain, stress = stress_strain(travel, force, axis, self.run.size)
        rows = branch(self.run.trace.phase, columns["cycle"].astype(np.int64), cycle, [way])
        order = np.argsort(strain[rows])
        return strain[rows][order], stress[rows][order]

    def stress(self, axis: Axis, at: float, *, cycle: int = 1, way: Phase = "Stretch") -> float:
        """Return the stress of a branch at a strain [Pa]."""
        strain, stress = self.curve(axis, cycle, way)
        # A frame gives way by less than half a digit of its encoder.
        assert strain[0] <= at <= strain[-1] + 1e-6
        return float(np.interp(at, strain, stress))

    def loop_area(self, axis: Axis, cycle: int) -> float:
        """Return the work that a cycle keeps [J/m3]."""
        up, down = (self.curve(axis, cycle, way) for way in ("Stretch", "Recover"))
        return float(np.trapezoid(up[1], up[0]) - np.trapezoid(down[1], down[0]))


def run_example(name: str, folder: Path, *, pictures: bool = False) -> Ran:
    folder.mkdir(exist_ok=True)
    draw = draw_here if pictures else None
    result = run_protocol(EXAMPLES / name, folder / "run", lambda _share, _text: None, draw=draw)
    return Ran(result, RunReader(result.folder / "run.h5"))


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return run_example("biaxial_small.yaml", tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="module")
def main_job(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return run_example("biaxial_cycle.yaml", tmp_path_factory.mktemp("main"), pictures=True)


def test_the_small_knit_unloads_below_its_loading(small: Ran) -> None:
    assert small.result.outcome == "target"
    grid = np.linspace(0.02, 0.19, 18)
    drop = {}
    for axis in BOTH:
        up, down = (small.curve(axis, 1, way) for way in ("Stretch", "Recover"))
        drop[axis] = np.interp(grid, *up) - np.interp(grid, *down)
        assert small.loop_area(axis, 1) > 0.0
    slack = 1e-4 * small.stress("W", 0.2)
    assert np.all(drop["W"] >= -slack)
    # Both axes strain alike, so the sum of stresses is what works. The course alone may carry a little more on
    # the way back: friction keeps yarn that the wale gave up.
    assert np.all(drop["C"] + drop["W"] >= -slack)
    assert np.all(drop["C"] >= -0.02 * small.stress("C", 0.2))


def test_the_small_knit_is_stiffer_along_the_wale(small: Ran) -> None:
    assert small.stress("W", 0.2) > 2.0 * small.stress("C", 0.2)


def test_the_small_knit_comes_back_without_stress(small: Ran) -> None:
    for axis in BOTH:
        assert abs(small.stress(axis, 0.0, way="Recover")) < 1e-3 * small.stress(axis, 0.2)


def test_the_main_job_leaves_what_it_promises(main_job: Ran) -> None:
    assert (main_job.result.outcome, main_job.result.message) == ("target", "")
    assert {path.name for path in main_job.result.folder.iterdir()} == {
        "run.h5",
        "biaxial_cycle.csv",
        "biaxial_cycle_stress_strain.png",
        "biaxial_cycle_knit.png",
    }
    names = [name for name, _, _ in main_job.result.figures]
    for axis in BOTH:
        for cycle in (1, 2):
            for level in ("20%", "30%", "40%"):
                assert f"stress at {level}, {axis}, cycle {cycle}" in names
            assert f"loop area, {axis}, cycle {cycle}" in names
    frames = np.array([(frame.strain["C"], frame.strain["W"]) for frame in main_job.run.frames()])
    strains = frames[np.abs(frames[:, 0] / 0.2 - np.round(frames[:, 0] / 0.2)) < 1e-9]
    assert strains == pytest.approx(np.array(2 * [0.0, 0.2, 0.4, 0.2] + [0.0]).repeat(2).reshape(-1, 2))


def test_the_main_job_stiffens_as_loops_lock(main_job: Ran) -> None:
    for axis in BOTH:
        stress = [main_job.stress(axis, at) for at in (0.2, 0.3, 0.4)]
        assert stress[1] > 3.0 * stress[0] > 0.0
        assert stress[2] - stress[1] > 2.0 * (stress[1] - stress[0])


def test_the_wale_is_slack_until_loops_touch_and_stiffer_in_the_end(main_job: Ran) -> None:
    assert abs(main_job.stress("W", 0.1)) < 1e-3 * main_job.stress("W", 0.4)
    assert main_job.stress("W", 0.1) < main_job.stress("C", 0.1)
    assert main_job.stress("W", 0.4) > 1.5 * main_job.stress("C", 0.4)


def test_the_main_job_dissipates_in_every_cycle(main_job: Ran) -> None:
    for axis in BOTH:
        for cycle in (1, 2):
            assert main_job.loop_area(axis, cycle) > 0.0
    assert main_job.loop_area("W", 1) > main_job.loop_area("C", 1)


def test_a_knit_that_went_slack_remembers_no_cycle(main_job: Ran) -> None:
    # Elastic yarn and friction alone: where no loop touches, nothing is left of what was before.
    for axis in BOTH:
        for at in (0.2, 0.3, 0.4):
            first, second = (main_job.stress(axis, at, cycle=cycle) for cycle in (1, 2))
            assert second == pytest.approx(first, rel=0.01)


@pytest.fixture(scope="module")
def uniaxial(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return run_example("uniaxial_course.yaml", tmp_path_factory.mktemp("uniaxial"))


def test_a_knit_with_free_sides_is_far_softer_than_one_held(uniaxial: Ran, main_job: Ran) -> None:
    assert uniaxial.result.outcome == "target"
    assert 0.0 < uniaxial.stress("C", 0.3) < 0.25 * main_job.stress("C", 0.3)
    assert uniaxial.run.trace.axes == ("C",)


def test_a_knit_with_free_sides_gets_narrower(uniaxial: Ran) -> None:
    frames = [frame for frame in uniaxial.run.frames() if round(frame.strain["C"], 5) in {0.0, 0.2, 0.3}]
    # Free loops below and above, and the hooks that slide along their poles.
    sites = make_specimen(from_yaml(uniaxial.run.protocol).specimen).sites
    for width in (
        [frame.nodes[sites["wale+"], 1].mean() - frame.nodes[sites["wale-"], 1].mean() for frame in frames],
        [np.ptp(frame.nodes[sites["course+"], 1]) for frame in frames],
    ):
        start, _, peak, _, end = width
        assert 0.0 < start - peak < 0.1 * start
        assert end == pytest.approx(start, rel=1e-3)


def test_a_knit_with_free_sides_stretches_without_its_yarn(uniaxial: Ran) -> None:
    peak = max(uniaxial.run.frames(), key=lambda frame: frame.strain["C"])
    assert peak.strain["C"] == pytest.approx(0.3, abs=1e-6)
    assert np.abs(peak.axial_strain).max() < 1e-3
    assert energy_balance_error(uniaxial.run.trace) <= 0.01


@pytest.mark.slow
def test_the_pile_is_stiffest(tmp_path: Path) -> None:
    stress = {}
    for axis, name in (("C", "course"), ("W", "wale"), ("P", "pile")):
        ran = run_example(f"fig4c/fig4c_{name}_4.yaml", tmp_path / name)
        assert ran.result.outcome == "target"
        stress[axis] = ran.stress(axis, 0.4)  # type: ignore[arg-type]
    # The paper's Fig. 4c.
    assert stress["P"] > max(stress["C"], stress["W"])


@pytest.fixture(scope="module")
def wire(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return run_example("wire_small.yaml", tmp_path_factory.mktemp("wire"))


def test_a_knit_on_wires_is_softer_than_one_on_pins(wire: Ran, tmp_path: Path) -> None:
    assert wire.result.outcome == "target"
    assert energy_balance_error(wire.run.trace) <= 0.01
    protocol = from_yaml(wire.run.protocol)
    pins = to_yaml(replace(protocol, hook="pin", pole_friction=None, name="pins"))
    (tmp_path / "pins.yaml").write_text(pins, encoding="utf-8")
    result = run_protocol(tmp_path / "pins.yaml", tmp_path / "run", lambda _share, _text: None, draw=None)
    pinned = Ran(result, RunReader(result.folder / "run.h5"))
    # A loop closes between its two hooks, and yarn slips round them.
    for axis in BOTH:
        assert 0.6 * pinned.stress(axis, 0.3) < wire.stress(axis, 0.3) < 0.98 * pinned.stress(axis, 0.3)
    assert pinned.run.trace.columns["lateral_force"].max() == 0.0
    # No hook bears more along its pole than friction allows of all that its axis carries.
    columns = wire.run.trace.columns
    lateral, pull = columns["lateral_force"], np.maximum(np.abs(columns["force_C"]), np.abs(columns["force_W"]))
    taut = pull > 0.1
    assert np.all(lateral[taut] > 0.0)
    assert np.all(lateral[taut] <= 0.05 * pull[taut])


def test_a_frame_keeps_the_wires(wire: Ran) -> None:
    frames = wire.run.frames()
    assert frames[0].wires.shape == (15, 2, 3)
    peak = max(frames, key=lambda frame: frame.strain["W"])
    travel = np.abs(peak.wires - frames[0].wires)[:, 0]
    gauge = wire.run.size.extents
    for axis, coordinate in (("C", 0), ("W", 1)):
        half = 0.5 * 0.3 * gauge[axis]  # type: ignore[index]
        assert np.count_nonzero(np.isclose(travel[:, coordinate], half)) >= 4
    assert travel[:, 2].max() == 0.0


@pytest.mark.parametrize("name", ["small", "main_job"])
def test_work_is_stored_or_dissipated(name: str, request: pytest.FixtureRequest) -> None:
    ran: Ran = request.getfixturevalue(name)
    assert energy_balance_error(ran.run.trace) <= 0.01
    # What friction took is the area of the loops.
    columns, size = ran.run.trace.columns, ran.run.size
    cycles = range(1, int(columns["cycle"].max()) + 1)
    area = sum(ran.loop_area(axis, cycle) for axis in ran.run.trace.axes for cycle in cycles)
    volume = prod(size.extents.values())
    assert columns["friction_work"][-1] == pytest.approx(area * volume, rel=0.02)


def test_every_example_is_tested() -> None:
    knits = {f"fig4c/fig4c_{axis}_{n}.yaml" for axis in ("course", "wale", "pile") for n in (4, 6)}
    tried = {"wire_small.yaml", "biaxial_small.yaml", "biaxial_cycle.yaml", "uniaxial_course.yaml"}
    beyond = {f"{what}_small.yaml" for what in ("bundle", "cotton", "creeping", "fused", "rupture", "yielding")}
    knits |= {f"fig4d/fig4d_{pre}_{n}.yaml" for pre in ("00", "10", "20") for n in (3, 4, 6)}
    knits |= {f"fig5/{kind}_{n}.yaml" for kind in ("micro", "macro") for n in (2, 3, 6)}
    swept = {"fig3a/fig3a.yaml", "fig3d/fig3d_course.yaml", "fig3d/fig3d_wale.yaml"}
    scored = {f"paper/{test.protocol}" for test in all_tests(FULL).values()}
    proof = {
        "bound_off_small.yaml",
        "cell.yaml",
        "clamped_small.yaml",
        "design/design_cell.yaml",
        "filament.yaml",
        "preloaded_course.yaml",
        "serpentine_small.yaml",
        "shear_cell.yaml",
        "volumetric_cell.yaml",
        "yarn_small.yaml",
    }
    fabrics = (
        "acrylic_course",
        "acrylic_shear",
        "acrylic_wale",
        "garter_wale",
        "rib_course",
        "stockinette_course",
        "stockinette_wale",
    )
    proof |= {f"fabric/{name}.yaml" for name in (*fabrics, "clamped_course", "clamped_wale", "held_wale")}
    protocols = {path for path in EXAMPLES.rglob("*.yaml") if "knitlab/protocol@1" in path.read_text(encoding="utf-8")}
    assert {str(path.relative_to(EXAMPLES)) for path in protocols} == tried | knits | beyond | swept | scored | proof
