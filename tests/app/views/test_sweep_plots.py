"""Choose figures of a sweep by their words, and put them over one parameter or two."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pytest
from matplotlib.image import imread

from app.views.sweep_effects import effect_of, levels_of
from app.views.sweep_plots import factor_of, is_grid, matching, parameters_of, plot_figure, tables_of
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from pathlib import Path

    from app.records.results import Figure
    from app.schemas.sweep import Scalar
    from app.views.sweep_plots import Points


def figures(stiffness: float) -> tuple[Figure, ...]:
    return (
        ("secant modulus to peak, C, cycle 1", stiffness, "Pa"),
        ("secant modulus to peak, C, cycle 2", 0.9 * stiffness, "Pa"),
        ("secant modulus to peak, W, cycle 1", 2.0 * stiffness, "Pa"),
        ("loop area / work of loading, C, cycle 1", 0.2, "1"),
    )


def one_parameter(values: list[Scalar]) -> Points:
    return [({"pre": value}, figures(1e4 * (k + 1))) for k, value in enumerate(values)]


def test_figures_are_chosen_by_words_and_axes_by_letters() -> None:
    points = one_parameter([0, 1])
    assert [name for name, _ in matching(points, "secant_C")] == [
        "secant modulus to peak, C, cycle 1",
        "secant modulus to peak, C, cycle 2",
    ]
    assert [name for name, _ in matching(points, "peak W")] == ["secant modulus to peak, W, cycle 1"]
    assert [unit for _, unit in matching(points, "loop area")] == ["1"]
    with pytest.raises(SpecificationError, match="--plot: found 'secant_P', allowed words of a figure: secant modulus"):
        matching(points, "secant_P")


def test_one_parameter_is_an_axis_in_its_own_order_and_unit() -> None:
    # As the sweep lists them: not in order.
    (parameter,), tables = tables_of(one_parameter(["20 %", "0 %", "5 %"]), "secant_C")
    assert (parameter.label, parameter.at.tolist(), parameter.words) == ("pre [%]", [0.0, 5.0, 20.0], False)
    assert [table.label for table in tables] == [
        "secant modulus to peak, C, cycle 1 [kPa]",
        "secant modulus to peak, C, cycle 2 [kPa]",
    ]
    assert tables[0].values == pytest.approx([20.0, 30.0, 10.0])
    assert tables[1].values == pytest.approx([18.0, 27.0, 9.0])


@pytest.mark.parametrize("values", [["RGD8530-DM", "IP-Dip"], ["1 mm", "10 um"], [True, False]])
def test_values_that_make_no_one_scale_are_named(values: list[Scalar]) -> None:
    (parameter,) = parameters_of(one_parameter(values))
    assert (parameter.words, list(parameter.values), parameter.at.tolist()) == (True, values, [0.0, 1.0])


def two_parameters() -> Points:
    return [
        ({"mu": mu, "top": top}, figures(1e4 * (1 + mu) * k))
        for mu, (k, top) in product((0.5, 0), enumerate(("4 %", "6 %", "8 %")))
    ]


def test_two_parameters_make_a_map(tmp_path: Path) -> None:
    (mu, top), (table,) = tables_of(two_parameters(), "peak W")
    assert (mu.at.tolist(), top.at.tolist()) == ([0.0, 0.5], [4.0, 6.0, 8.0])
    # Rows are of the second parameter, columns of the first.
    assert table.values == pytest.approx(np.array([[0.0, 0.0], [20.0, 30.0], [40.0, 60.0]]))
    path = plot_figure(two_parameters(), "peak W", tmp_path)
    assert path.name == "sweep_peak_W.png"
    assert imread(path).std() > 0.1


def test_a_point_without_the_figure_leaves_a_gap(tmp_path: Path) -> None:
    points = [*one_parameter([0, 1])[:1], ({"pre": 1}, ())]
    _, (table,) = tables_of(points, "peak W")
    assert table.values[0] == pytest.approx(20.0)
    assert np.isnan(table.values[1])
    assert plot_figure(points, "peak W", tmp_path).exists()
    gap: Points = [*two_parameters()[:5], ({"mu": 0, "top": "8 %"}, ())]
    assert plot_figure(gap, "loop area", tmp_path).exists()


def test_what_cannot_be_plotted_is_said() -> None:
    nine = [({f"p{k}": 1 for k in range(9)}, figures(1.0))]
    with pytest.raises(SpecificationError, match="found 'a sweep of 9 parameters', allowed one of 1 to 8"):
        tables_of(nine, "secant")
    many = [({"mu": 1, "top": 2}, [(f"stress at {k}%, C", 1.0, "Pa") for k in range(5)])]
    with pytest.raises(SpecificationError, match="which is 5 figures: stress at 0%"):
        tables_of(many, "stress")


def filling(count: int, seed: int = 2) -> Points:
    """Return a design of three parameters: figures rise with the first, hardly with the second, not with the third."""
    chance = np.random.default_rng(seed)
    return [
        (
            {"a": f"{x:.4g} mm", "b": float(f"{y:.4g}"), "c": "hard" if z > 0.5 else "soft"},
            figures(1e4 * (1 + 2 * x + 0.2 * y)),
        )
        for x, y, z in chance.random((count, 3))
    ]


def test_points_of_three_parameters_have_main_effects(tmp_path: Path) -> None:
    points = filling(60)
    parameters, (table, *_) = tables_of(points, "peak W")
    assert table.values.shape == (60,)
    shares = [effect_of(factor_of(one, points).at, table.values).share for one in parameters]
    assert shares[0] > 0.9
    assert max(shares[1:]) < 0.3
    path = plot_figure(points, "peak_W", tmp_path)
    assert path.name == "sweep_peak_W.png"
    assert imread(path).shape[1] > 2 * imread(path).shape[0]


def test_an_effect_is_the_mean_of_a_level_whatever_the_others_are() -> None:
    at = np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0])
    found = effect_of(at, np.array([1.0, 3.0, 4.0, 6.0, 7.0, np.nan]))
    assert found.at.tolist() == [0.0, 1.0, 2.0]
    assert found.mean.tolist() == [2.0, 5.0, 7.0]
    # Of a pair the standard error is half of what they are apart; of one point there is none.
    assert found.error[:2].tolist() == pytest.approx([1.0, 1.0])
    assert np.isnan(found.error[2])
    # Between: 2 (2 - 4.2)² + 2 (5 - 4.2)² + (7 - 4.2)² of the whole 22.8.
    assert found.share == pytest.approx((2 * 2.2**2 + 2 * 0.8**2 + 2.8**2) / 22.8)
    # Many values are put into levels of equal counts.
    assert np.bincount(levels_of(np.random.default_rng(0).random(50))).tolist() == [10] * 5
    assert np.isnan(effect_of(at, np.ones(6)).share)


def test_two_parameters_without_a_grid_are_points_in_a_plane(tmp_path: Path) -> None:
    points: Points = [({"a": values["a"], "b": values["b"]}, found) for values, found in filling(20)]
    parameters, (table,) = tables_of(points, "peak W")
    assert not is_grid(points, parameters)
    assert is_grid(two_parameters(), parameters_of(two_parameters()))
    assert table.values.shape == (20,)
    assert imread(plot_figure([*points, ({"a": "0.5 mm", "b": 0.5}, ())], "peak_W", tmp_path)).std() > 0.05
