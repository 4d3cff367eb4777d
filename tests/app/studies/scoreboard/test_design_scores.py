"""Scores of rows about designs on records with a known answer: reproduced, and not."""

from __future__ import annotations

import numpy as np
import pytest

from app.studies.scoreboard import designs
from tests.app.studies.scoreboard import made
from tests.app.studies.scoreboard.made import cycles, exponential, record_of

XI = {"d": -3.0, "a": -2.0, "n": 2.0, "r": 4.0, "E": 2.0}
"""Exponents of stress that the paper's ξ stands for."""


def test_exponents_are_found_and_the_papers_signs_are_reproduced() -> None:
    runs = made.designs(XI)
    found = designs.stiffness(runs)
    assert found.verdict == "reproduced"
    assert {name: round(value, 6) for name, value in found.values.items() if name.endswith("C")} == {
        "d C": -3.0,
        "a C": -2.0,
        "n C": 2.0,
        "r C": 4.0,
    }
    wrong = designs.stiffness(made.designs({**XI, "d": 1.0}))
    assert wrong.verdict == "differs"
    assert "d C, d W" in wrong.why


@pytest.mark.parametrize(("exponent", "verdict"), [(0.3, "reproduced"), (-1.2, "differs")])
def test_lengths_that_matter_do_not_drop_out(exponent: float, verdict: str) -> None:
    found = designs.lengths(made.designs({**XI, "l": exponent}))
    assert found.verdict == verdict
    assert found.values["l W"] == pytest.approx(exponent)


def test_xi_collapses_what_follows_it_and_nothing_else() -> None:
    # Along the course ξ has half of the wale's factor, so that course stress is twice the wale's.
    found = designs.master_curve(made.designs(XI, wale=0.5))
    assert found.verdict == "reproduced"
    assert found.values["spread after"] == pytest.approx(0.0, abs=1e-9)
    assert found.values["R2"] == pytest.approx(1.0)
    other = designs.master_curve(made.designs({"E": 1.0, "r": 2.0, "d": 1.0, "a": -1.0, "n": 1.0}, wale=1.5))
    assert other.verdict == "differs"
    assert "without v" in other.why


@pytest.mark.parametrize(("exponent", "verdict"), [(2.0, "reproduced"), (1.0, "differs")])
def test_the_exponent_of_the_modulus_is_found(exponent: float, verdict: str) -> None:
    found = designs.materials(made.designs({**XI, "E": exponent}))
    assert found.verdict == verdict
    assert found.values["C"] == pytest.approx(exponent)


@pytest.mark.parametrize(("times", "verdict"), [(1.0, "reproduced"), (1.9, "reproduced"), (30.0, "differs")])
def test_cotton_is_on_the_curve_within_the_prints_or_a_factor_of_two(times: float, verdict: str) -> None:
    runs = made.designs(XI)
    curves = [cycles(axis, exponential(times * 1e3, 16.5)) for axis in "CW"]
    facts = {**made.BASE, "young_modulus": 1.1e9, "thickness": 1e-3, "locking_strain": 0.6}
    runs["cotton"] = record_of("cotton", curves, facts)
    found = designs.cotton(runs)
    assert found.verdict == verdict
    assert found.values["signed C"] == pytest.approx(np.log(times), abs=1e-6)
