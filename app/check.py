"""Say what a protocol would do, without physics: strokes, time, rows, limits passed, yarn to spare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.rig_data import read_biaxial_data
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, Specimen, Stitch, locking_strain, planar_specimen, yarn_per_loop
from rigs.motion import Stroke, gauge_lengths, planned_duration, planned_rows, planned_strokes
from rigs.protocol import AXES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.schemas import Loaded
    from rigs.protocol import Axis, Protocol, SpecimenSpec


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
    locking_strain : float
        Estimated equibiaxial strain at which a loop has used up its yarn [1].
    """

    nodes: int
    yarn_length: float
    clearance: float
    fibre_radius: float
    gauge_lengths: Mapping[Axis, float]
    locking_strain: float


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
        Every move of the stage; a preload is taken to meet its force at once.
    duration : float
        Planned duration [s].
    rows : int
        Rows of the log.
    largest_strain : float
        Largest strain in terms of the yarn budget: the equibiaxial one that needs as much yarn [1].
    warnings : sequence of str
        Limits that would be passed, one line each.
    """

    protocol: Protocol
    specimen: SpecimenFacts
    strokes: Sequence[Stroke]
    duration: float
    rows: int
    largest_strain: float
    warnings: Sequence[str]


def stitch_of(spec: SpecimenSpec) -> Stitch:
    """Return the stitch of a specimen, by name or by value."""
    return NAMED_STITCHES[spec.knit] if isinstance(spec.knit, str) else spec.knit


def build_specimen(loaded: Loaded) -> Specimen:
    """Build the knit of a protocol.

    Raises
    ------
    ProtocolError
        If it cannot exist (strands overlap), with the place of the knit in the file.
    """
    spec = loaded.protocol.specimen
    try:
        return planar_specimen(
            stitch_of(spec),
            rows=spec.rows,
            loops=spec.loops,
            loop_width=spec.loop_width,
            nodes_per_loop=spec.nodes_per_loop,
        )
    except SpecificationError as error:
        raise loaded.locate(error) from error


def describe(specimen: Specimen, stitch: Stitch) -> SpecimenFacts:
    """Return what is known of a planar specimen of a stitch before any physics."""
    return SpecimenFacts(
        nodes=len(specimen.nodes),
        yarn_length=specimen.yarn_length,
        clearance=specimen.clearance,
        fibre_radius=specimen.radius,
        gauge_lengths=gauge_lengths(specimen),
        locking_strain=locking_strain(stitch, yarn_per_loop(stitch)),
    )


def dry_run(loaded: Loaded) -> Plan:
    """Go through a protocol without physics.

    Raises
    ------
    ProtocolError
        If the specimen cannot exist or the log would be too long.
    """
    protocol = loaded.protocol
    facts = describe(build_specimen(loaded), stitch_of(protocol.specimen))
    try:
        planned = planned_strokes(protocol, facts.gauge_lengths)
        rows = planned_rows(protocol, facts.gauge_lengths)
    except SpecificationError as error:
        raise loaded.locate(error) from error
    largest = max(_budget_strain(stroke, facts.gauge_lengths, stitch_of(protocol.specimen)) for stroke in planned)
    return Plan(
        protocol=protocol,
        specimen=facts,
        strokes=planned,
        duration=planned_duration(protocol, facts.gauge_lengths),
        rows=rows,
        largest_strain=largest,
        warnings=[*_budget_warning(largest, facts.locking_strain), *_limit_warnings(protocol, planned)],
    )


def _budget_strain(stroke: Stroke, lengths: Mapping[Axis, float], stitch: Stitch) -> float:
    """Return the equibiaxial strain that needs as much yarn as the end of a stroke [1].

    The locking estimate spends yarn along the course once and along the wale twice the row spacing.
    """
    end = stroke.start if stroke.phase == "Preload" else stroke.end
    course, wale = (end[axis] / lengths[axis] for axis in AXES)
    share = 2.0 * stitch.row_spacing
    return (course + share * wale) / (1.0 + share)


def _budget_warning(largest: float, locking: float) -> list[str]:
    """Return a warning if the yarn would be used up."""
    if largest <= locking:
        return []
    past = f"the protocol goes to {largest:.1%}, past the estimated locking strain of {locking:.1%}"
    return [f"arc-length budget: {past}: the yarn itself must stretch and forces rise steeply"]


def _limit_warnings(protocol: Protocol, planned: Sequence[Stroke]) -> list[str]:
    """Return a warning for each limit of the rig that would be passed."""
    data = read_biaxial_data()
    warnings = []
    travel = data.carriage.travel.value
    for axis in AXES:
        # Rounding must not turn a move to the limit into one past it.
        farthest = max((abs(stroke.end[axis]) for stroke in planned if stroke.phase != "Preload"), default=0.0)
        if farthest > travel * (1.0 + 1e-9):
            warnings.append(f"travel: axis {axis} would go {1e3 * farthest:.4g} mm, limit {1e3 * travel:.4g} mm")
    fastest = max((_speed(stroke) for stroke in planned), default=0.0)
    top = data.carriage.max_speed.value
    if fastest > top * (1.0 + 1e-9):
        warnings.append(f"speed: a pair would move at {1e3 * fastest:.4g} mm/s, limit {1e3 * top:.4g} mm/s")
    if protocol.log.rate > data.clock.max_rate.value:
        warnings.append(f"log: {protocol.log.rate:g} Hz asked for, limit {data.clock.max_rate.value:g} Hz")
    return warnings


def _speed(stroke: Stroke) -> float:
    """Return the speed of the fastest axis [m/s]."""
    if stroke.duration == 0.0:
        return 0.0
    return max(abs(stroke.end[axis] - stroke.start[axis]) for axis in AXES) / stroke.duration
