from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigs.logs.strokes import counts, rises, segments
from tests.rigs.logs.hand_made import frame

if TYPE_CHECKING:
    from rigs.axes import FloatArray
    from rigs.instruments.samples import Samples
    from rigs.record import Phase

# Phase and samples of it, none for a whole stroke.
STROKE: tuple[tuple[Phase, int], ...] = (("Stretch", 0), ("Hold", 5), ("Recover", 0))


def cyclic(per_stroke: int = 400) -> tuple[list[Phase], FloatArray]:
    phases: list[Phase] = ["Zero"]
    way = [0.0]
    for _ in range(3):
        for phase, count in STROKE:
            phases += [phase] * (count or per_stroke)
        way += list(np.arange(1, per_stroke + 1) / per_stroke) + [1.0] * 5
        way += list(1.0 - np.arange(1, per_stroke + 1) / per_stroke)
    return phases, 9e-3 * np.array(way)


def logged(phases: list[Phase], travel: FloatArray) -> Samples:
    count, made = len(phases), frame()
    zeros = np.zeros(count)
    return replace(
        made,
        time=0.1 * np.arange(float(count)),
        phase=tuple(phases),
        tag=(None,) * count,
        cycle=np.ones(count, dtype=np.int64),
        clean={"Displacement": travel, "Force": zeros},
        measured={"Displacement": travel, "Force": zeros},
        offset={"Displacement": zeros, "Force": zeros},
    )


def test_the_cycle_count_rises_one_per_cent_of_a_stroke_after_the_turnaround() -> None:
    phases, travel = cyclic()
    log = logged(phases, travel)
    at = [first for first, _ in rises(log, "Displacement")]
    total = counts(rises(log, "Displacement"), 0, len(log))
    assert total[0] == 0
    assert total[-1] == 2
    assert (np.flatnonzero(np.diff(total)) + 1).tolist() == at
    assert travel[at] == pytest.approx([0.01 * 9e-3] * 2)
    assert all(phases[k] == "Stretch" for k in at)
    found = np.array(segments(phases))
    assert set(found[np.array(phases) == "Recover"]) == {22412}
    assert set(found[np.array(phases) != "Recover"]) == {22476}
    assert np.flatnonzero(np.diff(found)).tolist() == [405, 805, 1210, 1610, 2015]


def test_a_test_without_a_return_is_one_cycle() -> None:
    log = replace(frame(), phase=("Zero",) + ("Stretch",) * 7)
    assert rises(log, "Displacement") == []
    assert set(segments(log.phase)) == {22476}
