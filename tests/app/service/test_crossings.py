"""Say in a job's progress where a fibre passed a limit of its material."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.client.answers import progress_of
from app.service.api.progress import ProgressView
from app.service.folder import JobFolder
from app.service.job_process import _Watch
from rigs.analysis.material_limits import MaterialLimit
from tests.synthetic_run import SIZE, rows

if TYPE_CHECKING:
    from pathlib import Path

LIMIT = MaterialLimit(name="strength", strain=0.0125, text="strength of 12.5 MPa")


def test_a_job_says_the_row_from_which_its_curve_is_not_to_be_believed(tmp_path: Path) -> None:
    files = JobFolder(tmp_path)
    files.write_progress(files.progress(), 0.0)
    watch = _Watch(files)
    watch.limits = [LIMIT]
    for number, row in enumerate(rows()[:14]):
        watch.row(number, row, {axis: row.displacement[axis] / SIZE.gauge(axis) for axis in row.displacement})
    watch.progress(1.0, "done")
    view = ProgressView.model_validate(files.progress())
    (crossing,) = view.crossings
    # The made-up fibre is strained by 0.3 strain², of rows 2 % apart: 1.25 % is not passed at 20 % but at 22 %.
    assert (crossing.name, crossing.row, crossing.time) == ("strength", 11, rows()[11].time)
    assert crossing.strain == {"C": pytest.approx(0.22), "W": pytest.approx(0.22)}
    assert crossing.text.startswith("strength of 12.5 MPa passed at 49.5 s")
    # The client hands on what the service says.
    assert progress_of(view.model_dump()).crossings[0]["row"] == 11
