"""Run the example with clamps, and hold it to what clamps do."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import from_yaml, load, to_yaml
from knitlab_core.knits import clamp_nodes
from rigs.machines.pins import distance, pins_on
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Cycle
from tests.examples.test_examples import EXAMPLES, Ran

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.protocol.catalogue import Grips


def run_small(folder: Path, grips: Grips, upper: float) -> Ran:
    """Run the example on a coarse mesh to a smaller strain [1], between clamps as it is or on hooks."""
    whole = load(EXAMPLES / "clamped_small.yaml").protocol
    (cycle,) = (step for step in whole.steps if isinstance(step, Cycle))
    steps = (whole.steps[0], replace(cycle, upper=upper))
    specimen = replace(whole.specimen, nodes_per_loop=16)
    protocol = replace(whole, grips=grips, specimen=specimen, steps=steps, max_strain_increment=0.03)
    (folder / "small.yaml").write_text(to_yaml(protocol), encoding="utf-8")
    result = run_protocol(folder / "small.yaml", folder / "run", lambda _share, _text: None, draw=None)
    return Ran(result, RunReader(result.folder / "run.h5"))


@pytest.fixture(scope="module")
def clamped(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return run_small(tmp_path_factory.mktemp("clamped"), "clamps", 0.3)


def test_clamps_move_as_rigid_bodies_and_what_they_exert_balances(clamped: Ran) -> None:
    assert clamped.result.outcome == "target"
    assert energy_balance_error(clamped.run.trace) <= 0.01
    clamps = clamp_nodes(make_specimen(from_yaml(clamped.run.protocol).specimen), "W")
    first, *_, last = clamped.run.frames()
    for frame in clamped.run.frames():
        for nodes, travel in ((clamps.lower, 0.0), (clamps.upper, clamps.gap * frame.strain["W"])):
            moved = frame.nodes[nodes] - first.nodes[nodes]
            assert moved == pytest.approx(np.tile([0.0, travel, 0.0], (len(nodes), 1)), abs=1e-9)
    assert last.strain["W"] == pytest.approx(0.0, abs=1e-6)
    columns = clamped.run.trace.columns
    pull = np.abs(columns["force_W"]).max()
    for along in ("C", "W", "P"):
        total = columns[f"fixture_force_W+_{along}"] + columns[f"fixture_force_W-_{along}"]
        assert np.abs(total).max() <= 1e-3 * pull
    assert columns["fixture_force_W+_W"] == pytest.approx(columns["force_W"])


def test_pins_in_the_fabric_go_apart_along_the_pull_and_together_across_it(clamped: Ran) -> None:
    columns = clamped.run.trace.columns
    protocol = from_yaml(clamped.run.protocol)
    assert protocol.extensometer is not None
    pins = pins_on(make_specimen(protocol.specimen), protocol.extensometer)
    for frame in clamped.run.frames():
        row = int(np.searchsorted(columns["time"], frame.time + 1e-9)) - 1
        for axis, pair in pins.items():
            assert distance(pair, axis, frame.nodes) == pytest.approx(columns[f"pin_distance_{axis}"][row], rel=1e-9)
    peak = int(np.argmax(columns["force_W"]))
    wale, course = (columns[f"pin_distance_{axis}"][peak] / columns[f"pin_distance_{axis}"][0] - 1.0 for axis in "WC")
    # The three rows between the jaws take all of the travel.
    jaws = columns["displacement_W"][peak] / clamped.run.size.extents["W"]
    assert jaws < wale < 2.0 * jaws
    assert -0.3 < course < -0.01


def test_the_extensometer_reads_with_its_own_noise_in_whole_digits(clamped: Ran) -> None:
    (log,) = clamped.run.samples.values()
    for axis in ("C", "W"):
        shown, clean = log.measured[f"Extensometer{axis}"], log.clean[f"Extensometer{axis}"]
        assert shown * 1e6 == pytest.approx(np.round(shown * 1e6), abs=1e-6)
        assert np.std(shown - clean) == pytest.approx(2e-6, rel=0.2)
        assert np.all(log.offset[f"Extensometer{axis}"] == 0.0)
    (csv,) = clamped.result.folder.rglob("*.csv")
    heading, units, first, *_ = csv.read_text(encoding="utf-8").splitlines()
    assert heading == "Time,Displacement,Force,Extensometer C,Extensometer W"
    assert units == "(s),(mm),(N),(mm),(mm)"
    assert float(first.split(",")[4]) == pytest.approx(1e3 * log.measured["ExtensometerW"][0], abs=1e-4)
    names = [name for name, *_ in clamped.result.figures]
    assert "strain between pins W, largest" in names


def test_a_knit_between_clamps_is_stiffer_than_one_on_hooks(clamped: Ran, tmp_path: Path) -> None:
    hooked = run_small(tmp_path, "hooks", 0.26)
    # Of the strain that hooks impose the loops in which they hang take a part; jaws leave the free rows all of it.
    assert clamped.stress("W", 0.25) > 1.5 * hooked.stress("W", 0.25)
