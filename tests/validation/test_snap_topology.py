"""Strands that snap do not pass through each other: in every move that a search makes on the way.

Two centrelines that cross have two samples nearer than the spacing of samples over sqrt(2). While a search moves, no
pair of samples may come nearer than touching cores, which lie farther apart than that; so no strands can cross. Within
an arc of pi r of one strand no pairs are watched: there a curve bent by less than 1 / r cannot meet itself.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from app.checks.dry_run import build_specimen
from app.schemas import loads
from app.schemas.machine_data import machines_of
from knitlab_core.equilibrium.contacts import ContactTerm
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.rupture import break_fibre, sever, weakest
from knitlab_core.equilibrium.snap_through import longest_way
from knitlab_core.equilibrium.workspace import Workspace
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.record import Outcome
from tests.contact_scenes import sampled
from tests.validation.knit import make_knit

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import Model

PILE = Path(__file__).parents[2] / "examples" / "fig4c" / "fig4c_pile_4.yaml"


class Moves:
    """Every move of every search: the largest share of its room that a pair used, bend and spacing of samples.

    Nothing is taken from the code under test but positions: pairs are found by a tree over all samples.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.core = model.law.distance - model.law.overlap_limit
        self.count = 0
        self.share, self.bend, self.spacing = 0.0, 0.0, 0.0
        self._points: FloatArray | None = None

    def begin(self, q: FloatArray) -> None:
        """Begin a search at a configuration (N, 4)."""
        self._points = sampled(self.model, q)

    def move(self, q: FloatArray) -> None:
        """Add a move to a configuration (N, 4)."""
        before, after = self._points, sampled(self.model, q)
        assert before is not None
        motion = after - before
        self._points = after
        self.count += 1
        near = self._pairs(before, self.core + 2.0 * float(np.linalg.norm(motion, axis=1).max()))
        room = np.linalg.norm(before[near[:, 0]] - before[near[:, 1]], axis=1) - self.core
        used = np.linalg.norm(motion[near[:, 0]] - motion[near[:, 1]], axis=1)
        self.share = max(self.share, float((used / room).max(initial=0.0)))
        assert room.min(initial=1.0) > 0.0
        for strand in self._strands():
            steps = np.diff(after[strand], axis=0)
            lengths = np.linalg.norm(steps, axis=1)
            turns = np.linalg.norm(np.diff(steps / lengths[:, None], axis=0), axis=1)
            self.spacing = max(self.spacing, float(lengths.max()))
            self.bend = max(self.bend, float((turns / (0.5 * (lengths[1:] + lengths[:-1]))).max()))

    def _strands(self) -> list[np.ndarray]:
        samples, m = self.model.samples, len(self.model.samples.weights)
        spans = samples.spans
        # A cut takes the spans about it out of its strand.
        ends = (np.diff(samples.strand[spans]) != 0) | (np.diff(spans) != 1)
        strands = np.split(spans, np.flatnonzero(ends) + 1)
        return [(strand[:, None] * m + np.arange(m)).ravel() for strand in strands]

    def _pairs(self, points: FloatArray, distance: float) -> np.ndarray:
        samples, m = self.model.samples, len(self.model.samples.weights)
        inner = (samples.spans[:, None] * m + np.arange(m)).ravel()
        pairs = inner[cKDTree(points[inner]).query_pairs(distance, output_type="ndarray")]
        arc = (samples.arc[:, None] + ((np.arange(m) + 0.5) / m - 0.5) * samples.length[:, None] * m).ravel()
        same = samples.strand[pairs[:, 0] // m] == samples.strand[pairs[:, 1] // m]
        excluded = same & (np.abs(arc[pairs[:, 0]] - arc[pairs[:, 1]]) < self.model.law.exclusion)
        watched: np.ndarray = pairs[~excluded]
        return watched


def watch(monkeypatch: pytest.MonkeyPatch, moves: Moves) -> None:
    """Let every move of every search be seen."""
    start_step, keep_listed = Workspace.start_step, ContactTerm.keep_listed

    def begun(work: Workspace, q: FloatArray, *arguments: Any, **options: Any) -> None:  # noqa: ANN401 (handed through)
        moves.begin(q)
        start_step(work, q, *arguments, **options)

    def moved(contacts: ContactTerm, q: FloatArray) -> bool:
        moves.move(q)
        return keep_listed(contacts, q)

    monkeypatch.setattr(Workspace, "start_step", begun)
    monkeypatch.setattr(ContactTerm, "keep_listed", moved)


def test_no_strands_cross_where_a_fibre_breaks(bar: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    knit = make_knit(2, nodes_per_loop=16)
    work = Workspace(knit.model)
    *_, (_, state, _) = march(work, knit.start, lambda s: knit.target(0.3 * s), longest=0.1)
    edge = weakest(knit.model, state).edge
    moves, before = Moves(sever(knit.model, edge)), work.clock.iterations
    watch(monkeypatch, moves)
    left, found = break_fibre(work, state, edge)
    assert 20 <= left.clock.iterations - before <= 100
    assert longest_way(replace(found, increment=found.q - state.q)) > 2.0
    name = "2x2 whose fibre breaks"
    bar(f"{name}: share of its way to touching cores that a pair goes", moves.share, 1.0, "1", "solids do not cross")
    gap = moves.spacing / np.sqrt(2.0) / moves.core
    bar(f"{name}: distance of samples where strands cross, over the core's", gap, 1.0, "1", "solids do not cross")


@pytest.mark.parametrize("size", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_no_strands_cross_where_a_slack_pile_snaps(
    bar: Callable[..., None], monkeypatch: pytest.MonkeyPatch, size: int
) -> None:
    protocol = loads(PILE.read_text(encoding="utf-8").replace("[4, 4, 4]", f"[{size}, {size}, {size}]"))
    rig, state = mount(build_specimen(protocol), protocol.protocol, machines_of(protocol.protocol))
    moves = Moves(rig.work.model)
    watch(monkeypatch, moves)
    *_, outcome = perform(rig, state, protocol.protocol)
    assert isinstance(outcome, Outcome)
    assert outcome.end == "target"
    assert rig.work.clock.iterations <= moves.count  # no move was missed
    knit = f"pile {size}x{size}x{size} that snaps"
    bar(f"{knit}: share of its way to touching cores that a pair goes", moves.share, 1.0, "1", "solids do not cross")
    gap = moves.spacing / np.sqrt(2.0) / moves.core
    bar(f"{knit}: distance of samples where strands cross, over the core's", gap, 1.0, "1", "solids do not cross")
    bar(
        f"{knit}: largest bend",
        moves.bend,
        1.0,
        "1/r",
        "a curve bent by less than 1/r meets itself no sooner than pi r",
    )
