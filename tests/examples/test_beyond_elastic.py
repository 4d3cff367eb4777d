"""Examples of what goes beyond one elastic fibre, each against the same test without it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import from_yaml, load
from app.schemas.machine_data import machines_of
from rigs.analysis.material_limits import unused_yield
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Ramp, Target, Zero
from rigs.record import Equilibrium, Outcome
from rigs.trace import trace_of
from tests.synthetic_run import BOTH

if TYPE_CHECKING:
    from rigs.axes import Axis, FloatArray
    from rigs.protocol.protocol import Protocol
    from rigs.trace import Trace

EXAMPLES = Path(__file__).parents[2] / "examples"


@dataclass
class Done:
    """A protocol that was carried out, without files."""

    outcome: Outcome
    trace: Trace
    gauges: dict[Axis, float]

    def strain(self, axis: Axis) -> FloatArray:
        return self.trace.columns[f"displacement_{axis}"] / self.gauges[axis]

    def force(self, axis: Axis, at: float) -> float:
        """Return the force at a strain on loading [N]."""
        top = int(np.argmax(self.strain(axis))) + 1
        return float(np.interp(at, self.strain(axis)[:top], self.trace.columns[f"force_{axis}"][:top]))


def carry_out(
    protocol: Protocol,
    balance: float = 0.01,
    **specimen: Any,  # noqa: ANN401 (whatever a specimen is made of)
) -> Done:
    protocol = replace(protocol, specimen=replace(protocol.specimen, **specimen))
    rig, state = mount(make_specimen(protocol.specimen), protocol, machines_of(protocol))
    *events, outcome = perform(rig, state, protocol)
    assert isinstance(outcome, Outcome)
    trace = trace_of([event for event in events if isinstance(event, Equilibrium)])
    assert energy_balance_error(trace) < balance
    return Done(outcome, trace, rig.gauges)


def example(name: str) -> Protocol:
    return load(EXAMPLES / f"{name}_small.yaml").protocol


def to(strain: float) -> Ramp:
    return Ramp(axes=BOTH, to=Target(kind="strain", value=strain), rate=2e-4)


def test_a_resin_that_creeps_lets_the_force_fall() -> None:
    ran, elastic = carry_out(example("creeping")), carry_out(example("creeping"), viscoelastic=False)
    held = np.flatnonzero(np.array(ran.trace.phase) == "Hold")
    assert len(held) > 5
    columns = ran.trace.columns
    for axis in BOTH:
        force, at_once = columns[f"force_{axis}"][held[0] - 1 : held[-1] + 1], elastic.force(axis, 0.2)
        assert np.all(np.diff(force) < 0.0)
        # A quarter of the stiffness relaxes in the end, some of it before the hold.
        assert 0.75 * at_once <= force[-1] < 0.95 * force[0] < at_once
    # An elastic yarn stands still in one row.
    assert elastic.trace.phase.count("Hold") == 1
    assert columns["viscous_work"][-1] > 0.0
    assert np.all(np.diff(columns["viscous_work"]) >= 0.0)
    assert np.all(elastic.trace.columns["viscous_work"] == 0.0)


def test_a_resin_that_yields_is_stiffer_on_the_first_way_and_stays_longer() -> None:
    ran = carry_out(example("yielding"), nodes_per_loop=32)
    columns = ran.trace.columns
    for axis in BOTH:
        strain, force = ran.strain(axis), columns[f"force_{axis}"]
        loading = [
            [row for row, phase in enumerate(ran.trace.phase) if phase == "Stretch" and columns["cycle"][row] == cycle]
            for cycle in (1, 2, 3)
        ]
        work = [float(np.trapezoid(force[rows], strain[rows])) for rows in loading]
        # Clearly less work on the second way up, and nearly the same on the third.
        assert work[0] > 1.2 * work[1] > 0.0
        assert work[1] == pytest.approx(work[2], rel=0.1)
    assert columns["plastic_work"][-1] > 0.05 * columns["external_work"].max()
    assert np.all(np.diff(columns["plastic_work"]) >= 0.0)
    elastic = carry_out(example("yielding"), nodes_per_loop=32, yields=False, viscoelastic=False)
    assert np.all(elastic.trace.columns["plastic_work"] == 0.0)


def test_a_resin_strained_below_its_yield_is_elastic_to_the_bit() -> None:
    protocol = replace(example("yielding"), steps=(Zero(), to(0.04)))
    ran, elastic = (carry_out(protocol, nodes_per_loop=32, yields=on) for on in (True, False))
    assert ran.trace.columns["fibre_strain"].max() < 0.01
    for axis in BOTH:
        np.testing.assert_array_equal(ran.trace.columns[f"force_{axis}"], elastic.trace.columns[f"force_{axis}"])
    assert unused_yield(ran.trace, replace(protocol.specimen, yields=True)).startswith("nothing yielded: fibres were")


def test_two_loose_fibres_are_half_as_stiff_as_one_of_their_area() -> None:
    ran, single = carry_out(example("bundle")), carry_out(example("bundle"), yarn=None)
    for axis in BOTH:
        assert ran.force(axis, 0.1) / single.force(axis, 0.1) == pytest.approx(0.5, abs=0.05)


def test_a_fused_knit_is_stiffer_until_its_points_break() -> None:
    ran, free = carry_out(example("fused")), carry_out(example("fused"), fused=None)
    columns = ran.trace.columns
    whole = columns["bonds_whole"]
    assert whole[0] > 0
    assert np.all(np.diff(whole) <= 0)
    assert whole[-1] == 0
    assert ran.force("C", 0.01) > 5.0 * free.force("C", 0.01)
    for axis in BOTH:
        # Friction remembers that the knit came another way.
        assert ran.force(axis, 0.15) == pytest.approx(free.force(axis, 0.15), rel=0.1)
    assert columns["bond_released"][-1] > 0.0
    assert columns["bond_energy"][-1] == 0.0


def test_a_brittle_knit_breaks_where_its_material_says() -> None:
    protocol = example("rupture")
    ran, whole = carry_out(protocol), carry_out(replace(protocol, steps=(to(0.2),)), rupture="off")
    assert ran.outcome.end == "rupture"
    assert "a fibre broke at strain C " in ran.outcome.message
    columns = ran.trace.columns
    assert columns["fibre_strain"][-2] == pytest.approx(0.05, rel=1e-3)
    assert np.all(columns["fibre_strain"][:-2] < 0.05)
    # The last row is that after the break, at its time.
    assert columns["time"][-1] == columns["time"][-2]
    assert columns["fracture_work"][-1] > columns["fracture_work"][-2] == 0.0
    assert all(columns[f"force_{axis}"][-1] < 0.9 * columns[f"force_{axis}"][-2] for axis in "CW")
    # Until then it is as any other.
    assert ran.force("W", 0.2) == pytest.approx(whole.force("W", 0.2), rel=1e-3)


def test_a_test_may_go_on_after_a_rupture() -> None:
    protocol = replace(example("rupture"), steps=(to(0.3),))
    ran, whole = carry_out(protocol, rupture="go on"), carry_out(protocol, rupture="off")
    assert ran.outcome == Outcome(end="target")
    broke = int(np.argmax(ran.trace.columns["fracture_work"] > 0.0))
    force, strain = ran.trace.columns["force_W"], ran.strain("W")
    # At the same place, with less force; and softer from there on.
    assert strain[broke] == strain[broke - 1]
    assert force[broke] < 0.9 * force[broke - 1]
    assert ran.force("W", 0.3) < 0.9 * whole.force("W", 0.3)


@pytest.mark.slow
def test_cotton_loads_its_hooks_before_it_is_pulled() -> None:
    ran = carry_out(example("cotton"), balance=inf)
    printed = carry_out(example("cotton"), rest_shape="as-printed")
    assert ran.outcome == Outcome(end="target")
    columns, plain = ran.trace.columns, printed.trace.columns
    # A straight yarn wants out of its loops: it is strained before the test, a printed one is not.
    assert ran.trace.phase[0] == "Zero"
    assert columns["elastic_bend"][0] > 0.1 * columns["elastic_bend"].max()
    assert abs(columns["force_C"][0]) > 0.1 * np.abs(columns["force_C"]).max()
    assert abs(plain["force_C"][0]) < 1e-6 * np.abs(plain["force_C"]).max()
    # What bent it there is not the test's.
    assert abs(columns["external_work"][0]) + columns["friction_work"][0] < 1e-3 * columns["elastic_bend"][0]
    # Loops at the edge snap to another balance; what they set free then stands in no column. All else balances.
    stored = columns["elastic_stretch"] + columns["elastic_bend"] + columns["elastic_twist"] + columns["contact_energy"]
    lost = np.sort(np.abs(np.diff(columns["external_work"] - stored - columns["friction_work"])))
    assert lost[:-6].sum() < 0.01 * columns["friction_work"][-1]
    assert lost.sum() < 0.05 * stored[0]


def test_a_record_says_what_it_was_made_with(tmp_path: Path) -> None:
    result = run_protocol(EXAMPLES / "rupture_small.yaml", tmp_path / "run", lambda _share, _text: None, draw=None)
    assert result.outcome == "rupture"
    run = RunReader(result.folder / "run.h5")
    facts = run.provenance
    assert facts["rupture"] == "stop: a fibre breaks at a strain of 0.05 (assumed)"
    assert facts["viscoelastic"] == facts["fused_points"] == "off"
    assert str(facts["material.elongation_at_break.source"]).endswith("assumed")
    again = from_yaml(run.protocol, run.materials)
    assert again.specimen == load(EXAMPLES / "rupture_small.yaml").protocol.specimen


PAPER = {
    ("course", 0.0): (15.0, 0.39),
    ("course", 0.4): (166.0, 6.9),
    ("wale", 0.0): (21.0, 0.43),
    ("wale", 0.4): (190.0, 4.6),
}
"""Secants [kPa] and loop areas [kJ/m3] of the paper's planar 6x6, by the axis that is cycled and the other's strain."""


@pytest.mark.slow
@pytest.mark.parametrize(("way", "pre"), PAPER)
def test_paper_fit_has_the_papers_secants_and_is_stiffer_at_first(way: str, pre: float) -> None:
    protocol = load(EXAMPLES / "paper" / f"fig3d_{way}.yaml", {"pre": pre}).one_test().protocol
    ran = carry_out(protocol, nodes_per_loop=32)
    axis: Axis = "C" if way == "course" else "W"
    cycles = [row for row, tag in enumerate(ran.trace.tag) if tag == "orthogonal"]
    numbers = ran.trace.columns["cycle"]
    stress = ran.trace.columns[f"force_{axis}"] / (1e-3 * ran.gauges["W" if axis == "C" else "C"])
    strain, work, loops = ran.strain(axis), [], []
    for cycle in np.unique(numbers[cycles]):
        rows = [row for row in cycles if numbers[row] == cycle]
        rows = [rows[0] - 1, *rows]
        top = int(np.argmax(strain[rows])) + 1
        work.append(float(np.trapezoid(stress[rows[:top]], strain[rows[:top]])))
        loops.append(float(np.trapezoid(stress[rows], strain[rows])))
    secant, loop = PAPER[way, pre]
    first = max(row for row in cycles if numbers[row] == numbers[cycles[0]] and strain[row] > 0.399)
    assert stress[first] / strain[first] == pytest.approx(1e3 * secant, rel=0.2)
    assert work[0] > 1.1 * work[1] > 0.0
    # The loops of the wale are known to be too small (decision 0039).
    assert loops[0] == pytest.approx(1e3 * loop, rel=0.2) if way == "course" else loops[0] < 1e3 * loop
