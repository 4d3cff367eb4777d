"""A knit that lets go as its yarn relaxes: what let go is named, and the run ends as unravelled."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.cli.exit_codes import NO_DATA, exit_code
from app.records.reader import RunReader
from app.records.results import pitch_of
from app.runs.use_cases import run_protocol

if TYPE_CHECKING:
    from pathlib import Path

    from app.runs.publishing import RunResult

# Two rows of one loop of straight yarn without friction: nothing holds the loop in its head.
LOOSE = """\
schema: knitlab/protocol@1
name: loose
rig: uniaxial-frame
mount: C
specimen:
  {knit: stockinette-default, loops: [2, 1], loop: 8 mm, material: cotton-2-ply, friction: 0, rest_shape: straight,
   nodes_per_loop: 16}
steps:
  - ramp: {axes: [C], to: 5 %, rate: 0.2 mm/s}
"""


@pytest.fixture(scope="module")
def loose(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    folder: Path = tmp_path_factory.mktemp("loose")
    (folder / "loose.yaml").write_text(LOOSE, encoding="utf-8")
    return run_protocol(folder / "loose.yaml", folder / "run", lambda _share, _text: None, draw=None)


def test_a_knit_that_unravels_before_its_test_is_no_target(loose: RunResult) -> None:
    assert loose.outcome == "unravelled"
    assert "rows 0 and 1" in loose.message
    assert "0 of 1 clasps" in loose.message
    assert loose.steps == ()
    assert exit_code(loose) == NO_DATA


def test_what_let_go_as_the_yarn_relaxed_is_named_with_its_place(loose: RunResult) -> None:
    run = RunReader(loose.folder / "run.h5")
    assert run.outcome.end == "unravelled"
    (loss,) = run.losses
    assert (loss.lost, loss.held, loss.mounted) == (1, 0, 1)
    assert loss.places == "rows 0 and 1 at loop 0"
    assert str(loss).startswith("a clasp between rows let go as the yarn relaxed: rows 0 and 1 at loop 0")
    assert len(run.trace) == 1
    # Loops that let go are no stitches of a pitch they were laid in at.
    assert pitch_of(run).keys() == {"W"}
    assert abs(pitch_of(run)["W"] / (0.86 * 8e-3) - 1.0) > 0.05
