"""Make a run that no solver made: a sinusoidal knit and exponential curves with a loop."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.writer import RunWriter
from app.schemas.machine_data import read_machine
from rigs.instruments.channels import Instrument, measure
from rigs.instruments.zeros import Zeroing
from rigs.machines.machine import instrument_of
from rigs.record import Equilibrium, Frame, Outcome, Phase, SpecimenSize
from rigs.step_record import StepRecord
from rigs.trace import trace_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from rigs.analysis.material_limits import MaterialLimit
    from rigs.axes import Axis, FloatArray

SIZE = SpecimenSize(extents={"C": 45e-3, "W": 40e-3, "P": 1e-3}, fibre_radius=0.4e-3)
BOTH: tuple[Axis, ...] = ("C", "W")
SPEED = 0.2e-3
PROTOCOL = """schema: knitlab/protocol@1
name: synthetic
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [6, 6], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
speed_ref: pair
others: hold
log: {rate: 10 Hz, noise: on, seed: 7}
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C, W], lower: 0, upper: 40 %, rate: 0.2 mm/s, n: 2, tag: equibiaxial}
"""
STROKES: tuple[tuple[int, Phase, float, float], ...] = (
    (1, "Stretch", 0.0, 0.4),
    (1, "Recover", 0.4, 0.0),
    (2, "Stretch", 0.0, 0.4),
    (2, "Recover", 0.4, 0.0),
)


def stress(strain: float, cycle: int, phase: Phase, axis: str) -> float:
    """Return a made-up stress [Pa]: exponential, softer on the way back and after the first cycle."""
    rise = {"C": 90.0, "W": 130.0}[axis] * (np.exp(16.5 * strain) - 1)
    share = 1.0 if phase == "Stretch" else 0.55 + 0.45 * (strain / 0.4) ** 4
    softened = 1.0 if cycle == 1 else 0.8 + 0.2 * (strain / 0.4) ** 4
    return float(rise * share * softened)


def row(time: float, strain: float, cycle: int, phase: Phase) -> Equilibrium:
    """Return one equilibrium of the made-up test."""
    return Equilibrium(
        time=time,
        displacement={axis: strain * SIZE.gauge(axis) for axis in BOTH},
        force={axis: stress(strain, cycle, phase, axis) * SIZE.section(axis) for axis in BOTH},
        lateral_force=0.0,
        elastic_stretch=1e-5 * strain,
        elastic_bend=1e-4 * strain,
        elastic_twist=1e-6,
        contact_energy=1e-6,
        friction_work=1e-6,
        external_work=1e-4 * strain,
        residual=1e-5,
        contacts=400,
        iterations=9,
        factorisations=9,
        seconds=0.05,
        cycle=cycle,
        fibre_strain=0.3 * strain**2,
        phase=phase,
        tag="equibiaxial",
        step=0 if phase == "Zero" else 1,
    )


def rows(steps: int = 20) -> list[Equilibrium]:
    """Return two equibiaxial cycles to 40 %, the axes arriving together."""
    made, time = [row(0.0, 0.0, 1, "Zero")], 0.0
    for cycle, phase, start, end in STROKES:
        duration = abs(end - start) * SIZE.extents["C"] / SPEED
        for k in range(1, steps + 1):
            strain = start + (end - start) * k / steps
            made.append(row(time + duration * k / steps, strain, cycle, phase))
        time += duration
    return made


def knit_nodes(strain: float, loops: int = 6) -> FloatArray:
    """Return stockinette rows joined by turns, stretched affinely [m], shape (N, 3)."""
    a, h, d, w, loop = 1.5, 0.8, 0.25, 0.86, 8e-3
    parts = []
    for k in range(loops):
        t = np.linspace(-np.pi, (2 * loops - 1) * np.pi, 48 * loops)
        line = np.stack([(t + a * np.sin(2 * t)) / (2 * np.pi), h * np.cos(t) + k * w, d * np.cos(2 * t)], axis=1)
        parts.append(line if k % 2 == 0 else line[::-1])
        if k < loops - 1:
            side, end = (1 if k % 2 == 0 else -1), parts[-1][-1]
            phi = np.linspace(-np.pi / 2, np.pi / 2, 14)[1:-1]
            turn = np.stack(
                [end[0] + side * w / 2 * np.cos(phi), end[1] + w / 2 * (1 + np.sin(phi)), d + 0 * phi],
                axis=1,
            )
            parts.append(turn)
    nodes = np.concatenate(parts)
    nodes -= (nodes.max(0) + nodes.min(0)) / 2
    stretched: FloatArray = loop * nodes * np.array([1 + strain, 1 + strain, 1 - 0.5 * strain])
    return stretched


def frame(time: float, strain: float, cycle: int, phase: Phase) -> Frame:
    """Return the made-up shape at a strain."""
    nodes = knit_nodes(strain)
    wave = 0.5 + 0.5 * np.cos(np.arange(len(nodes) - 1) * 2 * np.pi / 24)
    return Frame(
        time=time,
        nodes=nodes,
        axial_strain=0.02 * (strain / 0.4) ** 3 * wave - 1e-3 * strain,
        bending_strain=0.05 * strain * wave,
        contact_force=1e-3 * strain * np.append(wave, 0.0),
        strain=dict.fromkeys(BOTH, strain),
        cycle=cycle,
        phase=phase,
    )


def stage_instrument(rate: float = 10.0) -> Instrument:
    """Return the instrument of the biaxial stage."""
    return instrument_of("biaxial-hook", read_machine("biaxial-hook"), BOTH, rate)


def make_run(
    path: Path,
    made: Sequence[Equilibrium] | None = None,
    *,
    zeroed: float = 0.0,
    sampled: bool = True,
    protocol: str = PROTOCOL,
    limits: Sequence[MaterialLimit] = (),
    gauges: Mapping[Axis, float] | None = None,
) -> RunReader:
    """Write the made-up test, or other rows, to a file and open it.

    All channels were zeroed at a time [s], with other gauge lengths than the printed ones where they are given [m].
    """
    made = rows() if made is None else made
    instrument = stage_instrument()
    with RunWriter(
        make_record(
            path,
            protocol=protocol,
            limits=limits,
            size=SIZE,
            axes=BOTH,
            strands=[len(knit_nodes(0.0))],
            instruments=[instrument],
            provenance={
                "rig": "biaxial-hook",
                "seed": 7,
                "name": "synthetic",
                "started": "2026-03-04T05:06:07+01:00",
                "rig.convention.temperature": 22.0,
                "rig.carriage.compliance": 0.0,
            },
        )
    ) as writer:
        for one in made:
            writer.append(one)
        quarter = 0.4 * SIZE.extents["C"] / SPEED
        for time, strain, phase in ((0.0, 0.0, "Zero"), (0.5, 0.2, "Stretch"), (1.0, 0.4, "Stretch")):
            writer.add_frame(frame(time * quarter, strain, 1, phase))  # type: ignore[arg-type]
        writer.add_step(StepRecord(number=0, place="steps[0].zero", tag=None, start=zeroed, time=zeroed, end="target"))
        then = next((one for one in reversed(made) if one.time <= zeroed), row(0.0, 0.0, 1, "Zero"))
        zero = Zeroing(
            time=zeroed,
            kinds=frozenset({"force", "displacement"}),
            place="steps[0].zero",
            travel=then.crosshead,
            force=then.force,
            gauges={axis: SIZE.gauge(axis) for axis in BOTH} if gauges is None else gauges,
        )
        writer.add_zero(zero)
        if sampled:
            writer.write_samples(measure(instrument, trace_of(made), seed=7, zeroings=[zero]))
            writer.finish(Outcome(end="target"))
    return RunReader(path)
