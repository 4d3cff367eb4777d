"""Strokes of a protocol on a specimen, each asked of its step when it begins."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigs.protocol.catalogue import CATALOGUE
from rigs.protocol.strokes import History, Situation

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.strokes import Readings, Stroke
    from rigs.protocol.unrolled import UnrolledStep


@dataclass(frozen=True, slots=True, kw_only=True)
class Planner:
    """A protocol with the hook-to-hook lengths of its specimen as printed [m]."""

    protocol: Protocol
    gauges: Mapping[Axis, float]

    def begin(self) -> History:
        """Return the history of a test that begins."""
        return History(origin=dict.fromkeys(self.gauges, 0.0), gauges=dict(self.gauges))

    def stroke(self, leaf: UnrolledStep, index: int, history: History, readings: Readings) -> Stroke | None:
        """Return a stroke of a step, None where it moves nothing.

        Parameters
        ----------
        leaf : UnrolledStep
            The step.
        index : int
            Number of the stroke in it, from 0 to `UnrolledStep.strokes`.
        history, readings
            What came before, and what the controller sees now.

        Raises
        ------
        SpecificationError
            If hooks would pass through each other.
        """
        drives, pair = CATALOGUE[self.protocol.rig].drives, self.protocol.speed_ref == "pair"
        situation = Situation(
            printed=self.gauges,
            # Where two grips move apart, a pair's length changes twice as fast as one of them moves.
            gears={axis: 1 if pair else drives[axis].moving for axis in self.gauges},
            others=self.protocol.others,
            history=history,
            readings=readings,
        )
        stroke = leaf.step.stroke(index, situation)
        return None if stroke is None else replace(stroke, step=leaf.number, tag=leaf.step.tag)
