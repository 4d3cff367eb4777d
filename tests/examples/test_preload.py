"""The example of a real specimen, fewer loops of it: slack taken up, strain from there on, both zeros known."""

from __future__ import annotations

from dataclasses import replace
from math import prod
from pathlib import Path

import numpy as np
import pytest

from app.records.results import run_figures
from app.schemas import load
from app.schemas.machine_data import machines_of
from rigs.analysis.stress_strain import stress_strain
from rigs.control.experiment import perform
from rigs.instruments.zeros import Zeroing, size_in_time, zeroed
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.record import Equilibrium, Outcome
from rigs.trace import trace_of

EXAMPLE = Path(__file__).parents[2] / "examples" / "preloaded_course.yaml"


def test_a_specimen_on_its_hooks_is_strained_from_where_its_slack_is_taken_up() -> None:
    protocol = load(EXAMPLE).protocol
    spec = replace(protocol.specimen, rows=2, loops=2, nodes_per_loop=16)
    protocol = replace(protocol, specimen=spec, max_strain_increment=0.05)
    rig, state = mount(make_specimen(spec), protocol, machines_of(protocol))
    events = list(perform(rig, state, protocol))
    assert events[-1] == Outcome(end="target")
    zeroings = [event for event in events if isinstance(event, Zeroing)]
    balanced, taken = zeroings
    assert (balanced.kinds, dict(balanced.gauges)) == (frozenset({"force"}), rig.gauges)
    trace = trace_of([event for event in events if isinstance(event, Equilibrium)])
    columns, time = trace.columns, trace.columns["time"]
    (zero,) = np.flatnonzero((time == taken.time) & (np.array(trace.phase) == "Zero"))
    for axis, printed in rig.gauges.items():
        # The load cell decides, so the noise of its mean is on it.
        assert columns[f"force_{axis}"][zero] == pytest.approx(0.02, abs=0.005)
        assert taken.gauges[axis] == pytest.approx(printed + columns[f"displacement_{axis}"][zero])
    # The wale of this stitch is slack as printed, by less than in the example's six rows.
    assert taken.gauges["W"] > 1.02 * rig.gauges["W"]

    size = size_in_time(time, rig.size, zeroings)
    travel, force = (zeroed(columns[f"{kind}_C"], time, kind, zeroings) for kind in ("displacement", "force"))
    strain, stress = stress_strain(travel, force, "C", size)
    assert strain[zero:].max() == pytest.approx(0.4)
    assert strain[-1] == pytest.approx(0.0, abs=1e-12)
    # Stress times strain is work per volume, of the specimen between its hooks at the zero.
    work = columns["external_work"][zero:] - columns["external_work"][zero]
    volume = prod(taken.gauges.values()) * rig.size.extents["P"]
    peak = int(np.argmax(strain[zero:])) + 1
    done = np.trapezoid(stress[zero : zero + peak], strain[zero : zero + peak])
    assert volume * done == pytest.approx(work[:peak].max(), rel=0.03)

    figures = {name: value for name, value, _ in run_figures(trace, rig.size, zeroings, 1.0, protocol=protocol)}
    assert figures["gauge length W, at the zero"] == taken.gauges["W"]
    assert figures["stress at 40%, C, cycle 2"] == pytest.approx(stress[zero:].max(), rel=0.2)
