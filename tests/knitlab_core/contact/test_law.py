"""The normal law: exact derivatives, a smooth onset, Hertz in the middle, a barrier at the end; also as printed."""

from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.contact.law import (
    ContactLaw,
    law_as_printed,
    make_law,
    make_yarn_law,
    pair_potential,
    sample_weights,
)
from tests.contact_scenes import POISSON_RATIO, hertz

LAW = make_law(POISSON_RATIO, 0.3)
PRINTED = {
    "far apart": LAW,
    **{f"gap {gap:g} r": law_as_printed(LAW, LAW.distance + gap) for gap in (0.03, 0.0012, 1e-6)},
    "touching": law_as_printed(LAW, LAW.distance),
    "overlapping mesh": law_as_printed(LAW, LAW.distance - 0.1),
}
each_law = pytest.mark.parametrize("law", PRINTED.values(), ids=PRINTED)


def overlaps(law: ContactLaw) -> list[float]:
    """Return overlaps on both sides of where the law's parts meet, none nearer to it than differences reach."""
    g, s = law.onset, law.rounding
    return [0.1 * s - 0.9 * g, 0.5 * s - 0.2 * g, 0.8 * s, 1.5 * s, 0.1, 0.3, 0.7, 0.95]


@each_law
@pytest.mark.parametrize("place", range(8))
@pytest.mark.parametrize("order", [0, 1])
def test_derivatives_against_differences_over_decades(law: ContactLaw, place: int, order: int) -> None:
    overlap = overlaps(law)[place]
    slope = pair_potential(overlap, law)[order + 1]
    errors = []
    for step in np.logspace(-3.5, -6.5, 7):
        ahead, behind = (pair_potential(overlap + s, law)[order] for s in (step, -step))
        errors.append(abs((ahead - behind) / (2.0 * step) / slope - 1.0))
    assert min(errors) < 1e-7
    # Central differences gain two decades a decade of step until rounding takes over.
    assert errors[2] < 0.02 * errors[0] or errors[2] < 1e-7


@each_law
def test_value_and_slope_are_continuous_where_hertz_begins(law: ContactLaw) -> None:
    below, above = (pair_potential(law.rounding * (1.0 + s), law) for s in (-1e-9, 1e-9))
    assert below[0] == pytest.approx(above[0], rel=1e-7)
    assert below[1] == pytest.approx(above[1], rel=1e-7)


@each_law
def test_onset_begins_with_zero_value_slope_and_curvature(law: ContactLaw) -> None:
    potential, force, stiffness = pair_potential(-law.onset + 1e-8, law)
    assert 0.0 < potential < 1e-20
    assert 0.0 < force < 1e-12
    assert 0.0 < stiffness < 1e-3


@each_law
def test_force_and_stiffness_are_positive_and_force_grows_without_bound(law: ContactLaw) -> None:
    along = np.linspace(-law.onset, law.overlap_limit, 4001)[1:-1]
    potential, force, stiffness = np.transpose([pair_potential(p, law) for p in along])
    assert (potential > 0.0).all()
    assert (stiffness > 0.0).all()
    assert (np.diff(force) > 0.0).all()
    assert pair_potential(law.overlap_limit * (1.0 - 1e-9), law)[0] > 1e6


@each_law
def test_however_narrow_the_onset_stiffness_grows_by_little(law: ContactLaw) -> None:
    def largest(of: ContactLaw) -> float:
        return max(pair_potential(p, of)[2] for p in np.linspace(-of.onset, of.rounding, 1001)[1:-1])

    assert largest(law) < 2.2 * largest(LAW)


@each_law
def test_from_the_rounding_on_every_law_is_hertz_s(law: ContactLaw) -> None:
    for overlap in (1.01 * law.rounding, 0.1, 0.3):
        expected = LAW.coefficient * overlap**1.5 / (1.0 - overlap / law.distance) / (1.0 - overlap**4)
        assert pair_potential(overlap, law)[0] == pytest.approx(expected, rel=1e-14)


def test_strands_printed_beyond_the_onset_keep_the_law_itself() -> None:
    assert law_as_printed(LAW, LAW.reach) is LAW
    assert law_as_printed(LAW, np.inf) is LAW


@pytest.mark.parametrize("least", [2.03, 2.0 + 1e-9, 2.0, 1.9])
def test_as_printed_reaches_as_far_as_the_nearest_strands_and_no_farther(least: float) -> None:
    law = law_as_printed(LAW, least)
    assert law.reach == least
    assert law.onset == pytest.approx(max(least - 2.0, 0.0), abs=1e-15)
    assert law.distance == min(least, 2.0)


@pytest.mark.parametrize("share", [0.02, 0.04, 0.08])
def test_crossed_cylinders_collapse_to_hertz(share: float) -> None:
    # F = 2 pi (D - delta) psi(delta); the barrier adds (delta / p_max)^4.
    delta = share * LAW.distance
    force = 2.0 * np.pi * (LAW.distance - delta) * pair_potential(delta, LAW)[0]
    assert force == pytest.approx(hertz(delta), rel=1.1 * (delta / LAW.overlap_limit) ** 4 + 1e-12)


@pytest.mark.parametrize("share", [0.03, 0.08])
def test_collapse_against_the_double_integral(share: float) -> None:
    height = LAW.distance * (1.0 - share)
    s = (np.arange(400) + 0.5) / 400 * 1.2
    distance = np.sqrt(np.add.outer(s**2, s**2) + height**2)
    near = distance[distance < LAW.reach]
    force = sum(pair_potential(LAW.distance - d, LAW)[1] * height / d for d in near)
    expected = 2.0 * np.pi * height * pair_potential(LAW.distance - height, LAW)[0]
    assert 4.0 * (1.2 / 400) ** 2 * force == pytest.approx(expected, rel=1e-3)


def test_law_scales_with_the_effective_modulus() -> None:
    soft, hard = make_law(0.0, 0.0), make_law(0.5, 0.0)
    assert hard.coefficient / soft.coefficient == pytest.approx(1.0 / 0.75)


@pytest.mark.parametrize("m", [1, 2, 9])
def test_weights_reproduce_lines_and_the_span(m: int) -> None:
    w = sample_weights(m)
    assert w.shape == (m, 3)
    assert (w > 0.0).all()
    np.testing.assert_allclose(w.sum(axis=1), 1.0, rtol=1e-15)
    np.testing.assert_allclose(w @ [-1.0, 0.0, 1.0], (np.arange(m) + 0.5) / m - 0.5, atol=1e-15)


YARN = make_yarn_law(0.8, 2.4, 0.44, 0.3)
GROWING = YARN._replace(distance=1.2, reach=1.2, overlap_limit=1.2 - 0.88, coefficient=0.05)
"""The same around the same core, thinner and softer: what a continuation that lets a yarn grow changes."""

each_yarn = pytest.mark.parametrize(
    "law", [YARN, make_yarn_law(0.8, 2.0, 0.1, 0.3), make_yarn_law(0.8, 6.0, 0.9, 0.3), GROWING]
)


@each_yarn
@pytest.mark.parametrize("share", [1e-6, 1e-15])
def test_a_yarn_begins_as_the_power_of_its_exponent(law: ContactLaw, share: float) -> None:
    # The smallest overlap of two samples is the last bit of a distance near 2.
    c, n, w = law.coefficient, law.exponent, law.overlap_limit
    potential, force, stiffness = pair_potential(share * w, law)
    assert potential == pytest.approx(c * share**n, rel=1e-4, abs=0.0)
    assert force == pytest.approx(n * c / w * share ** (n - 1.0), rel=1e-4, abs=0.0)
    assert stiffness == pytest.approx(n * (n - 1.0) * c / w**2 * share ** (n - 2.0), rel=1e-4, abs=0.0)
    assert pair_potential(0.0, law) == (0.0, 0.0, 0.0)


@each_yarn
def test_a_yarn_begins_without_force_and_above_an_exponent_of_two_without_stiffness(law: ContactLaw) -> None:
    _, force, stiffness = pair_potential(1e-9 * law.overlap_limit, law)
    _, half_force, half_stiffness = pair_potential(0.5 * law.overlap_limit, law)
    assert force < 1e-8 * half_force
    soft = law.exponent > 2.0
    assert (stiffness < 1e-4 * half_stiffness) == soft


@each_yarn
def test_a_yarn_s_coefficient_is_its_potential_halfway_to_the_core(law: ContactLaw) -> None:
    assert pair_potential(0.5 * law.overlap_limit, law)[0] == pytest.approx(law.coefficient, rel=1e-13)


@each_yarn
@pytest.mark.parametrize("order", [0, 1])
def test_derivatives_of_a_yarn_against_differences(law: ContactLaw, order: int) -> None:
    for share in (0.1, 0.5, 0.9, 0.99):
        p = share * law.overlap_limit
        step = 1e-5 * (law.overlap_limit - p)
        ahead, behind = (pair_potential(p + s, law)[order] for s in (step, -step))
        assert (ahead - behind) / (2.0 * step) == pytest.approx(pair_potential(p, law)[order + 1], rel=1e-6)


@each_yarn
def test_a_yarn_resists_more_and_more_up_to_its_core(law: ContactLaw) -> None:
    along = np.linspace(0.0, law.overlap_limit, 1001)[1:-1]
    _, force, stiffness = np.transpose([pair_potential(p, law) for p in along])
    assert (np.diff(force) > 0.0).all()
    assert (np.diff(stiffness) > 0.0).all()
    near = pair_potential(law.overlap_limit * (1.0 - 1e-6), law)[1]
    assert near > 1e6 * pair_potential(0.5 * law.overlap_limit, law)[1]


def test_a_yarn_s_potential_is_the_closed_form() -> None:
    c, n, w = YARN.coefficient, YARN.exponent, YARN.overlap_limit
    for share in (0.2, 0.6, 0.95):
        expected = c * (share / (1.0 - share)) ** n
        assert pair_potential(share * w, YARN)[0] == pytest.approx(expected, rel=1e-13)


def test_where_a_coarse_mesh_overlaps_yarns_begin_there_and_cores_stay() -> None:
    law = law_as_printed(YARN, 1.9)
    assert law.reach == law.distance == 1.9
    assert law.distance - law.overlap_limit == pytest.approx(2.0 * 0.44, rel=1e-15)
    assert law_as_printed(YARN, 2.0) is YARN
