"""Master curves on designs whose law is known."""

from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from rigs.analysis.master_curve import Design, collapse, power_law

STRAIN = np.linspace(0.0, 0.4, 41)


def known(count: int, noise: float = 0.0, seed: int = 0) -> list[Design]:
    """Return designs with stress E r^2 w^-3 exp(10 strain), their strains from a range of their own."""
    rng = np.random.default_rng(seed)
    made = []
    for number in range(count):
        values = {
            "E": rng.uniform(1.0, 3.0),
            "r": rng.uniform(0.5, 1.0),
            "w": rng.uniform(1.0, 2.0),
            "idle": rng.uniform(1, 2),
        }
        level = values["E"] * values["r"] ** 2 * values["w"] ** -3.0 * np.exp(noise * rng.normal())
        made.append(
            Design(name=str(number), axis="C", values=values, strain=STRAIN, stress=level * np.exp(10.0 * STRAIN))
        )
    return made


def test_a_power_law_is_found_and_what_plays_no_part_has_no_exponent() -> None:
    law = power_law(known(12), ("E", "r", "w", "idle"), 0.3)
    assert [one.value for one in law.exponents] == pytest.approx([1.0, 2.0, -3.0, 0.0], abs=1e-9)
    assert law.r_squared == pytest.approx(1.0)
    one = known(12)[3]
    assert law.stress(one.values) == pytest.approx(float(one.stress_at(0.3)))
    assert law.left_out < 1e-9
    assert law.p_value == pytest.approx(1.0 / 2001.0)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    inside = []
    for seed in range(120):
        law = power_law(known(16, noise=0.3, seed=seed), ("E", "r", "w"), 0.3)
        inside += [
            abs(one.value - truth) < one.half_width for one, truth in zip(law.exponents, (1, 2, -3), strict=True)
        ]
    # 360 intervals of 95 %: three standard deviations are 3.5 %.
    assert np.mean(inside) == pytest.approx(0.95, abs=0.035)


def test_designs_without_a_law_explain_no_more_than_permuted_ones() -> None:
    rng = np.random.default_rng(3)
    designs = [
        Design(name=one.name, axis="C", values=one.values, strain=STRAIN, stress=np.exp(rng.normal()) * (1.0 + STRAIN))
        for one in known(20)
    ]
    law = power_law(designs, ("E", "r", "w"), 0.3)
    assert law.p_value > 0.05
    # A fit that means nothing predicts worse than the mean does.
    assert law.left_out > 0.9 * np.std([np.log(one.stress_at(0.3)) for one in designs])


def test_curves_collapse_under_their_own_law_alone() -> None:
    designs = known(10)
    factors = [one.values["w"] ** 3 / (one.values["E"] * one.values["r"] ** 2) for one in designs]
    assert collapse("own", designs, factors).spread < 1e-9
    assert collapse("none", designs, [1.0] * 10).spread > 0.3
    half = collapse("own", designs, factors)
    assert [half.first, half.last] == pytest.approx([0.2, 0.4])
    assert half.curves == 10


def test_strains_are_scaled() -> None:
    designs = [
        Design(name=str(lock), axis="W", values={}, strain=lock * STRAIN, stress=np.exp(10.0 * STRAIN))
        for lock in np.linspace(0.5, 1.5, 9)
    ]
    locks = [float(one.name) for one in designs]
    assert collapse("scaled", designs, [1.0] * 9, locks).spread < 1e-9
    assert collapse("not", designs, [1.0] * 9).spread > 0.1


def test_what_cannot_be_told_is_refused() -> None:
    designs = known(12)
    with pytest.raises(SpecificationError, match="7 or more"):
        power_law(designs[:6], ("E", "r", "w", "idle"), 0.3)
    with pytest.raises(SpecificationError, match="0 with a stress"):
        power_law(designs, ("E", "r"), 0.9)
    same = [Design(name="1", axis="C", values={"E": 1.0}, strain=STRAIN, stress=1.0 + STRAIN)] * 9
    with pytest.raises(SpecificationError, match="one value in all designs"):
        power_law(same, ("E",), 0.3)
    with pytest.raises(SpecificationError, match="8 or more"):
        collapse("few", designs[:7], [1.0] * 7)
