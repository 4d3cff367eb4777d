"""What the paper's Figs. 4d and 5 claim, on knits as small as still show it; those of the examples when time allows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.results import energy_balance_error
from app.schemas import load
from app.schemas.machine_data import machines_of
from rigs.analysis.stress_strain import stress_strain
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Cycle, Hold, Image, Ramp, Target, UntilRupture, Zero
from rigs.record import Equilibrium, Outcome
from rigs.trace import trace_of

if TYPE_CHECKING:
    from rigs.axes import FloatArray
    from rigs.machines.machine import MachineData
    from rigs.protocol.protocol import Protocol, Repeat, Step
    from rigs.trace import Trace

EXAMPLES = Path(__file__).parents[2] / "examples"
PRE = ("00", "10", "20")


@dataclass
class Drawn:
    """A knit drawn along its pile: strain [1] and stress over Young's modulus [1] of every row of that."""

    outcome: Outcome
    trace: Trace
    strain: FloatArray
    stress: FloatArray

    def loading(self, at: float) -> float:
        """Return the stress on the first way up."""
        top = int(np.argmax(self.strain)) + 1
        return float(np.interp(at, self.strain[:top], self.stress[:top]))

    @property
    def loop_area(self) -> float:
        return float(np.trapezoid(self.stress, self.strain))


def rigid(data: MachineData) -> MachineData:
    """Return the numbers of a machine that gives no way and has no gap to close."""
    stiff = replace(data.carriage.compliance, value=0.0)
    return replace(data, carriage=replace(data.carriage, compliance=stiff, gap=None))


def draw(protocol: Protocol, tag: str = "pile", balance: float = 0.01) -> Drawn:
    """Carry out a protocol on rigid machines: what is looked at here is the knit."""
    machines = {name: rigid(data) for name, data in machines_of(protocol).items()}
    rig, state = mount(make_specimen(protocol.specimen), protocol, machines)
    *events, outcome = perform(rig, state, protocol)
    assert isinstance(outcome, Outcome)
    trace = trace_of([event for event in events if isinstance(event, Equilibrium)])
    assert energy_balance_error(trace) < balance
    rows = [row for row, name in enumerate(trace.tag) if name == tag]
    rows = [max(rows[0] - 1, 0), *rows]
    strain, stress = stress_strain(trace.columns["displacement_P"], trace.columns["force_P"], "P", rig.size)
    modulus = protocol.specimen.solid.young_modulus.value
    return Drawn(outcome, trace, strain[rows], stress[rows] / modulus)


def shortened(protocol: Protocol, to: float, increment: float) -> Protocol:
    """Return a protocol with its last way to a strain, once only, and without pictures."""

    def short(step: Step | Repeat) -> Step | Repeat:
        match step:
            case Cycle():
                return replace(step, upper=to, n=1)
            case Ramp(axes=("P",)):
                return replace(step, to=Target(kind="strain", value=to))
            case _:
                return step

    steps = tuple(short(step) for step in protocol.steps if not isinstance(step, Image | UntilRupture))
    return replace(protocol, steps=steps, max_strain_increment=increment)


@pytest.mark.parametrize("size", [3, 4, 6])
def test_protocols_of_fig_4d_differ_by_their_prestrain_alone(size: int) -> None:
    first, *others = (load(EXAMPLES / "fig4d" / f"fig4d_{pre}_{size}.yaml").protocol for pre in PRE)
    assert [type(step) for step in first.steps] == [Zero, Hold, Cycle]
    for share, other in zip((0.1, 0.2), others, strict=True):
        ramp, rest = other.steps[1], (*other.steps[:1], *other.steps[2:])
        assert isinstance(ramp, Ramp)
        assert (ramp.axes, ramp.to) == (("C", "W"), Target(kind="strain", value=share))
        assert replace(other, name=first.name, steps=rest) == first


def test_prestrain_stiffens_the_pile_of_a_tiny_knit_and_widens_its_loop() -> None:
    found = []
    for pre in (PRE[0], PRE[2]):
        protocol = load(EXAMPLES / "fig4d" / f"fig4d_{pre}_3.yaml").protocol
        tiny = replace(protocol.specimen, rows=2, loops=1, layers=2, nodes_per_loop=24)
        found.append(draw(shortened(replace(protocol, specimen=tiny), 0.3, 0.025)))
    slack, taut = found
    assert slack.outcome == taut.outcome == Outcome(end="target")
    for at in (0.1, 0.2, 0.3):
        assert taut.loading(at) > 1.5 * slack.loading(at) > 0.0
    assert taut.loop_area > 1.5 * slack.loop_area > 0.0


@pytest.mark.slow
def test_fig_4d() -> None:
    found = [draw(load(EXAMPLES / "fig4d" / f"fig4d_{pre}_3.yaml").protocol) for pre in PRE]
    secant = [run.loading(0.4) / 0.4 for run in found]
    area = [run.loop_area for run in found]
    assert secant[2] > secant[1] > secant[0] > 0.0
    assert area[2] > area[1] > area[0] > 0.0


def test_fused_points_make_the_micro_knit_stiffer_until_they_break() -> None:
    protocol = shortened(load(EXAMPLES / "fig5" / "micro_2.yaml").protocol, 0.06, 0.01)
    fused = draw(protocol)
    plain = draw(replace(protocol, specimen=replace(protocol.specimen, fused=None)))
    assert fused.loading(0.01) > 100.0 * plain.loading(0.01) > 0.0
    whole = fused.trace.columns["bonds_whole"]
    assert np.all(np.diff(whole) <= 0.0)
    assert 0.0 < whole[-1] < whole[0]
    assert fused.trace.columns["bond_released"][-1] > 0.0


def test_a_fused_knit_goes_on_after_its_fibre_broke() -> None:
    protocol = shortened(load(EXAMPLES / "fig5" / "micro_2.yaml").protocol, 0.0675, 0.0125)
    law = protocol.specimen.fused
    assert law is not None
    # Necks twice as wide hold until the fibre gives.
    strong = replace(protocol.specimen, fused=replace(law, patch_radius=1.0e-6))
    torn = draw(replace(protocol, specimen=strong), balance=0.02)
    columns = torn.trace.columns
    assert torn.outcome == Outcome(end="target")
    broke = np.flatnonzero(np.diff(columns["fracture_work"]) > 0.0)
    assert len(broke) >= 1
    assert columns["fibre_strain"][: broke[0] + 1].max() == pytest.approx(106.0 / 3000.0, rel=1e-3)
    # A fused point that broke stays broken, also when a fibre does.
    assert np.all(np.diff(columns["bonds_whole"]) <= 0.0)
    # What a break lets go is felt at the plates where they stand.
    assert columns["displacement_P"][broke[0] + 1] == columns["displacement_P"][broke[0]]
    assert 0.0 < columns["force_P"][broke[0] + 1] < 0.95 * columns["force_P"][broke[0]]


@pytest.mark.slow
def test_fig_5() -> None:
    micro, macro = (
        draw(load(EXAMPLES / "fig5" / f"{kind}_2.yaml").protocol, balance=0.05) for kind in ("micro", "macro")
    )
    # Fused points: stiffer at first, all but gone where both knits tear; strength over modulus is the same.
    assert micro.loading(0.02) > 10.0 * macro.loading(0.02)
    peaks = [float(run.stress[run.strain > 0.3].max()) for run in (micro, macro)]
    assert peaks[0] == pytest.approx(peaks[1], rel=0.2)
    for run in (micro, macro):
        assert run.stress[-1] < 0.6 * run.stress.max()
        assert run.trace.columns["fracture_work"][-1] > 0.0
