"""Choose figures of a sweep by their words, and put them over one parameter or two."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pytest
from matplotlib.image import imread

from app.views.sweep_plots import matching, parameters_of, plot_figure, tables_of
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
    three = [({"a": 1, "b": 2, "c": 3}, figures(1.0))]
    with pytest.raises(SpecificationError, match="found 'a sweep of 3 parameters', allowed a sweep of one or two"):
        tables_of(three, "secant")
    many = [({"mu": 1, "top": 2}, [(f"stress at {k}%, C", 1.0, "Pa") for k in range(5)])]
    with pytest.raises(SpecificationError, match="which is 5 figures: stress at 0%"):
        tables_of(many, "stress")
