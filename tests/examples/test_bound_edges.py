"""Edges that are bound off and cast on hold a knit together that unravels from open ones."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import from_yaml, load, to_yaml
from rigs.analysis.clasps import clasps_of
from rigs.protocol.edges import OPEN, Edges
from rigs.protocol.steps import Ramp
from rigs.protocol.targets import Target
from tests.examples.test_examples import EXAMPLES, Ran

if TYPE_CHECKING:
    from pathlib import Path

CHAINED = Edges(top="bound-off", bottom="cast-on")


def run_with(edges: Edges, folder: Path, counts: tuple[int, int], upper: float) -> Ran:
    """Run the example with fewer loops, pulled to a strain [1]."""
    whole = load(EXAMPLES / "bound_off_small.yaml").protocol
    rows, loops = counts
    specimen = replace(whole.specimen, edges=edges, rows=rows, loops=loops, nodes_per_loop=16)
    (ramp,) = (step for step in whole.steps if isinstance(step, Ramp))
    steps = (replace(ramp, to=Target(kind="strain", value=upper)),)
    protocol = replace(whole, specimen=specimen, steps=steps)
    (folder / "small.yaml").write_text(to_yaml(protocol), encoding="utf-8")
    result = run_protocol(folder / "small.yaml", folder / "run", draw=None)
    return Ran(result, RunReader(result.folder / "run.h5"))


@pytest.mark.slow
def test_chained_edges_hold_what_open_ones_let_go(tmp_path: Path) -> None:
    counts = (2, 4)
    for name in ("open", "chained"):
        (tmp_path / name).mkdir()
    bound = run_with(CHAINED, tmp_path / "chained", counts, 0.05)
    assert bound.result.outcome == "target"
    held = clasps_of(bound.run.trace)
    assert {joined: set(number) for joined, number in held.items()} == {"rows": {4}, "bound_off": {7}, "cast_on": {5}}
    assert from_yaml(bound.run.protocol).specimen.edges == CHAINED
    # The wales between the clamps pull out of the loops above and below.
    unbound = run_with(OPEN, tmp_path / "open", counts, 0.05)
    assert max(clasps_of(unbound.run.trace)["rows"]) <= 2


@pytest.mark.slow
def test_the_example_keeps_all_clasps_as_it_relaxes_and_when_it_is_pulled(tmp_path: Path) -> None:
    for name in ("open", "chained"):
        (tmp_path / name).mkdir()
    bound = run_with(CHAINED, tmp_path / "chained", (3, 4), 0.2)
    assert bound.result.outcome == "target"
    assert energy_balance_error(bound.run.trace) < 0.01
    held = clasps_of(bound.run.trace)
    assert {joined: set(number) for joined, number in held.items()} == {"rows": {8}, "bound_off": {7}, "cast_on": {5}}
    unbound = run_with(OPEN, tmp_path / "open", (3, 4), 0.2)
    assert max(clasps_of(unbound.run.trace)["rows"]) <= 4
