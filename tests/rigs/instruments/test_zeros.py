"""Lengths by which travel is strain and force stress, before and after a zero that takes the gauge length."""

from __future__ import annotations

import numpy as np
import pytest

from rigs.analysis.stress_strain import stress_strain
from rigs.instruments.zeros import Zeroing, gauge_lengths_taken, size_in_time
from rigs.record import SpecimenSize

SIZE = SpecimenSize(extents={"C": 0.05, "W": 0.04, "P": 1e-3}, fibre_radius=4e-4)
BOTH = Zeroing(time=2.0, kinds=frozenset({"displacement"}), gauges={"C": 0.055, "W": 0.042})
FORCE = Zeroing(time=3.0, kinds=frozenset({"force"}), gauges=BOTH.gauges)
BACK = Zeroing(time=4.0, kinds=frozenset({"displacement"}), gauges={"C": 0.05, "W": 0.04})


def test_lengths_are_those_of_the_last_zero() -> None:
    # Of the two rows at the zero the last is the zero's own.
    time = np.array([0.0, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0])
    size = size_in_time(time, SIZE, [BOTH, FORCE, BACK])
    assert size.extents["C"] == pytest.approx([0.05, 0.05, 0.05, 0.055, 0.055, 0.05, 0.05])
    assert size.extents["P"] == pytest.approx(1e-3)
    assert gauge_lengths_taken(SIZE, [BOTH, FORCE, BACK]) == [BOTH, BACK]
    assert gauge_lengths_taken(SIZE, [BACK]) == []


def test_stress_refers_to_the_width_at_which_strain_does() -> None:
    time = np.array([0.0, 2.0, 3.0])
    travel, force = np.array([0.0, 0.0, 5.5e-3]), np.array([0.0, 0.1, 0.42])
    size = size_in_time(time, SIZE, [BOTH])
    strain, stress = stress_strain(travel, force, "C", size)
    assert strain == pytest.approx([0.0, 0.0, 0.1])
    assert stress[1:] == pytest.approx([0.1 / 42e-6, 1e4])
    # Work per volume is the work of the force over the volume between the hooks at the zero, whichever axis does it.
    volume = 0.055 * 0.042 * 1e-3
    assert stress[1:].mean() * 0.1 == pytest.approx(force[1:].mean() * 5.5e-3 / volume)
    _, across = stress_strain(travel, force, "W", size)
    assert across[2] == pytest.approx(0.42 / 55e-6)


def test_an_axis_without_hooks_keeps_its_printed_width() -> None:
    course = Zeroing(time=0.0, kinds=frozenset({"displacement"}), gauges={"C": 0.055})
    size = size_in_time(np.array([0.0]), SIZE, [course])
    assert size.section("C") == pytest.approx([SIZE.section("C")])
    assert size.extents["C"] == pytest.approx([0.055])
