from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigs.analysis.choices import Choices
from rigs.analysis.curve_tables import curves_table, fits_table, holds_table, poisson_table, repeatability_table
from rigs.analysis.figures import results_table
from tests.rigs.analysis.measured import GAUGE, SECTION, cycles, measurement

if TYPE_CHECKING:
    from rigs.analysis.table import Table

Key = tuple[str, int, str]


def values(table: Table) -> dict[Key, float]:
    return {(str(row[1]), int(row[2]), str(row[3])): float(row[4]) for row in table.rows()}


def test_results_of_known_loops_on_two_axes() -> None:
    strain, stress = cycles(2)
    tests = [measurement(strain, stress), measurement(strain, 2.0 * stress, axis="W")]
    found = values(results_table(tests, tests, Choices(windows=((0.1, 0.3),))))
    area, work = 1e5 * 0.16 / 6.0, 1e5 * 0.16 / 2.0
    assert found["C", 0, "Maximum force"] == pytest.approx(4e4 * SECTION)
    assert found["C", 0, "Extension at maximum force"] == pytest.approx(0.4 * GAUGE)
    assert found["C", 0, "Energy at maximum force"] == pytest.approx(work * SECTION * GAUGE)
    assert ("C", 0, "Force at break") not in found
    for cycle in (1, 2):
        assert found["C", cycle, "Modulus (secant 10 % - 30 %)"] == pytest.approx(1e5)
        assert found["C", cycle, "Modulus (segment 10 % - 30 %)"] == pytest.approx(1e5)
        assert found["C", cycle, "Tensile stress at tensile strain 20%"] == pytest.approx(2e4)
        assert found["C", cycle, "Hysteresis energy density"] == pytest.approx(area, rel=1e-3)
        assert found["all", cycle, "Hysteresis energy density"] == pytest.approx(3.0 * area, rel=1e-3)
        assert found["all", cycle, "Hysteresis ratio"] == pytest.approx(1.0 / 3.0, rel=1e-3)
        assert found["C", cycle, "Energy of loading over that of the first cycle"] == pytest.approx(1.0)


def test_values_at_break_are_those_before_the_fall() -> None:
    strain = np.linspace(0.0, 0.3, 61)
    stress = np.where(strain < 0.251, 1e5 * strain, 1e3)
    tests = [measurement(strain, stress)]
    found = values(results_table(tests, tests, Choices()))
    assert found["C", 0, "Tensile strain at break"] == pytest.approx(0.25)
    assert found["C", 0, "Tensile stress at break"] == found["C", 0, "Tensile stress at maximum force"]


def test_a_force_without_a_section_has_its_figures_too() -> None:
    strain, stress = cycles(1)
    unknown = np.full(len(strain), np.nan)
    tests = [replace(measurement(strain, stress), strain=unknown, stress=unknown)]
    found = values(results_table(tests, tests, Choices()))
    assert found["C", 0, "Maximum force"] == pytest.approx(4e4 * SECTION)
    assert not any(cycle for _, cycle, _ in found)


def test_tables_of_curves() -> None:
    strain, stress = cycles(3)
    tests = [measurement(strain, stress)]
    assert len(curves_table(tests)) == len(strain)
    alike = repeatability_table(tests)
    assert list(alike.columns["other cycle"]) == [2, 3, 3]
    assert list(alike.columns["NRMSE"]) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    ratio = poisson_table(tests).columns["Poisson's ratio"]
    assert list(ratio) == pytest.approx([0.3] * len(ratio))
    fits = fits_table([measurement(strain, 50.0 * np.exp(12.0 * strain))], Choices(fit=(0.0, 0.4)))
    assert list(fits.columns["rate"]) == pytest.approx([12.0] * 3)
    assert min(map(float, fits.columns["weight of exponential"])) > 0.999
    for table in (repeatability_table([]), fits_table([], Choices()), poisson_table([]), holds_table([])):
        assert len(table) == 0
        assert table.headings()


def test_a_hold_of_travel_relaxes() -> None:
    strain = np.concatenate([np.linspace(0.0, 0.2, 50), np.full(100, 0.2), np.linspace(0.196, 0.0, 50)])
    stress = np.concatenate([np.linspace(0.0, 1e4, 50), 1e4 - 40.0 * np.arange(1, 101), np.linspace(5e3, 0.0, 50)])
    found = holds_table([measurement(strain, stress)])
    assert len(found) == 1
    assert found.columns["kind"][0] == "relaxation"
    assert found.columns["final rate"][0] == pytest.approx(-40.0)
    assert found.columns["change"][0] == pytest.approx(-0.4)
