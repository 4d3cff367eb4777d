"""Plots of figures over the points of a sweep: curves over one parameter, maps over two, main effects of more."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from app.views.curves import prefixed
from app.views.lettering import write_plainly
from app.views.plots import framed, write_figure
from app.views.sweep_effects import Factor, draw_effect, draw_scattered
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    import numpy.typing as npt
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Page

    from app.records.results import Figure
    from app.schemas.sweep import Scalar
    from rigs.axes import FloatArray

Points: TypeAlias = "Sequence[tuple[Mapping[str, Scalar], Sequence[Figure]]]"

#: Curves in one plot, or maps beside each other.
MOST_CURVES = 8
MOST_MAPS = 4
#: Parameters whose main effects are drawn beside each other.
MOST_PARAMETERS = 8
MOST_NUMBERS = 100
"""Fields of a map that carry their number."""

LIGHTNESS = (0.30, 0.59, 0.11)
"""Shares of red, green and blue in how light a colour is."""

LEAST_SIGN = 0.02
"""Share of the largest value that the other sign must have to be shown."""

_NUMBER = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.*)")
_INKS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#E69F00", "#56B4E9", "#999999")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parameter:
    """A swept parameter: the label of its axis, and its values in the axis's order.

    Attributes
    ----------
    name, label : str
        Its name, and the same with the unit of its values.
    values : sequence of Scalar
        As the sweep gives them, each once.
    at : FloatArray, shape (n,)
        Where they are on the axis: the numbers, or 0, 1, 2 ... of words and of numbers of several units.
    words : bool
        Whether the axis names each value.
    """

    name: str
    label: str
    values: Sequence[Scalar]
    at: FloatArray
    words: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """Values of a figure at every point of a sweep.

    Attributes
    ----------
    name : str
        The figure.
    label : str
        The same with the unit that suits its values.
    values : FloatArray, shape (n,) or (m, n)
        In that unit; over one parameter, or the second by the first; point by point where these are on no grid. nan
        where a point has no such figure.
    """

    name: str
    label: str
    values: FloatArray


def parameters_of(points: Points) -> list[Parameter]:
    """Return the parameters that were swept.

    Raises
    ------
    SpecificationError
        If that is none, or more than `MOST_PARAMETERS`.
    """
    names = list(points[0][0]) if points else []
    if not 1 <= len(names) <= MOST_PARAMETERS:
        raise SpecificationError("--plot", f"a sweep of {len(names)} parameters", f"one of 1 to {MOST_PARAMETERS}")
    return [_parameter(name, list(dict.fromkeys(values[name] for values, _ in points))) for name in names]


def _parameter(name: str, values: list[Scalar]) -> Parameter:
    found = [_NUMBER.fullmatch(str(value)) for value in values]
    units = {match[2] for match in found if match}
    if len(units) == 1 and all(found) and not any(isinstance(value, bool) for value in values):
        at = np.array([float(match[1]) for match in found if match])
        order = np.argsort(at, kind="stable")
        unit = units.pop()
        label = f"{name} [{unit}]" if unit else name
        return Parameter(name=name, label=label, values=[values[k] for k in order], at=at[order], words=False)
    return Parameter(name=name, label=name, values=values, at=np.arange(float(len(values))), words=True)


def matching(points: Points, words: str) -> list[tuple[str, str]]:
    """Return name and unit of the figures that contain all words of a choice, such as ``secant_peak_C``.

    A capital letter alone is an axis; case counts for it alone.

    Raises
    ------
    SpecificationError
        If none does.
    """
    known = dict.fromkeys((name, unit) for _, figures in points for name, _, unit in figures)
    wanted = [word for word in re.split(r"[\s_,]+", words) if word]
    found = [
        (name, unit) for name, unit in known if all(_holds(re.split(r"[\s,/]+", name), name, word) for word in wanted)
    ]
    if not wanted or not found:
        names = "; ".join(name for name, _ in known) or "none yet"
        raise SpecificationError("--plot", words, f"words of a figure: {names}")
    return found


def _holds(parts: Sequence[str], name: str, word: str) -> bool:
    return word in parts if len(word) == 1 else word.lower() in name.lower()


def tables_of(points: Points, words: str) -> tuple[list[Parameter], list[Table]]:
    """Return the swept parameters, and each chosen figure over them: on their grid, or point by point (n,) without one.

    Raises
    ------
    SpecificationError
        If nothing matches the words, too much does, or too many parameters are swept.
    """
    parameters = parameters_of(points)
    grid = is_grid(points, parameters)
    found, most = matching(points, words), MOST_CURVES if len(parameters) == 1 else MOST_MAPS
    if len(found) > most:
        names = "; ".join(name for name, _ in found)
        raise SpecificationError("--plot", f"{words}, which is {len(found)} figures: {names}", f"at most {most}")
    tables = []
    for name, unit in found:
        values = np.full(tuple(len(one.values) for one in parameters) if grid else (len(points),), np.nan)
        for number, (at, figures) in enumerate(points):
            place = tuple(list(one.values).index(at[one.name]) for one in parameters) if grid else (number,)
            values[place] = next((value for other, value, _ in figures if other == name), np.nan)
        tables.append((name, unit, values))
    # Curves in one plot share one axis, and so one prefix.
    largest: dict[str, float] = {}
    for _, unit, values in tables:
        size = float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 0.0
        largest[unit] = max(largest.get(unit, 0.0), size)
    made = []
    for name, unit, values in tables:
        factor, letter = (1.0, "") if unit in {"1", "s"} else prefixed(largest[unit])
        shown = f"{letter}{unit}"
        made.append(Table(name=name, label=f"{name} [{shown}]", values=factor * values.T))
    return parameters, made


def is_grid(points: Points, parameters: Sequence[Parameter]) -> bool:
    """Return whether the points of one or two parameters are on a grid: at most half of its places are empty."""
    places = 1
    for one in parameters:
        places *= len(one.values)
    return len(parameters) == 1 or (len(parameters) == 2 and places <= 2 * len(points))


def factor_of(parameter: Parameter, points: Points) -> Factor:
    """Return the values of a parameter point by point."""
    where = {value: float(at) for value, at in zip(parameter.values, parameter.at, strict=True)}
    return Factor(
        label=parameter.label,
        at=np.array([where[values[parameter.name]] for values, _ in points]),
        words=[str(value) for value in parameter.values] if parameter.words else [],
    )


def plot_figure(points: Points, words: str, folder: Path) -> Path:
    """Plot the chosen figures over the parameters of a sweep, into ``sweep_WORDS.png``.

    Raises
    ------
    SpecificationError
        As `tables_of`.
    """
    return write_figure(figure_over(points, words), folder / f"sweep_{re.sub(r'[^A-Za-z0-9.+-]+', '_', words)}.png")


def figure_over(points: Points, words: str) -> Page:
    """Return the figure that `plot_figure` writes."""
    from matplotlib.figure import Figure as Page  # noqa: PLC0415 - imported when a plot is wanted

    parameters, tables = tables_of(points, words)
    if len(parameters) == 1:
        page = Page(figsize=(6.4, 4.6), layout="constrained")
        axes = page.subplots()
        _curves(axes, parameters[0], tables)
        write_plainly([axes.xaxis.label, *axes.get_xticklabels()])
        return framed(page, [axes])
    if len(parameters) > 2:
        page = Page(figsize=(1.0 + 3.2 * len(parameters), 0.6 + 3.2 * len(tables)), layout="constrained")
        grid = page.subplots(len(tables), len(parameters), squeeze=False, sharey="row", sharex="col")
        _main_effects(grid, [factor_of(one, points) for one in parameters], tables)
        return framed(page, _written_plainly(grid.flat))
    page = Page(figsize=(5.6 * len(tables), 4.6), layout="constrained")
    panels = page.subplots(1, len(tables), squeeze=False)[0]
    first, second = parameters
    for panel, table in zip(panels, tables, strict=True):
        if is_grid(points, parameters):
            _map(panel, parameters, table)
        else:
            draw_scattered(panel, (factor_of(first, points), factor_of(second, points)), table.values, table.label)
    _written_plainly(panels)
    return page


def _written_plainly(panels: Iterable[Axes]) -> list[Axes]:
    """Return panels, the texts of users on their axes drawn as written."""
    found = list(panels)
    for panel in found:
        write_plainly([panel.xaxis.label, panel.yaxis.label, *panel.get_xticklabels(), *panel.get_yticklabels()])
    return found


def _main_effects(grid: npt.NDArray[np.object_], factors: Sequence[Factor], tables: Sequence[Table]) -> None:
    """Draw the main effects: a row a figure, a column a parameter."""
    for row, table in zip(grid, tables, strict=True):
        for axes, factor in zip(row, factors, strict=True):
            draw_effect(axes, factor, table.values)
            axes.label_outer()
        row[0].set_ylabel(table.label, fontsize=11)
    grid[0, 0].legend(frameon=False, fontsize=9)


def _curves(axes: Axes, parameter: Parameter, tables: Sequence[Table]) -> None:
    for number, table in enumerate(tables):
        axes.plot(parameter.at, table.values, "o-", color=_INKS[number % len(_INKS)], lw=1.6, label=table.label)
    axes.set_xlabel(parameter.label, fontsize=12)
    if parameter.words:
        axes.set_xticks(parameter.at, [str(value) for value in parameter.values])
    if len(tables) == 1:
        axes.set_ylabel(tables[0].label, fontsize=12)
    else:
        units = {table.label.rpartition(" [")[2].rstrip("]") for table in tables}
        axes.set_ylabel(f"[{', '.join(sorted(units))}]", fontsize=12)
        axes.legend(frameon=False, fontsize=9)


def _map(axes: Axes, parameters: Sequence[Parameter], table: Table) -> None:
    """Draw a cell for every point, with its number; nothing is interpolated."""
    first, second = parameters
    low, high = np.nanmin(table.values), np.nanmax(table.values)
    size = max(-low, high)
    # The sign of a value far below the largest is rounding.
    signed = low < -LEAST_SIGN * size and high > LEAST_SIGN * size
    limits = {"vmin": -size, "vmax": size, "cmap": "coolwarm"} if signed else {"cmap": "viridis"}
    image = axes.imshow(table.values, origin="lower", aspect="auto", **limits)
    axes.set_xticks(range(len(first.values)), [_text(first, k) for k in range(len(first.values))])
    axes.set_yticks(range(len(second.values)), [_text(second, k) for k in range(len(second.values))])
    axes.set_xlabel(first.label, fontsize=12)
    axes.set_ylabel(second.label, fontsize=12)
    if table.values.size <= MOST_NUMBERS:
        for (row, column), value in np.ndenumerate(table.values):
            light = float(image.to_rgba(np.array([value]))[0, :3] @ LIGHTNESS)
            ink = "black" if np.isnan(value) or light > 0.5 else "white"
            axes.text(column, row, "none" if np.isnan(value) else f"{value:.3g}", ha="center", va="center", color=ink)
    axes.figure.colorbar(image, ax=axes, label=table.label)


def _text(parameter: Parameter, number: int) -> str:
    return str(parameter.values[number]) if parameter.words else f"{parameter.at[number]:g}"
