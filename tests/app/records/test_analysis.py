from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.analysis import OF_CURVES, OF_RUNS, analyse, analyse_run
from app.records.export import export_log
from app.records.measurements import whole_test, with_strain_across
from app.records.results import figures_of
from app.records.table_files import write_table
from knitlab_core.errors import SpecificationError
from rigs.analysis.curve_tables import poisson_table
from rigs.analysis.run_tables import bonds_table, break_histogram, energy_table, hooks_table
from rigs.analysis.table import Table
from rigs.trace import trace_of
from tests.synthetic_run import SIZE, make_run, rows, stress

if TYPE_CHECKING:
    from app.records.reader import RunReader

MEASURED = Path(__file__).parents[3] / "examples" / "fabric" / "measured"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunReader:
    return make_run(tmp_path_factory.mktemp("run") / "run.h5")


def results(table: Table) -> dict[tuple[str, int, str], float]:
    return {(str(row[1]), int(row[2]), str(row[3])): float(row[4]) for row in table.rows()}


@pytest.mark.parametrize("name", [*OF_CURVES, *OF_RUNS])
def test_every_table_of_a_run_has_rows_or_none_but_columns(run: RunReader, name: str) -> None:
    table = analyse_run(run, name)
    assert table.name == name
    assert len(table.headings()) > 3
    assert len(table) > 0 or name in {"holds", "poisson", "bonds"}


def test_figures_of_a_run_are_those_that_it_prints(run: RunReader) -> None:
    found = results(analyse_run(run))
    printed = {name: value for name, value, _ in figures_of(run)}
    for cycle in (1, 2):
        assert found["C", cycle, "Hysteresis energy density"] == printed[f"loop area, C, cycle {cycle}"]
        assert found["W", cycle, "Modulus (secant to peak)"] == printed[f"secant modulus to peak, W, cycle {cycle}"]
    assert found["C", 0, "Tensile stress at maximum force"] == pytest.approx(stress(0.4, 1, "Stretch", "C"))
    assert found["C", 2, "Energy of loading over that of the first cycle"] < 1.0


def test_a_run_and_its_own_log_have_the_same_figures(run: RunReader) -> None:
    path = export_log(run, run.path.parent, "biotester")
    own, read = results(analyse(run.path)), results(analyse(path))
    assert set(own) == set(read)
    # The stage rounds to whole µm and 0.01 mN, and its force has noise.
    for key in (("C", 1, "Tensile stress at tensile strain 30%"), ("W", 2, "Hysteresis energy density")):
        assert read[key] == pytest.approx(own[key], rel=0.02)


def test_a_free_axis_is_the_strain_across_of_the_other() -> None:
    trace = trace_of(rows())
    table = poisson_table(with_strain_across(whole_test(trace, SIZE, []), trace, free=True))
    # The made-up test stretches both alike.
    assert list(table.columns["Poisson's ratio"]) == pytest.approx([-1.0] * len(table))
    assert set(table.columns["axis"]) == {"C", "W"}
    assert len(poisson_table(with_strain_across(whole_test(trace, SIZE, []), trace, free=False))) == 0


def test_the_free_side_of_a_cell_is_the_strain_across() -> None:
    sides = [
        replace(row, displacement={"C": row.displacement["C"]}, crosshead={}, force={"C": row.force["C"]})
        for row in rows()
    ]
    made = [replace(row, cell={"C": 0.045 * (1.0 + k), "W": 0.04 * (1.0 - 0.001 * k)}) for k, row in enumerate(sides)]
    trace = trace_of(made)
    (test,) = with_strain_across(whole_test(trace, SIZE, []), trace, free=False)
    assert test.transverse == pytest.approx([-0.001 * k for k in range(len(made))])


def test_shares_of_the_stored_energy_sum_up_to_one() -> None:
    table = energy_table(trace_of(rows()), SIZE)
    parts = [table.columns[name] for name in table.columns if name.endswith("of stored")]
    assert np.sum(np.array(parts), axis=0) == pytest.approx(np.ones(len(table)))


def test_the_force_along_a_pole_is_measured_by_the_mean_hook() -> None:
    made = [replace(row, lateral_force=0.01 * max(row.force.values())) for row in rows()]
    ratio = np.array(hooks_table(trace_of(made), SIZE, {"C": 12, "W": 12}).columns["lateral over axial"], dtype=float)
    # A hundredth of the axis' force is twelve hundredths of that of one of its twelve hooks.
    assert ratio[np.isfinite(ratio)] == pytest.approx(0.12)


def test_broken_points_make_a_histogram_of_each_axis() -> None:
    made = [replace(row, bonds_broken=4 if row.time > 30.0 else 0) for row in rows()]
    table = bonds_table(trace_of(made), SIZE)
    for axis in ("C", "W"):
        counts = [int(row[3]) for row in table.rows() if row[0] == axis]
        assert (len(counts), sum(counts), max(counts)) == (40, 4, 4)


def test_breaks_count_at_the_strain_of_their_row() -> None:
    strain, broken = np.linspace(0.0, 0.4, 41), np.zeros(41)
    broken[12:] += 3
    broken[33:] += 2
    edges, counts = break_histogram(strain, broken, bins=4)
    assert edges == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert counts.sum() == 5
    assert counts[[1, 3]].tolist() == [3.0, 2.0]


def test_the_acrylic_fabric_has_the_published_forces_per_width() -> None:
    # Ranges of N/mm without repeat 1, from the page of the data; stress is force over width and 1 mm.
    for name, ranges in (
        ("course", {0.2: (0.062, 0.081), 0.3: (0.105, 0.129), 0.4: (0.18, 0.24)}),
        ("wale", {0.2: (0.150, 0.170)}),
    ):
        table = analyse(MEASURED / f"{name}.csv")
        for level, (low, high) in ranges.items():
            figure = f"Tensile stress at tensile strain {level:.0%}"
            found = [float(row[4]) for row in table.rows() if row[3] == figure and row[0] != f"{name}, repeat 1"]
            assert len(found) == 4
            assert all(low <= value / 1e6 <= high for value in found), (name, level, found)


def test_an_unknown_table_is_refused(run: RunReader) -> None:
    with pytest.raises(SpecificationError, match="one of results, curves"):
        analyse_run(run, "moduli")
    with pytest.raises(SpecificationError, match="others are of runs alone"):
        analyse(MEASURED / "course.csv", "energy")


TABLE = Table(
    name="t",
    columns={"name": ["a, b", "c"], "cycle": [1, 2], "stress": [1.0 / 3.0, float("nan")]},
    units={"stress": "Pa"},
)


def test_csv_keeps_every_digit(tmp_path: Path) -> None:
    path = write_table(TABLE, tmp_path / "new" / "t.csv")
    with path.open(encoding="utf-8", newline="") as file:
        assert list(csv.reader(file)) == [["name", "cycle", "stress [Pa]"], ["a, b", "1", str(1 / 3)], ["c", "2", ""]]
    with pytest.raises(SpecificationError, match=r"\.csv or \.parquet"):
        write_table(TABLE, tmp_path / "t.xlsx")


def test_parquet_and_dataframe_hold_the_same(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    frame = TABLE.dataframe()
    assert list(frame.columns) == ["name", "cycle", "stress [Pa]"]
    read = pandas.read_parquet(write_table(TABLE, tmp_path / "t.parquet"))
    assert frame["stress [Pa]"][0] == read["stress [Pa]"][0] == 1.0 / 3.0
    assert read["cycle"].tolist() == [1, 2]
    assert np.isnan(read["stress [Pa]"][1])
