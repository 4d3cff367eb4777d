from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigs.analysis.shapes import legs, middle_width, poisson_ratio, yarn_elongation


@settings(deadline=None, max_examples=30)
@given(ratio=st.floats(-1.0, 1.0))
def test_a_material_of_a_ratio_has_it_at_every_strain(ratio: float) -> None:
    axial = np.linspace(0.0, 0.4, 9)
    found = poisson_ratio(axial, -ratio * axial)
    assert np.isnan(found[0])
    assert found[1:] == pytest.approx(np.full(8, ratio))


def test_the_waist_is_the_width() -> None:
    t = np.linspace(-1.0, 1.0, 401)
    edge = 5.0 + 2.0 * t**2
    nodes = np.concatenate([np.stack([t * 10.0, side * edge, 0 * t], axis=1) for side in (-1.0, 1.0)])
    # A fifth of the length reaches to t = 0.2, where either edge is out by 0.08.
    assert middle_width(nodes, 0, 1) == pytest.approx(10.16)
    assert middle_width(nodes, 0, 1, share=1.0) == pytest.approx(14.0)


@settings(deadline=None, max_examples=30)
@given(strain=st.floats(-0.2, 0.5))
def test_a_yarn_strained_evenly_is_longer_by_its_strain(strain: float) -> None:
    nodes = np.cumsum(np.random.default_rng(1).uniform(0.1, 1.0, (20, 3)), axis=0)
    assert yarn_elongation(nodes, np.full(18, strain), [8, 12]) == pytest.approx(strain)


def test_strains_weigh_by_length_and_broken_edges_do_not_count() -> None:
    nodes = np.array([[0.0, 0.0, 0.0], [1.1, 0.0, 0.0], [4.1, 0.0, 0.0], [9.0, 0.0, 0.0]])
    # 1 m by 10 %, 3 m by none, and a break.
    assert yarn_elongation(nodes, np.array([0.1, 0.0, np.nan]), [4]) == pytest.approx(0.1 / 4.0)


def stitch(curvature: float, height: float = 0.8, loops: int = 4) -> np.ndarray:
    t = np.linspace(-np.pi, (2 * loops - 1) * np.pi, 400 * loops + 1)
    x = (t + curvature * np.sin(2 * t)) / (2 * np.pi)
    return np.stack([x, height * np.cos(t), 0.25 * np.cos(2 * t)], axis=1)


@pytest.mark.parametrize("curvature", [0.0, 0.5, 1.5])
@pytest.mark.parametrize("way", [1, -1])
def test_legs_of_the_papers_stitch_lean_as_its_formula_says(curvature: float, way: int) -> None:
    # From t = -2π/3 to -π/3 the leg rises by the height and goes back by (2 a sin(2π/3) - π/3) / 2π.
    lean = (2.0 * curvature * np.sin(2 * np.pi / 3) - np.pi / 3) / (2 * np.pi)
    angle, straight = legs(stitch(curvature)[::way])
    assert len(angle) == 6
    assert angle == pytest.approx(np.full(6, np.arctan2(lean, 0.8)), abs=2e-3)
    assert np.all((straight > 0.8) & (straight <= 1.0))


def test_a_zigzag_has_straight_legs() -> None:
    x = np.arange(9.0)
    nodes = np.stack([x, np.where(x % 2 == 0, 0.0, 2.0), 0 * x], axis=1)
    angle, straight = legs(nodes)
    assert angle == pytest.approx(np.full(6, -np.arctan2(1.0, 2.0)))
    assert straight == pytest.approx(np.ones(6))


def test_a_yarn_without_loops_has_no_legs() -> None:
    angle, straight = legs(np.linspace([0.0, 0.0, 0.0], [1.0, 1.0, 0.0], 20))
    assert len(angle) == len(straight) == 0
