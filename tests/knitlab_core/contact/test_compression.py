"""Yarn between plates: Abel's integral and its inverse, and the law that is fitted to a test."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import beta

from knitlab_core.contact.compression import Compression, fit_compression, parallel_force
from knitlab_core.contact.law import make_yarn_law, pair_potential
from knitlab_core.errors import SpecificationError
from knitlab_core.units import Scales

ACRYLIC = Compression(radius=0.74e-3, core=0.325e-3, exponent=2.4, rigidity=4.8)


@pytest.mark.parametrize(("exponent", "core"), [(2.0, 0.1), (2.4, 0.44), (6.0, 0.9)])
@pytest.mark.parametrize("depth", [1e-4, 0.01, 0.5, 0.99])
def test_force_between_parallel_strands_is_abel_s_integral(exponent: float, core: float, depth: float) -> None:
    law = make_yarn_law(1.0, exponent, core, 0.0)
    height = 2.0 - depth * law.overlap_limit

    def push(t: float) -> float:
        d = float(np.hypot(height, t))
        return pair_potential(2.0 - d, law)[1] * height / d

    half = float(np.sqrt(4.0 - height**2)) * (1.0 - 1e-12)
    near = float(np.sqrt(2.0 * height * (height - 2.0 * core)))
    expected = 2.0 * quad(push, 0.0, half, epsrel=1e-10, limit=400, points=[min(near, 0.5 * half)])[0]
    assert parallel_force(height, law) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("depth", [1e-12, 1e-6])
@pytest.mark.parametrize("exponent", [2.0, 2.05, 2.4, 6.0])
def test_force_between_parallel_strands_that_begin_to_touch(exponent: float, depth: float) -> None:
    # psi = (p / w)^n: Abel's integral is sqrt(2 D) n B(n, 1/2) p^(n - 1/2) / w^n. p is what is left of rounding.
    law = make_yarn_law(1.0, exponent, 0.44, 0.0)
    height, w = 2.0 - depth, law.overlap_limit
    p = 2.0 - height
    expected = 2.0 * exponent * beta(exponent, 0.5) * p ** (exponent - 0.5) / w**exponent
    assert parallel_force(height, law) == pytest.approx(expected, rel=2e-10 + 10.0 * depth, abs=0.0)


def test_its_inverse_is_the_potential() -> None:
    law = make_yarn_law(1.0, 2.4, 0.44, 0.0)
    for height in (1.9, 1.4, 1.0):
        reach = np.sqrt(2.0 - height)

        def back(v: float, h: float = height, s: float = reach) -> float:
            return parallel_force(h + (s * v) ** 2, law) * 2.0 * s / float(np.sqrt(2.0 * h + (s * v) ** 2))

        psi = quad(back, 0.0, 1.0 - 1e-9, epsrel=1e-9)[0] / np.pi
        assert psi == pytest.approx(pair_potential(2.0 - height, law)[0], rel=1e-6)


def test_rigidity_is_the_line_force_halfway_to_the_core() -> None:
    assert ACRYLIC.largest == pytest.approx(0.83e-3)
    assert ACRYLIC.line_force(0.415e-3) == pytest.approx(ACRYLIC.rigidity, rel=1e-12)
    assert pair_potential(0.56, make_yarn_law(3.0, 2.4, 0.44, 0.0))[0] == pytest.approx(3.0, rel=1e-12)
    # At first touch psi = k (c / w)^n: Abel's integral is sqrt(2 D) k n B(n, 1/2) c^(n - 1/2) / w^n.
    small, n, largest = 1e-4 * ACRYLIC.largest, ACRYLIC.exponent, ACRYLIC.largest
    grown = n * beta(n, 0.5) * (small / largest) ** n / np.sqrt(small)
    expected = np.sqrt(4.0 * ACRYLIC.radius) * ACRYLIC.potential * grown
    assert ACRYLIC.line_force(small) == pytest.approx(expected, rel=1e-3)
    expected = 4.0 * np.pi * ACRYLIC.radius * ACRYLIC.potential * (small / largest) ** n
    assert ACRYLIC.crossed_force(small) == pytest.approx(expected, rel=1e-3)


def test_the_solver_s_law_is_the_same_in_its_units() -> None:
    scales = Scales(radius=ACRYLIC.radius, young_modulus=2.0e5)
    law = ACRYLIC.law(scales, 0.3, 0.02)
    height = 2.0 - 0.4e-3 / ACRYLIC.radius
    assert parallel_force(height, law) * scales.force / scales.length == pytest.approx(
        ACRYLIC.line_force(0.4e-3), rel=1e-12
    )


@pytest.mark.parametrize(("exponent", "rigidity"), [(2.05, 0.3), (2.4, 4.8), (4.5, 20.0)])
def test_a_fit_finds_the_law_that_made_the_table(exponent: float, rigidity: float) -> None:
    law = replace(ACRYLIC, exponent=exponent, rigidity=rigidity)
    table = [(0.0, 0.0), *((c, law.line_force(c)) for c in np.linspace(0.05e-3, 0.75e-3, 8))]
    fit = fit_compression(table, radius=law.radius, core=law.core)
    assert fit.compression.exponent == pytest.approx(exponent, rel=1e-5)
    assert fit.compression.rigidity == pytest.approx(rigidity, rel=1e-5)
    assert fit.deviation < 1e-5
    assert fit.points == 8


def test_the_deviation_is_that_of_the_rows_from_the_law() -> None:
    # Rows that are 5 % too high and too low in turns.
    steps = np.linspace(0.05e-3, 0.75e-3, 12)
    table = [(c, ACRYLIC.line_force(c) * np.exp(0.05 * (-1) ** k)) for k, c in enumerate(steps)]
    fit = fit_compression(table, radius=ACRYLIC.radius, core=ACRYLIC.core)
    assert fit.deviation == pytest.approx(0.05, rel=0.05)
    assert fit.compression.exponent == pytest.approx(2.4, rel=0.05)
    residual = [np.log(force / fit.compression.line_force(c)) for c, force in table]
    assert np.sqrt(np.mean(np.square(residual))) == pytest.approx(fit.deviation, rel=1e-4)


@pytest.mark.parametrize(
    ("rows", "field", "says"),
    [
        ([(1e-4, 1.0), (2e-4, 2.0), (3e-4, 3.0)], "table", "3 rows"),
        ([(1e-4, 1.0), (2e-4, 2.0), (2e-4, 3.0), (4e-4, 4.0)], "table[2]", "above 0.2 mm"),
        ([(1e-4, 1.0), (2e-4, 2.0), (3e-4, 1.0), (4e-4, 4.0)], "table[2]", "the force rises"),
        ([(1e-4, 1.0), (2e-4, 2.0), (3e-4, 3.0), (9e-4, 4.0)], "table[3]", "where cores meet"),
        ([(0.0, 0.0), (-1e-4, 1.0), (2e-4, 2.0), (3e-4, 3.0), (4e-4, 4.0)], "table[1]", "above 0 mm"),
        ([(1e-4, 1.0), (2e-4, 2.0), (3e-4, 1e3), (4e-4, 1.1e3)], "table", "that the law follows to 30%"),
    ],
)
def test_tables_of_no_yarn_are_refused(rows: list[tuple[float, float]], field: str, says: str) -> None:
    with pytest.raises(SpecificationError, match=re.escape(says)) as raised:
        fit_compression(rows, radius=ACRYLIC.radius, core=ACRYLIC.core)
    assert raised.value.field == f"yarn.compression.{field}"
