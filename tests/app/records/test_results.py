from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.records.results import energy_balance_error, run_figures
from app.runs.provenance import provenance
from app.schemas.machine_data import machines_of
from rigs.instruments.zeros import Zeroing, zeroed
from rigs.protocol.protocol import Cycle, Protocol, SpecimenSpec
from rigs.record import Equilibrium, Phase, SpecimenSize
from rigs.trace import trace_of

SIZE = SpecimenSize(extents={"C": 0.04, "W": 0.05, "P": 1e-3}, fibre_radius=4e-4)


def row(time: float, strain: float, force: float, phase: Phase = "Stretch") -> Equilibrium:
    return Equilibrium(
        time=time,
        displacement={"C": strain * SIZE.extents["C"], "W": 0.0},
        force={"C": force, "W": 0.0},
        lateral_force=0.0,
        elastic_stretch=1.0,
        elastic_bend=2.0,
        elastic_twist=3.0,
        contact_energy=4.0,
        friction_work=time,
        external_work=10.0 + 1.01 * time,
        residual=1e-5 * time,
        contacts=0,
        iterations=6,
        factorisations=7,
        seconds=0.5,
        cycle=1,
        phase=phase,
    )


# Straight up to 40 % at 2 N, and back to nothing at once.
TRACE = trace_of(
    [replace(row(0.0, 0.0, 0.0, "Zero"), factorisations=0, iterations=0)]
    + [row(k, 0.1 * k, 0.5 * k) for k in (1, 2, 3, 4)]
    + [row(4 + k, 0.4 - 0.1 * k, 0.0, "Recover") for k in (1, 2, 3, 4)]
)


def test_figures_are_the_formulas() -> None:
    figures = {name: value for name, value, _ in run_figures(TRACE, SIZE, [], 9.0)}
    peak = 2.0 / (SIZE.extents["W"] * 1e-3)
    assert figures["stress at 20%, C, cycle 1"] == pytest.approx(0.5 * peak)
    assert figures["stress at 40%, C, cycle 1"] == pytest.approx(peak)
    assert figures["work of loading, C, cycle 1"] == pytest.approx(0.2 * peak)
    # The first step back is a cubic that levels out at its end: 3/8 of a step by the peak lie below it.
    assert figures["loop area, C, cycle 1"] == pytest.approx((0.2 - 0.1 * 3.0 / 8.0) * peak)
    assert figures["loop area / work of loading, C, cycle 1"] == pytest.approx(0.8125)
    assert figures["iterations per equilibrium"] == 6.0
    assert figures["Newton iterations"] == 48.0
    assert figures["factorisations"] == 56.0
    assert figures["solver time"] == 4.5
    assert figures["wall time"] == 9.0
    assert figures["worst residual"] == pytest.approx(8e-5)


def test_figures_without_a_value_are_left_out() -> None:
    names = [name for name, _, _ in run_figures(TRACE, SIZE, [], 9.0)]
    # The wale was not strained.
    assert "stress at 20%, C, cycle 1" in names
    assert "stress at 20%, W, cycle 1" not in names
    assert all(np.isfinite(value) for _, value, _ in run_figures(TRACE, SIZE, [], 9.0))


def test_a_specimen_that_was_only_mounted_has_no_figures() -> None:
    assert run_figures(trace_of([row(0.0, 0.0, 0.0, "Zero")]), SIZE, [], 1.0) == ()


def test_the_balance_is_measured_by_the_largest_work() -> None:
    assert energy_balance_error(TRACE) == pytest.approx(0.08 / 18.08)


def test_strain_counts_from_the_last_zero() -> None:
    zeroing = Zeroing(time=2.0, kinds=frozenset({"displacement"}))
    columns, time = TRACE.columns, TRACE.columns["time"]
    travel = zeroed(columns["displacement_C"], time, "displacement", [zeroing]) / SIZE.extents["C"]
    assert travel == pytest.approx([0.0, 0.1, 0.0, 0.1, 0.2, 0.1, 0.0, -0.1, -0.2])
    assert zeroed(columns["force_C"], time, "force", [zeroing]) == pytest.approx(columns["force_C"])


@pytest.mark.parametrize(("friction", "assumed"), [(0.3, True), (0.25, False)])
def test_provenance_gives_every_number_a_source(friction: float, assumed: bool) -> None:  # noqa: FBT001 (a table's column)
    spec = SpecimenSpec(
        knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM", friction=friction
    )
    cycle = Cycle(axes=("C",), lower=0.0, upper=0.1, rate=2e-4, n=1)
    protocol = Protocol(specimen=spec, speed_ref="pair", others="hold", steps=(cycle,), name="p")
    facts = provenance(protocol, machines_of(protocol))
    assert facts["material.young_modulus"] == 0.82e9
    assert str(facts["material.young_modulus.source"]).startswith("Pa; ")
    assert str(facts["material.poisson_ratio.source"]).endswith("assumed")
    assert str(facts["friction.source"]).endswith("assumed") is assumed
    assert facts["rig.load_cell.limit"] == 100.0
    assert facts["zero_strain"] == "as-printed"
    assert {"name", "rig", "seed", "version.knitlab", "version.numba"} <= set(facts)
    numbers = [name for name, value in facts.items() if isinstance(value, float)]
    assert all(f"{name}.source" in facts for name in numbers)
