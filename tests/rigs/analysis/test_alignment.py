from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from knitlab_core.errors import SpecificationError
from rigs.analysis.alignment import Alignment, aligned, onset
from tests.rigs.analysis.measured import GAUGE, SECTION, cycles, measurement

TEST = measurement(*cycles(3))


def test_a_cycle_is_taken_out_with_the_row_it_sets_out_from() -> None:
    for number in (1, 2, 3):
        found = aligned(TEST, Alignment(cycle=number))
        assert found.loading.strain[[0, -1]] == pytest.approx([0.0, 0.4])
        assert found.test.strain[-1] == pytest.approx(0.0, abs=1e-12)
        assert set(found.test.cycle.tolist()) == {number}
    with pytest.raises(SpecificationError, match="1 to 3, the cycles of made"):
        aligned(TEST, Alignment(cycle=4))


@pytest.mark.parametrize("travel", [1.0, -1.0])
@pytest.mark.parametrize("force", [1.0, -1.0])
def test_both_directions_come_out_positive(travel: float, force: float) -> None:
    strain, stress = cycles(1)
    found = aligned(measurement(travel * strain, force * stress), Alignment())
    assert (found.reversed_travel, found.reversed_force) == (travel < 0, force < 0)
    assert found.loading.strain == pytest.approx(strain[:101])
    assert found.loading.stress == pytest.approx(stress[:101])


def test_the_force_counts_from_its_rest() -> None:
    strain, stress = cycles(1)
    strain, stress = np.concatenate([np.zeros(9), strain]), np.concatenate([np.zeros(9), stress])
    off = replace(measurement(strain, stress), force=SECTION * stress + 0.02, stress=stress + 0.02 / SECTION)
    found = aligned(off, Alignment(offset=True))
    assert found.offset == pytest.approx(0.02)
    assert found.loading.force[-1] == pytest.approx(SECTION * 4e4)
    assert found.loading.stress[-1] == pytest.approx(4e4)
    assert aligned(off, Alignment()).offset == 0.0


@settings(deadline=None, max_examples=30)
@given(slack=st.floats(0.001, 0.2))
def test_slack_lengthens_the_gauge(slack: float) -> None:
    # Nothing up to the slack [1], then a spring on the length that is tight.
    strain = np.linspace(0.0, 0.4, 4001)
    tight = (strain - slack) / (1.0 + slack)
    found = aligned(measurement(strain, 1e5 * np.maximum(tight, 0.0)), Alignment(slack=1e-9))
    assert found.slack == pytest.approx(slack * GAUGE, abs=0.02e-3 * GAUGE / 0.05)
    assert found.loading.strain[-1] == pytest.approx(tight[-1], abs=2e-4)


def test_the_onset_is_where_the_force_stays_above() -> None:
    travel, force = np.arange(5.0), np.array([0.0, 3.0, 1.0, 3.0, 5.0])
    assert onset(travel, force, 2.0) == pytest.approx(2.5)
    assert onset(travel, force, 9.0) is None
    assert onset(travel, force + 1.0, 0.5) == 0.0
    with pytest.raises(SpecificationError, match="a force that is reached"):
        aligned(TEST, Alignment(slack=1e3))
