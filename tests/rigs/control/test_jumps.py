"""Fused points that break on a real rig, from the solver to the instrument's log."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
import pytest

from app.schemas import load
from app.schemas.machine_data import machines_of
from rigs.control.experiment import perform
from rigs.instruments.channels import measure
from rigs.jumps import jumped
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Ramp, StrainRate, Target
from rigs.record import Equilibrium, Outcome
from rigs.trace import trace_of

if TYPE_CHECKING:
    from rigs.instruments.channels import Instrument
    from rigs.trace import Trace

FUSED = Path(__file__).parents[3] / "examples" / "fused_small.yaml"


def pull(others: Literal["hold", "free"], strain: float, increment: float = 0.02) -> tuple[Trace, Instrument]:
    """Pull a fused knit along the course; the wale stands, or gives way so that its place is searched for."""
    example = load(FUSED).protocol
    ramp = Ramp(axes=("C",), to=Target(kind="strain", value=strain), rate=StrainRate(value=1e-2))
    test = replace(
        example,
        others=others,
        steps=(ramp,),
        max_strain_increment=increment,
        specimen=replace(example.specimen, nodes_per_loop=16),
    )
    rig, state = mount(make_specimen(test.specimen), test, machines_of(test))
    *events, outcome = perform(rig, state, test)
    assert outcome == Outcome(end="target")
    return trace_of([event for event in events if isinstance(event, Equilibrium)]), rig.instruments[0]


@pytest.mark.parametrize(("others", "strain"), [("hold", 0.06), ("free", 0.04)])
def test_the_peak_before_a_break_reaches_the_log(others: Literal["hold", "free"], strain: float) -> None:
    trace, instrument = pull(others, strain)
    time, force = trace.columns["time"], trace.columns["force_C"]
    after = np.flatnonzero(jumped(trace))
    assert after.size
    first = int(after[0])
    assert trace.columns["bonds_broken"][first - 1] == 0
    if others == "hold":
        # Driven axes stand in the same place before and after each break.
        np.testing.assert_array_equal(time[after], time[after - 1])
    assert force[first] < 0.7 * force[first - 1]
    log = measure(replace(instrument, rate=100.0), trace, seed=0, noise=False)
    shown, at = log.measured["XForce"], int(np.searchsorted(log.time, time[first - 1], side="right")) - 1
    # The sample before the break is within one sample's rise of the peak, the next one has dropped.
    rise = (force[first - 1] - force[first - 2]) / (time[first - 1] - time[first - 2])
    assert shown[at] == pytest.approx(force[first - 1], abs=1.5 * rise / 100.0)
    assert shown[at + 1] < 0.7 * force[first - 1]
    assert np.all(np.diff(shown[: at + 1]) > 0.0)


def test_two_breaks_before_one_row_of_a_search_have_a_peak_each() -> None:
    trace, _ = pull("free", 0.08, increment=0.04)
    columns = trace.columns
    time, force, broken = columns["time"], columns["force_C"], columns["bonds_broken"]
    after = np.flatnonzero(jumped(trace))
    # Asked for every 4 s, rows of this pull held two breaks of one point each between them.
    assert broken[after].tolist() == [1.0, 2.0]
    assert (broken[after] - broken[after - 1]).tolist() == [1.0, 1.0]
    assert np.all(force[after] < 0.7 * force[after - 1])
    # Between them the force rises again, and the free axis carries nothing once it has settled.
    assert force[after[1] - 1] > force[after[0]]
    assert np.abs(columns["force_W"][after]).max() < 1e-3 * force.max()
    # The row after a break comes soon: it is no more than a few steps of the controller late.
    assert np.all(time[after] - time[after - 1] < 0.1 * 4.0)
