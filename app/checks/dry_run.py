"""Plan of a protocol, without physics: strokes, time, rows, limits passed, yarn to spare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.checks.budget import budget_of, budget_warnings, fibre_strain, limit_warnings
from app.checks.log_size import row_size
from app.checks.specimen_facts import facts_of
from app.schemas import load
from app.schemas.machine_data import machines_of
from knitlab_core.errors import SpecificationError
from rigs.control.log_rate import require_rates
from rigs.control.plan import planned_duration, planned_images, planned_rows, planned_steps
from rigs.machines.pins import pins_on
from rigs.machines.wires import require_room
from rigs.protocol.made_specimen import make_specimen

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.checks.budget import Budget
    from app.checks.specimen_facts import SpecimenFacts
    from app.schemas import Loaded, Source
    from knitlab_core.knits import Specimen
    from rigs.axes import Axis
    from rigs.control.plan import Planned
    from rigs.machines.machine import MachineData
    from rigs.protocol.catalogue import MachineName
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.specimen import SpecimenSpec
    from rigs.protocol.strokes import Stroke


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What a protocol would do.

    Parameters
    ----------
    protocol, specimen : Protocol, SpecimenFacts
        What is tested, and how.
    steps : sequence of Planned
        Every step with its strokes; a preload is taken to meet its force at once.
    duration, size : float
        Planned duration [s], and about how large the files of the log will be [bytes].
    rows, images : int
        Rows of the log, of which there may be more near events, and pictures that are asked for [1].
    budget : Budget or None
        How far the strokes go, and how far the yarn reaches; None for a filament, and where nothing moves.
    fibre_strain : float or None
        Largest strain at the surface of a fibre, an estimate [1]; None where there is none.
    warnings : sequence of str
        Limits that would be passed, one line each.
    defaults : Mapping
        Defaults of fields that the protocol leaves out, by their place in it.
    """

    protocol: Protocol
    specimen: SpecimenFacts
    steps: Sequence[Planned]
    duration: float
    rows: int
    size: float
    images: int
    budget: Budget | None
    fibre_strain: float | None
    warnings: Sequence[str]
    defaults: Mapping[str, str]

    @property
    def strokes(self) -> list[Stroke]:
        """Return every move of the axes."""
        return [stroke for step in self.steps for stroke in step.strokes]


def build_specimen(loaded: Loaded) -> Specimen:
    """Build the knit of a protocol.

    Raises
    ------
    ProtocolError
        If it cannot exist (strands overlap), has no room for its wires, or its stitches are not known where pins are to
        be in them; with the place in the file.
    """
    try:
        specimen = make_specimen(loaded.protocol.specimen)
        if loaded.protocol.hook == "wire":
            require_room(specimen, loaded.protocol.axes)
        pins_on(specimen, loaded.protocol.extensometer)
    except SpecificationError as error:
        raise loaded.locate(error) from error
    return specimen


def fitted_machines(loaded: Loaded) -> dict[MachineName, MachineData]:
    """Return the numbers of the machines of a protocol's rig.

    Raises
    ------
    ProtocolError
        If none of them has its load cell, or one samples slower than it is to log, with the place.
    """
    try:
        machines = machines_of(loaded.protocol)
        require_rates(loaded.protocol, machines)
    except SpecificationError as error:
        raise loaded.locate(error) from error
    return machines


@dataclass(frozen=True, slots=True, kw_only=True)
class LogPlan:
    """How long a test takes on the rig [s], and rows [1] and size [bytes] of its log."""

    duration: float
    rows: int
    size: float


def count_rows(loaded: Loaded) -> int:
    """Return how many rows the log of a protocol will have."""
    return plan_log(loaded).rows


def plan_log(loaded: Loaded) -> LogPlan:
    """Return how long the test of a protocol and its log will be: what a sweep checks of each of its jobs.

    Raises
    ------
    ProtocolError
        As `dry_run`.
    """
    protocol = loaded.one_test().protocol
    try:
        facts = facts_of(protocol)
        lengths = facts.gauges(protocol.axes)
        rows = planned_rows(protocol, lengths)
    except SpecificationError as error:
        raise loaded.locate(error) from error
    fitted_machines(loaded)
    size = rows * row_size([drive.machine for drive in protocol.drives.values()], len(facts.pins))
    return LogPlan(duration=planned_duration(protocol, lengths), rows=rows, size=size)


def dry_run(source: Source) -> Plan:
    """Return the plan of a protocol, without physics.

    Parameters
    ----------
    source : Path, str, Protocol or Loaded
        Path of its file, or the protocol.

    Raises
    ------
    ProtocolError
        If the specimen cannot exist or the log would be too long.
    """
    loaded = load(source).one_test()
    protocol = loaded.protocol
    try:
        facts = facts_of(protocol)
        lengths = facts.gauges(protocol.axes)
        steps = planned_steps(protocol, lengths)
        planned = [stroke for step in steps for stroke in step.strokes]
        rows = planned_rows(protocol, lengths)
    except SpecificationError as error:
        raise loaded.locate(error) from error
    machines, spec = fitted_machines(loaded), protocol.specimen
    budget = budget_of(spec, planned, lengths)
    strain = fibre_strain(spec, planned, lengths)
    return Plan(
        protocol=protocol,
        specimen=facts,
        steps=steps,
        duration=planned_duration(protocol, lengths),
        rows=rows,
        size=rows * row_size([drive.machine for drive in protocol.drives.values()], len(facts.pins)),
        images=planned_images(protocol, lengths),
        budget=budget,
        fibre_strain=strain,
        warnings=[
            *budget_warnings(budget),
            *limit_warnings(spec, strain),
            *_fusing_warning(spec, facts.clearance),
            *passed_limits(protocol, machines, planned),
        ],
        defaults=loaded.defaults,
    )


def _fusing_warning(spec: SpecimenSpec, clearance: float) -> list[str]:
    """Return a warning if no two strands were printed so near that they would fuse."""
    bundle = spec.yarn is not None and spec.yarn.model == "bundle"
    if spec.fused is None or bundle or spec.fused.fuse_gap > clearance:
        return []
    return [
        f"fused points: none below {1e3 * spec.fused.fuse_gap:.4g} mm, the narrowest gap is {1e3 * clearance:.4g} mm"
    ]


def passed_limits(
    protocol: Protocol, machines: Mapping[MachineName, MachineData], planned: Sequence[Stroke]
) -> list[str]:
    """Return a line for each limit of the rig's machines that some strokes would pass."""
    drives = protocol.drives
    warnings = []
    for machine, data in machines.items():
        axes = [axis for axis, drive in drives.items() if drive.machine == machine]
        warnings += _machine_warnings(data, axes, planned)
    return warnings


def _machine_warnings(data: MachineData, axes: Sequence[Axis], planned: Sequence[Stroke]) -> list[str]:
    """Return a warning for each limit of one machine's carriages that would be passed."""
    warnings = []
    travel = data.carriage.travel.value
    for axis in axes:
        # Rounding must not turn a move to the limit into one past it.
        farthest = max((abs(stroke.end[axis]) for stroke in planned if not stroke.searches), default=0.0)
        if farthest > travel * (1.0 + 1e-9):
            warnings.append(f"travel: axis {axis} would go {1e3 * farthest:.4g} mm, limit {1e3 * travel:.4g} mm")
    bears = data.load_cell.limit.value
    if data.carriage.capacity is not None:
        bears = min(bears, data.carriage.capacity.value)
    loads = [
        abs(force)
        for stroke in planned
        for axis in axes
        for force in (*stroke.force.get(axis, ()), *_stop(stroke, axis))
    ]
    if max(loads, default=0.0) > bears:
        warnings.append(f"force: {max(loads):.4g} N asked for, limit {bears:.4g} N")
    speeds = [speed for stroke in planned if (speed := _speed(stroke, axes)) > 0.0]
    fastest, slowest = max(speeds, default=0.0), min(speeds, default=float("inf"))
    top, least = data.carriage.max_speed.value, data.carriage.min_speed
    if fastest > top * (1.0 + 1e-9):
        warnings.append(f"speed: a pair would move at {1e3 * fastest:.4g} mm/s, limit {1e3 * top:.4g} mm/s")
    if least is not None and slowest < least.value * (1.0 - 1e-9):
        warnings.append(f"speed: a pair would move at {1e3 * slowest:.4g} mm/s, at least {1e3 * least.value:.4g} mm/s")
    return warnings


def _stop(stroke: Stroke, axis: Axis) -> tuple[float, ...]:
    """Return the force at which a preload stops an axis [N]."""
    return () if stroke.stop_force is None or axis not in stroke.named else (stroke.stop_force,)


def _speed(stroke: Stroke, axes: Sequence[Axis]) -> float:
    """Return the speed of the fastest of some axes [m/s]."""
    if stroke.duration == 0.0:
        return 0.0
    return max(abs(stroke.end[axis] - stroke.start[axis]) for axis in axes) / stroke.duration
