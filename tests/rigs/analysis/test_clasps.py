"""Clasps that let go are found in the rows of a run, live and from its record."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.client.answers import progress_of
from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.results import run_figures
from app.records.writer import RunWriter
from app.service.api.progress import ProgressView
from app.service.folder import JobFolder
from app.service.job_process import _Watch
from rigs.analysis.clasps import MOST_PLACES, ClaspCount, count_clasps, lost_as_mounted
from rigs.trace import trace_of
from tests.synthetic_run import BOTH, SIZE, rows

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import Axis
    from rigs.record import Equilibrium

PILE = [4, 4, 4, 3, 4, 3, 1, 1]
"""Clasps between layers that hold, row by row: one lets go, is found again, goes, and two more go."""


def drawn_out() -> list[Equilibrium]:
    return [replace(row, clasps={"rows": 4, "layers": held}) for row, held in zip(rows(), PILE, strict=False)]


def strains(row: Equilibrium) -> dict[Axis, float]:
    return {axis: row.displacement[axis] / SIZE.gauge(axis) for axis in BOTH}


def test_a_clasp_lets_go_where_fewer_hold_than_ever_before() -> None:
    made = drawn_out()
    found = count_clasps(trace_of(made), SIZE).losses
    assert [(loss.joined, loss.row, loss.lost, loss.held, loss.mounted) for loss in found] == [
        ("layers", 3, 1, 3, 4),
        ("layers", 6, 2, 1, 4),
    ]
    # Rows are 2 % of strain apart.
    assert found[0].strain == {"C": pytest.approx(0.06), "W": pytest.approx(0.06)}
    assert str(found[0]) == "a clasp between layers let go at 13.5 s, strain C 6.0 %, W 6.0 %: 3 of 4 hold"
    assert str(found[1]).startswith("2 clasps between layers let go at 27 s")


def test_rows_told_again_after_a_checkpoint_are_no_news() -> None:
    made, count = drawn_out(), ClaspCount()
    for number, row in enumerate(made):
        count.note_row(number, row, strains(row))
    once = list(count.losses)
    assert not [loss for number in range(2, 8) for loss in count.note_row(number, made[number], strains(made[number]))]
    assert count.losses == once == count_clasps(trace_of(made), SIZE).losses


def test_a_record_holds_the_clasps_of_every_row_under_their_own_names(tmp_path: Path) -> None:
    path, made = tmp_path / "run.h5", drawn_out()
    make_record(
        path,
        protocol="",
        size=SIZE,
        axes=BOTH,
        strands=[2],
        instruments=(),
        provenance={},
        clasps=("rows", "layers"),
    )
    with RunWriter(path) as writer:
        for row in made:
            writer.append(row)
    run = RunReader(path)
    assert run.trace.columns["clasps_layers"].tolist() == PILE
    assert run.trace.columns["clasps_rows"].tolist() == [4] * len(PILE)
    assert [loss.row for loss in run.losses] == [3, 6]
    figures = {name: value for name, value, _ in run_figures(run.trace, SIZE, (), 1.0)}
    assert figures["clasps between layers, as mounted"] == 4
    assert figures["clasps between layers, fewest"] == 1
    assert figures["clasps between rows, fewest"] == 4


def test_a_job_says_which_clasps_let_go(tmp_path: Path) -> None:
    files = JobFolder(tmp_path)
    files.write_progress(files.progress(), 0.0)
    watch = _Watch(files)
    for number, row in enumerate(drawn_out()):
        watch.row(number, row, strains(row))
    watch.progress(1.0, "done")
    view = ProgressView.model_validate(files.progress())
    assert [(loss.joined, loss.row, loss.held) for loss in view.losses] == [("layers", 3, 3), ("layers", 6, 1)]
    # The client hands on what the service says.
    assert progress_of(view.model_dump()).losses[1]["text"].startswith("2 clasps between layers let go")


def test_clasps_lost_before_a_test_are_named_but_not_those_that_a_coarse_mesh_misses() -> None:
    laid, mounted = np.ones((2, 3), dtype=np.bool_), np.ones((2, 3), dtype=np.bool_)
    laid[0, 0] = mounted[0, 0] = mounted[1, 2] = False
    (loss,) = lost_as_mounted({"rows": laid}, {"rows": mounted})
    assert (loss.lost, loss.held, loss.mounted) == (1, 4, 5)
    assert loss.places == "rows 1 and 2 at loop 2"
    assert lost_as_mounted({"rows": laid}, {"rows": laid}) == ()
    (many,) = lost_as_mounted({"rows": np.ones((4, 5), dtype=np.bool_)}, {"rows": np.zeros((4, 5), dtype=np.bool_)})
    assert many.places.endswith(f" and {20 - MOST_PLACES} more")
