from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from rigs.analysis.alignment import Alignment, aligned
from rigs.analysis.comparison import Group, comparison_table, quantities, reference_of
from tests.rigs.analysis.measured import GAUGE, SECTION, cycles, measurement


def group(name: str, *factors: float, measured: bool = True) -> Group:
    strain, stress = cycles(1)
    tests = [aligned(measurement(strain, factor * stress), Alignment()) for factor in factors]
    return Group(name=name, axis="C", tests=tests, measured=measured)


def scores(groups: list[Group]) -> dict[tuple[str, str], tuple[float, float, float]]:
    table = comparison_table(groups, "strain", "stress")
    return {(str(r[0]), str(r[3])): (float(r[4]), float(r[6]), float(r[7])) for r in table.rows()}


def test_scores_are_those_of_the_formulas() -> None:
    found = scores([group("run", 1.1, measured=False), group("file", 0.9, 1.1)])
    # The mean is the plain line; a tenth more of ε / 0.4 has a root mean square of 0.1 / √3 of the range.
    assert found["run", "NRMSE"][0] == pytest.approx(0.1 / np.sqrt(3.0), rel=5e-3)
    assert ("file", "NRMSE") not in found
    assert found["run", "Share inside the band"][0] == pytest.approx(1.0)
    assert found["file", "Modulus (secant 0 % - 20 %)"] == pytest.approx((1e5, 0.9e5, 1.1e5))
    assert found["run", "Modulus (secant 0 % - 40 %)"][0] == pytest.approx(1.1e5)
    assert found["file", "Energy of loading to 40 %"][0] == pytest.approx(0.5e5 * 0.16)
    # Back along a parabola: a third of the triangle's double.
    assert found["file", "Loop area"][0] == pytest.approx(1e5 * 0.16 * (1.0 / 2.0 - 1.0 / 3.0), rel=1e-3)
    assert found["file", "Hysteresis ratio"][0] == pytest.approx(1.0 / 3.0, rel=1e-3)
    assert ("run", "Modulus (secant 0 % - 50 %)") not in found


def test_a_curve_beside_the_band_is_outside() -> None:
    found = scores([group("file", 0.9, 1.1), group("run", 2.0, measured=False)])
    assert found["run", "Share inside the band"][0] < 0.01


def test_the_reference_is_what_was_measured_first() -> None:
    run, file = group("run", 1.0, measured=False), group("file", 1.0)
    assert reference_of([run, file], "C") is file
    assert reference_of([run, group("other", 1.0, measured=False)], "C") is run


def test_force_over_travel_where_no_strain_is_known() -> None:
    strain, stress = cycles(1)
    unknown = np.full(len(strain), np.nan)
    bare = measurement(strain, stress)
    for name in ("strain", "stress"):
        object.__setattr__(bare, name, unknown)
    groups = [Group(name="bare", axis="C", tests=[aligned(bare, Alignment())], measured=True), group("run", 1.0)]
    across, along = quantities(groups)
    assert (across, along) == ("travel", "force")
    table = comparison_table(groups, across, along)
    values = {(str(row[0]), str(row[3])): (float(row[4]), str(row[5])) for row in table.rows()}
    value, unit = values["bare", "Stiffness (secant 0 mm - 10 mm)"]
    assert value == pytest.approx(1e5 * SECTION / GAUGE)
    assert unit == "N/m"
    assert values["run", "NRMSE"][0] == pytest.approx(0.0, abs=1e-12)


def test_tests_without_a_common_range_are_refused() -> None:
    late = measurement(np.linspace(0.5, 0.9, 50), np.linspace(0.0, 1.0, 50))
    groups = [group("run", 1.0), Group(name="late", axis="C", tests=[aligned(late, Alignment())], measured=True)]
    with pytest.raises(SpecificationError, match="tests of one range"):
        comparison_table(groups, "strain", "stress")
