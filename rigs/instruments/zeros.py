"""Zeros of a test: values counted from the last one, and the lengths by which travel is strain and force stress.

A zero may take the hook-to-hook lengths of its moment as gauge lengths. They are then also the width of the specimen
for the force of an axis across them, so that stress, strain and work per volume refer to one shape of the specimen. An
axis that is not driven has no hooks to measure by, and keeps its printed extent.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce
from operator import mul
from typing import TYPE_CHECKING

import numpy as np

from rigs.axes import FACE
from rigs.instruments.signals import first_zeroed, zero_offset

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rigs.axes import Axis, Direction, FloatArray
    from rigs.protocol.targets import Channel
    from rigs.record import SpecimenSize


@dataclass(frozen=True, slots=True, kw_only=True)
class Zeroing:
    """Time at which the channels of some kinds were set to zero, and the gauge lengths from then on.

    Attributes
    ----------
    time : float
        Time on the rig's clock [s].
    kinds : frozenset of Channel
        Kinds of the channels that were zeroed.
    place : str
        The step's place in the protocol, ``steps[2].zero``.
    travel, force : Mapping
        Displacement of each axis' crosshead since the specimen was mounted [m], and what it carries [N], then.
    gauges : Mapping
        Gauge length of each driven axis from then on [m]; empty where it is that of the printed specimen.
    """

    time: float
    kinds: frozenset[Channel]
    place: str = ""
    travel: Mapping[Axis, float] = field(default_factory=dict)
    force: Mapping[Axis, float] = field(default_factory=dict)
    gauges: Mapping[Axis, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SizeInTime:
    """Lengths that turn travel into strain and force into stress, at some times.

    Attributes
    ----------
    extents : Mapping
        Gauge length along each direction that is driven, printed extent along others [m], (n,).
    """

    extents: Mapping[Direction, FloatArray]

    def gauge(self, axis: Axis) -> FloatArray:
        """Return the length by which the travel of an axis is strain [m], (n,); of a shear that across its face."""
        return self.extents[FACE[axis]]

    def section(self, axis: Axis) -> FloatArray:
        """Return the area of the face that carries the force of an axis [m²], (n,): both extents along it."""
        return reduce(mul, (extent for across, extent in self.extents.items() if across != FACE[axis]))


def size_in_time(time: FloatArray, size: SpecimenSize, zeroings: Iterable[Zeroing]) -> SizeInTime:
    """Return the lengths that hold at some times [s], (n,): as printed until a zeroing takes others."""
    extents = {axis: np.full(len(time), extent) for axis, extent in size.extents.items()}
    for zeroing in zeroings:
        first = first_zeroed(time, zeroing.time)
        for axis, length in zeroing.gauges.items():
            extents[FACE[axis]][first:] = length
    return SizeInTime(extents=extents)


def zeroed(values: FloatArray, time: FloatArray, kind: Channel, zeroings: Iterable[Zeroing]) -> FloatArray:
    """Return displacements [m] or forces [N] at some times [s], (n,), counted from the last zeroing before each."""
    return values - zero_offset(time, values, [zeroing.time for zeroing in zeroings if kind in zeroing.kinds])


def pin_strain(distance: FloatArray, time: FloatArray, zeroings: Iterable[Zeroing]) -> FloatArray:
    """Return the strain between two pins [1], (n,), from their distance [m] at some times [s].

    It counts from the last zero of displacement, before the first from the specimen as mounted.
    """
    begun = zero_offset(time, distance, [zeroing.time for zeroing in zeroings if "displacement" in zeroing.kinds])
    strain: FloatArray = distance / np.where(begun == 0.0, distance[0], begun) - 1.0
    return strain


def gauge_lengths_taken(size: SpecimenSize, zeroings: Sequence[Zeroing]) -> list[Zeroing]:
    """Return the zeroings at which a gauge length changed, in the order of time; none where all are as printed."""
    found, now = [], {axis: size.gauge(axis) for zeroing in zeroings for axis in zeroing.gauges}
    for zeroing in zeroings:
        if any(length != now[axis] for axis, length in zeroing.gauges.items()):
            found.append(zeroing)
        now |= zeroing.gauges
    return found
