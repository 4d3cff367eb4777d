"""Strokes that a protocol is planned to make."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigs.control.plan import planned_steps

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.axes import Axis
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.strokes import Stroke


def planned_strokes(protocol: Protocol, gauge_lengths: Mapping[Axis, float]) -> list[Stroke]:
    """Return the strokes of all steps; see `planned_steps`."""
    return [stroke for step in planned_steps(protocol, gauge_lengths) for stroke in step.strokes]
