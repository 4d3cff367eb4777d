"""Say what a protocol would do, without physics: strokes, time, rows, limits passed, yarn to spare."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from app.rig_data import machines_of
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import Specimen, Stitch, locking_strain, yarn_per_loop
from rigs.catalogue import CATALOGUE, arranged
from rigs.motion import Stroke, planned_duration, planned_rows, planned_strokes
from rigs.specimen import gauge_lengths, make_specimen
from rigs.wires import require_room

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.schemas import Loaded
    from rigs.machine import MachineData
    from rigs.protocol import Protocol
    from rigs.specimen import SpecimenSpec
    from rigs.steps import Axis


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecimenFacts:
    """Hold what is known of a specimen before any physics.

    Parameters
    ----------
    nodes : int
        Nodes of the yarn [1].
    yarn_length, clearance, fibre_radius : float
        Whole length, least surface distance of strands, radius of the fibre [m].
    gauge_lengths : Mapping
        Initial hook-to-hook distance of each axis [m].
    locking_strain : float or None
        Estimated equibiaxial strain at which a loop has used up its yarn [1]; None for a volumetric knit.
    """

    nodes: int
    yarn_length: float
    clearance: float
    fibre_radius: float
    gauge_lengths: Mapping[Axis, float]
    locking_strain: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Hold what a protocol would do.

    Parameters
    ----------
    protocol : Protocol
        The protocol.
    specimen : SpecimenFacts
        The specimen.
    strokes : sequence of Stroke
        Every move of the axes; a preload is taken to meet its force at once.
    duration : float
        Planned duration [s].
    rows : int
        Rows of the log.
    largest_strain : float or None
        Largest strain in terms of the yarn budget: the equibiaxial one that needs as much yarn [1]; None for a
        volumetric knit, and where the sides are free, for they give yarn.
    warnings : sequence of str
        Limits that would be passed, one line each.
    """

    protocol: Protocol
    specimen: SpecimenFacts
    strokes: Sequence[Stroke]
    duration: float
    rows: int
    largest_strain: float | None
    warnings: Sequence[str]


def build_specimen(loaded: Loaded) -> Specimen:
    """Build the knit of a protocol.

    Raises
    ------
    ProtocolError
        If it cannot exist (strands overlap), or has no room for its wires, with the place of the knit in the file.
    """
    try:
        specimen = make_specimen(loaded.protocol.specimen)
        if loaded.protocol.hook == "wire":
            require_room(specimen, loaded.protocol.axes)
    except SpecificationError as error:
        raise loaded.locate(error) from error
    return specimen


def describe(specimen: Specimen) -> SpecimenFacts:
    """Return what is known of a specimen before any physics."""
    stitch, budget = specimen.stitch, None
    if isinstance(stitch, Stitch):
        # Loose fibres make room for each other: what takes yarn at crossings is the yarn as thick as its material.
        yarn = specimen.yarn
        thick = yarn.contact_radius if yarn.fibres == 1 else replace(yarn, model="yarn").contact_radius
        budget = locking_strain(replace(stitch, fibre_radius=thick), yarn_per_loop(stitch))
    return SpecimenFacts(
        nodes=len(specimen.nodes),
        yarn_length=specimen.yarn_length,
        clearance=specimen.clearance,
        fibre_radius=specimen.radius,
        gauge_lengths=gauge_lengths(specimen),
        locking_strain=budget,
    )


def dry_run(loaded: Loaded) -> Plan:
    """Go through a protocol without physics.

    Raises
    ------
    ProtocolError
        If the specimen cannot exist or the log would be too long.
    """
    protocol = loaded.protocol
    facts = describe(build_specimen(loaded))
    lengths = {axis: facts.gauge_lengths[axis] for axis in protocol.axes}
    try:
        planned = planned_strokes(protocol, lengths)
        rows = planned_rows(protocol, lengths)
    except SpecificationError as error:
        raise loaded.locate(error) from error
    stitch, largest = protocol.specimen.stitch, None
    if CATALOGUE[protocol.rig].sides == "hold" and isinstance(stitch, Stitch):
        largest = max(_budget_strain(stroke, lengths, stitch) for stroke in planned)
    return Plan(
        protocol=protocol,
        specimen=facts,
        strokes=planned,
        duration=planned_duration(protocol, lengths),
        rows=rows,
        largest_strain=largest,
        warnings=[
            *_budget_warning(largest, facts.locking_strain),
            *_fusing_warning(protocol.specimen, facts.clearance),
            *_limit_warnings(protocol, planned),
        ],
    )


def _budget_strain(stroke: Stroke, lengths: Mapping[Axis, float], stitch: Stitch) -> float:
    """Return the equibiaxial strain that needs as much yarn as the end of a stroke [1].

    The locking estimate spends yarn along the course once and along the wale twice the row spacing.
    """
    end = stroke.start if stroke.phase == "Preload" else stroke.end
    course, wale = (end[axis] / lengths[axis] for axis in ("C", "W"))
    share = 2.0 * stitch.row_spacing
    return (course + share * wale) / (1.0 + share)


def _budget_warning(largest: float | None, locking: float | None) -> list[str]:
    """Return a warning if the yarn would be used up."""
    if largest is None or locking is None or largest <= locking:
        return []
    past = f"the protocol goes to {largest:.1%}, past the estimated locking strain of {locking:.1%}"
    return [f"arc-length budget: {past}: the yarn itself must stretch and forces rise steeply"]


def _fusing_warning(spec: SpecimenSpec, clearance: float) -> list[str]:
    """Return a warning if no two strands were printed so near that they would fuse."""
    bundle = spec.yarn is not None and spec.yarn.model == "bundle"
    if spec.fused is None or bundle or spec.fused.fuse_gap > clearance:
        return []
    return [
        f"fused points: none below {1e3 * spec.fused.fuse_gap:.4g} mm, the narrowest gap is {1e3 * clearance:.4g} mm"
    ]


def _limit_warnings(protocol: Protocol, planned: Sequence[Stroke]) -> list[str]:
    """Return a warning for each limit of the rig's machines that would be passed."""
    drives = arranged(protocol.rig, protocol.mount)
    warnings = []
    for machine, data in machines_of(protocol).items():
        axes = [axis for axis, drive in drives.items() if drive.machine == machine]
        warnings += _machine_warnings(data, axes, planned)
        if protocol.log.rate > data.clock.max_rate.value:
            warnings.append(f"log: {protocol.log.rate:g} Hz asked for, limit {data.clock.max_rate.value:g} Hz")
    return warnings


def _machine_warnings(data: MachineData, axes: Sequence[Axis], planned: Sequence[Stroke]) -> list[str]:
    """Return a warning for each limit of one machine's carriages that would be passed."""
    warnings = []
    travel = data.carriage.travel.value
    for axis in axes:
        # Rounding must not turn a move to the limit into one past it.
        farthest = max((abs(stroke.end[axis]) for stroke in planned if stroke.phase != "Preload"), default=0.0)
        if farthest > travel * (1.0 + 1e-9):
            warnings.append(f"travel: axis {axis} would go {1e3 * farthest:.4g} mm, limit {1e3 * travel:.4g} mm")
    speeds = [speed for stroke in planned if (speed := _speed(stroke, axes)) > 0.0]
    fastest, slowest = max(speeds, default=0.0), min(speeds, default=float("inf"))
    top, least = data.carriage.max_speed.value, data.carriage.min_speed
    if fastest > top * (1.0 + 1e-9):
        warnings.append(f"speed: a pair would move at {1e3 * fastest:.4g} mm/s, limit {1e3 * top:.4g} mm/s")
    if least is not None and slowest < least.value * (1.0 - 1e-9):
        warnings.append(f"speed: a pair would move at {1e3 * slowest:.4g} mm/s, at least {1e3 * least.value:.4g} mm/s")
    return warnings


def _speed(stroke: Stroke, axes: Sequence[Axis]) -> float:
    """Return the speed of the fastest of some axes [m/s]."""
    if stroke.duration == 0.0:
        return 0.0
    return max(abs(stroke.end[axis] - stroke.start[axis]) for axis in axes) / stroke.duration
