"""Contact and friction between two equilibria: the pairs that act, and what they store, exert and resist.

Span pairs within a wide skin are listed now and then; the sample pairs that *touch*, a tenth of them, are gathered
from the list in every configuration. Friction acts in the pairs that *rub*: those that touched when loads were
last taken, at first those that were loaded at the last equilibrium.
"""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.approach import largest_approach
from knitlab_core.contact.forces import (
    contact_energy,
    contact_gradient,
    friction_energy,
    friction_gradient,
    lag,
)
from knitlab_core.contact.friction import STEADY, Lead, Memory, add_load_coupling, recall, settle, step_law
from knitlab_core.contact.law import ContactLaw
from knitlab_core.contact.neighbours import list_spans, list_swept
from knitlab_core.contact.pairs import Balls, Candidates, SpanPairs, fill_balls, gather_pairs, grouped, largest_fraction
from knitlab_core.contact.samples import Samples, sample_points
from knitlab_core.contact.slip import Placed
from knitlab_core.contact.stiffness import contact_hessian, friction_hessian
from knitlab_core.equilibrium.pattern import locate_across
from knitlab_core.equilibrium.stopwatch import Stopwatch
from knitlab_core.rods.frames import Frames
from knitlab_core.sparse.blocks import Pattern

SKIN = 2.0
"""Extra distance within which span pairs are listed [r]: they are cheap to pass over, and to list is not."""

LIST_AGAIN = 0.5
"""Share of the skin by which strands may have approached before pairs are listed again; steps may use the rest."""

SWEPT = 4e4
"""Nodes times longest motion [r] up to which all pairs on the way are listed; longer steps are cut instead."""


class ContactTerm:
    """Contact and friction between the samples that a workspace places.

    Parameters
    ----------
    placed : Placed
        Samples and edges of the workspace, which moves them.
    samples : Samples
        Where they are on the strands.
    law : ContactLaw
        Normal contact and friction.
    clock : Stopwatch
        Where time is counted.

    Attributes
    ----------
    spans : SpanPairs
        Span pairs that may touch.
    touching : Candidates
        Sample pairs within reach of each other where the samples are placed.
    rubbing : Candidates
        Sample pairs in which friction acts.
    state : PairState
        Friction's state of these.
    """

    spans: SpanPairs
    touching: Candidates
    _pattern: Pattern

    def __init__(self, placed: Placed, samples: Samples, law: ContactLaw, clock: Stopwatch) -> None:
        self._placed, self._samples, self._clock = placed, samples, clock
        # Slip is extrapolated in a step by a law of its own.
        self._law, self._step_law = law, law
        nodes = len(placed.length)
        self._m = len(samples.weights)
        self._balls, self._move_balls = Balls.zeros(nodes), Balls.zeros(nodes)
        self._moves = np.zeros_like(placed.points)
        self._base = np.zeros_like(placed.points)
        self._listed = np.zeros((nodes, 3))
        self._memory = Memory.empty()
        self._lead = STEADY
        # Pairs are gathered into the room that rubbing pairs do not use.
        self._rooms = [Candidates.empty(64, 1024), Candidates.empty(64, 1024)]
        self._rub(grouped(self._memory.key, len(placed.points), self._m))

    def _rub(self, pairs: Candidates) -> None:
        self.rubbing, self.state = pairs, recall(self._memory, pairs, self._base, self._lead)

    def start(self, q: FloatArray, memory: Memory, lead: Lead = STEADY) -> None:
        """Begin at an equilibrium with what friction remembers of it, and how slip is extrapolated in the step."""
        self._memory, self._lead, self._step_law = memory, lead, step_law(self._law, lead)
        with self._clock("neighbours"):
            sample_points(q, self._samples, self._base)
            self._rub(grouped(memory.key, len(self._base), self._m))
            self._list_again(q)

    def _list_again(self, q: FloatArray) -> None:
        """List the span pairs about configuration `q`."""
        self.spans = list_spans(q, self._samples, self._law.distance + SKIN, self._balls)
        self._listed = q[:, :3].copy()

    def _used(self, q: FloatArray, enough: float) -> float:
        """Return by how much strands may have approached since they were listed [r]."""
        return largest_approach(self._listed, q[:, :3] - self._listed, self._law.distance + SKIN, enough)

    def keep_listed(self, q: FloatArray) -> bool:
        """List the span pairs again if strands may have approached by much of the skin; return whether. Forces stay."""
        spare = LIST_AGAIN * SKIN
        with self._clock("neighbours"):
            if self._used(q, spare) <= spare:
                return False
            self._list_again(q)
            return True

    def place(self, q: FloatArray, _: Frames) -> None:
        """Gather the pairs that touch; the samples have been placed at `q`."""
        fill_balls(q, self._samples.spans, self._balls)
        law = self._law
        points, reach = self._placed.points, law.reach
        while True:
            room = self._rooms[0]
            spans, pairs = gather_pairs(points, self._balls, self.spans, self._samples, reach, law.exclusion, room)
            if spans <= room.span_a.size and pairs <= room.a.size:
                break
            self._rooms[0] = Candidates.empty(2 * spans, 2 * pairs)
        self.touching = room.first(spans, pairs)

    def lag(self) -> int:
        """Switch friction on in the pairs that touch, with their loads; return their number."""
        if self.rubbing is not self.touching:
            self._rooms.reverse()
            self._rub(self.touching)
        return lag(self._placed, self.rubbing, self._samples.length, self._step_law, self.state)

    def normal_energy(self) -> float:
        """Return the energy of normal contact [E r^3]."""
        return contact_energy(self._placed.points, self.touching, self._samples.length, self._law)

    def energy(self) -> float:
        """Return the energy of contact and friction [E r^3]."""
        normal, law = self.normal_energy(), self._step_law
        if law.friction == 0.0:
            return normal
        return normal + friction_energy(self._placed, self.rubbing, law, self.state)

    def add_gradient(self, gradient: FloatArray) -> None:
        """Add the forces to a gradient (N, 4)."""
        law = self._step_law
        contact_gradient(self._placed.points, self.touching, self._samples, law, gradient)
        if law.friction > 0.0:
            friction_gradient(self._placed, self.rubbing, self._samples, law, self.state, gradient)

    def fits(self, pattern: Pattern) -> bool:
        """Take a pattern; return whether it has the blocks of all pairs that act."""
        self._pattern = pattern
        return all(locate_across(pattern, pairs)[1] for pairs in (self.touching, self.rubbing))

    def drop_far_pairs(self, pattern: Pattern) -> None:
        """Take a pattern made here, and drop pairs that rub but lack blocks in it: they are far apart by now."""
        self._pattern = pattern
        across, whole = locate_across(pattern, self.rubbing)
        if not whole:
            lost = np.repeat(across[:, 0] < 0, np.diff(self.rubbing.start))
            keep = ~lost
            m, samples = self._m, len(self._base)
            self._rub(grouped(self.rubbing.a[keep] * samples + self.rubbing.b[keep], samples, m))

    def add_hessian(self, exact: float, blocks: FloatArray) -> None:
        """Add the stiffness to the blocks of the pattern last taken."""
        placed, samples, law, pattern = self._placed, self._samples, self._step_law, self._pattern
        across, _ = locate_across(pattern, self.touching)
        pattern = pattern._replace(across=across)
        contact_hessian(placed.points, self.touching, samples, law, exact, pattern, blocks)
        if law.friction > 0.0:
            if self.rubbing is not self.touching:
                pattern = pattern._replace(across=locate_across(pattern, self.rubbing)[0])
            friction_hessian(placed, self.rubbing, samples, law, exact, self.state, pattern, blocks)

    def add_load_coupling(self, v: FloatArray, out: FloatArray) -> None:
        """Add to `out` (N, 4) how friction changes because a motion `v` (N, 4) changes the loads."""
        add_load_coupling(self._placed, self.rubbing, self._samples, self._step_law, self.state, v, out)

    def collision_free_fraction(self, q: FloatArray, step: FloatArray, share: float) -> float:
        """Return the largest fraction of a step from `q`, the configuration last placed, that is free of collisions.

        In it no strands can pass through each other, and no pair can touch that is not listed. Pairs use at most
        `share` of the way to their neighbour's core.
        """
        with self._clock("neighbours"):
            return self._fraction(q, step, share)

    def _fraction(self, q: FloatArray, step: FloatArray, share: float) -> float:
        samples, law = self._samples, self._law
        sample_points(step, samples, self._moves)
        fill_balls(step, samples.spans, self._move_balls)
        reach = law.distance + SKIN
        limit = SKIN - law.onset - self._used(q, 0.1)
        approach = largest_approach(q, step, reach, limit)
        if approach > limit and len(q) * float(np.abs(step[:, :3]).max()) < SWEPT:
            self.spans, limit = list_swept(samples, reach, self._balls, self._move_balls), np.inf
            self._listed = q[:, :3].copy()
        core = law.distance - law.overlap_limit
        part = largest_fraction(
            self._placed.points,
            self._moves,
            self._balls,
            self._move_balls,
            self.spans,
            samples,
            law.exclusion,
            core,
            share,
        )
        return part if approach <= limit else min(part, limit / approach)

    def settle(self) -> tuple[Memory, float]:
        """Accept the placed samples as an equilibrium; return what friction remembers, and its work."""
        law = self._law
        count = len(self._base)
        key = self.touching.a * count + self.touching.b
        # Pairs that came apart do work too.
        pairs = grouped(np.union1d(self._memory.key, key), count, self._m)
        state = recall(self._memory, pairs, self._base, self._lead)
        lag(self._placed, pairs, self._samples.length, law, state)
        return settle(self._placed, self._base, pairs, law, state, self._lead)
