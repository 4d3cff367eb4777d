"""A waveform on a rig: the axes are on its line at every row, also after a kill in the middle of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from app.schemas.machine_data import machines_of
from rigs.control.checkpoint import Checkpoint, restore
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Waveform
from rigs.record import Equilibrium
from tests.rigs.control.test_resuming import filed, same, without_checkpoints

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

POINTS = ((0.0, 0.0), (10.0, 0.04), (15.0, 0.04), (18.0, 0.06), (40.0, -0.01))


def test_the_displacement_at_every_row_is_on_the_line_and_a_resumed_test_goes_on_along_it(
    mount_knit: Callable[..., Any], tmp_path: Path
) -> None:
    wave = Waveform(axes=("C",), points=POINTS, tag="wave")
    rig, state, protocol = mount_knit(wave, nodes=16)
    events = list(perform(rig, state, protocol))
    rows = [event for event in events if isinstance(event, Equilibrium)]
    times, levels = np.array(POINTS).T
    expected = rig.gauges["C"] * np.interp([row.time for row in rows], times, levels)
    assert [row.displacement["C"] for row in rows] == pytest.approx(expected, abs=1e-12)
    assert rows[-1].time == pytest.approx(40.0)
    assert {float(time) for time in times} <= {round(row.time, 9) for row in rows}
    places = [place for place, event in enumerate(events) if isinstance(event, Checkpoint)]
    middle = places[len(places) // 2]
    checkpoint = events[middle]
    assert isinstance(checkpoint, Checkpoint)
    assert 0 < checkpoint.cursor.stroke < wave.stroke_count
    kept = filed(checkpoint, tmp_path / "checkpoint.h5")
    laid, _ = mount(make_specimen(protocol.specimen), protocol, machines_of(protocol), relaxed=False)
    again = without_checkpoints(list(perform(restore(laid, kept), kept.state, protocol, cursor=kept.cursor)))
    left = without_checkpoints(events[middle + 1 :])
    assert len(again) == len(left)
    assert all(same(one, two) for one, two in zip(again, left, strict=True))
