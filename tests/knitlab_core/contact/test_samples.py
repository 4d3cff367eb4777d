"""Samples lie on the quadratic B-spline of the nodes, evenly and span after span."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from tests.contact_scenes import EDGE, sampled, straight, unit_model


def test_samples_lie_on_the_spline() -> None:
    rng = np.random.default_rng(1)
    x = straight((0, 0, 0), (1, 0, 0), 20.0) + rng.normal(0.0, 0.3, (11, 3))
    model, state = unit_model([x])
    m = len(model.samples.weights)
    # Uniform knots: span i is [i - 1/2, i + 1/2] in units of edges.
    spline = BSpline(np.arange(-1.5, 12.0), x, 2)
    for i in model.samples.spans:
        along = i - 0.5 + (np.arange(m) + 0.5) / m
        np.testing.assert_allclose(sampled(model, state.q)[i * m : (i + 1) * m], spline(along), atol=1e-9)


def test_samples_of_a_straight_strand_are_evenly_spaced_but_for_its_end_halves() -> None:
    x = straight((0, 0, 0), (1, 0, 0), 20.0)
    model, state = unit_model([x])
    m = len(model.samples.weights)
    assert m == 9
    points = sampled(model, state.q)[m:-m]
    np.testing.assert_allclose(np.diff(points[:, 0]), EDGE / m, rtol=1e-12)
    assert points[0, 0] - x[0, 0] == pytest.approx(EDGE / 2 + EDGE / m / 2)
    assert (model.samples.length * m).sum() == pytest.approx(20.0 - EDGE)


def test_strands_share_no_span() -> None:
    model, _ = unit_model([straight((0, 0, z), (1, 0, 0), 8.0) for z in (0.0, 3.0)])
    assert model.samples.spans.tolist() == [1, 2, 3, 6, 7, 8]
    assert model.samples.strand.tolist() == [0] * 5 + [1] * 5
