"""Everything an equilibrium search keeps between iterations: pairs, pattern, blocks, factor."""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.forces import PairState, contact_energy, contact_gradient, lag
from knitlab_core.contact.friction import STEADY, Lead, Memory, add_load_coupling, recall, settle, step_law
from knitlab_core.contact.neighbours import Candidates, find_candidates, largest_approach, largest_fraction
from knitlab_core.contact.samples import sample_points
from knitlab_core.contact.slip import Placed, material_frames, place_edges
from knitlab_core.contact.stiffness import contact_hessian
from knitlab_core.equilibrium.carried import Carried
from knitlab_core.equilibrium.cholesky import BlockCholesky
from knitlab_core.equilibrium.fused import Fused
from knitlab_core.equilibrium.model import Model
from knitlab_core.equilibrium.pattern import fix_unknowns, make_pattern, multiply, update_pattern
from knitlab_core.equilibrium.poles import PoleMemory, Poles
from knitlab_core.equilibrium.stopwatch import Cost, Stopwatch
from knitlab_core.rods.blocks import Pattern
from knitlab_core.rods.energies import rod_energy, rod_gradient
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.rods.stiffness import rod_hessian

SKIN = 0.6
"""Extra distance within which pairs are candidates [r]."""

PATTERN_SKIN = 1.0
"""The same for the pattern of the stiffness, which is dearer to rebuild."""

SMALLEST_SHIFT = 1e-8
LARGEST_SHIFT = 1e6
SHIFT_DECAY = 64.0
SHIFT_GROWTH = 10.0


class Workspace:
    """Buffers of one model: candidate pairs, stiffness blocks and their factor.

    Parameters
    ----------
    model : Model
        What is solved.

    Attributes
    ----------
    blocks : (B, 4, 4) array
        The assembled stiffness.
    loads : (N, 4) array
        Dead loads on the unknowns [E r^2, E r^3].
    clock : Stopwatch
        Where the time went.
    spent : Cost
        Newton iterations and factorisations so far, those of failed searches and snaps included.
    placed : Placed
        Samples and edges in the configuration last moved to.
    fused : Fused or None
        Bonds that hold; None where strands do not fuse.
    poles : Poles or None
        Hooks on poles that rub, and wires; None without either.
    drag : float
        Resistance of every node to its motion since the step began [E r], as by a viscous fluid; nought but in snaps.
    """

    candidates: Candidates
    pairs: PairState
    pattern: Pattern

    def __init__(self, model: Model) -> None:
        n = len(model.fixed)
        samples = n * len(model.samples.weights)
        self.model = model
        self.loads = np.zeros((n, 4))
        self.clock = Stopwatch()
        self.spent = Cost()
        self.placed = Placed.zeros(n, samples)
        self.fused: Fused | None = None
        self.poles = None if model.hooks is None else Poles(model.hooks, model.law.slip)
        self.drag = 0.0
        self._origin = np.zeros((n, 4))
        self._base = np.zeros((samples, 3))
        self._base_frames = np.zeros((n, 3, 3))
        self._moves = np.zeros((samples, 3))
        self._trial = Frames.zeros(n)
        self._listed = np.zeros((n, 3))
        self._memory = Memory.empty()
        self._lead = STEADY
        self._law = model.law
        self._shift = 0.0
        self._hold: FloatArray | None = None
        self._made: tuple[FloatArray, FloatArray | None] | None = None
        self._linear: BlockCholesky | None = None
        self._pull: tuple[FloatArray, BlockCholesky | None] | None = None
        self.blocks = np.zeros((0, 4, 4))

    @property
    def _parts(self) -> tuple[Fused | Poles, ...]:
        """Return what acts beside rods and contacts; poles last, whose loads are the forces of all others."""
        return tuple(part for part in (self.fused, self.poles) if part is not None)

    def start_step(
        self,
        q: FloatArray,
        frames: Frames,
        memory: Memory,
        hold: FloatArray | None = None,
        poles: PoleMemory | None = None,
        lead: Lead = STEADY,
    ) -> None:
        """Begin at an equilibrium: list its pairs and recall what friction remembers of them, and of poles.

        `hold` (B,) is the share of its stiffness that each bond has, by default all of it; `lead` how slip is
        extrapolated in the step.
        """
        self._memory, self._lead = memory, lead
        self._law = step_law(self.model.law, lead)
        self._fuse(hold)
        self._origin = q.copy()
        if self.poles is not None:
            self.poles.start(q, poles)
        sample_points(q, self.model.samples, self._base)
        material_frames(q, self.model.rods.has_edge, frames, self._base_frames)
        self._list_pairs(q)
        self.move_to(q, frames)

    def _fuse(self, hold: FloatArray | None) -> None:
        self._hold, bonds = hold, self.model.bonds
        if bonds is not None:
            bonds = bonds if hold is None else bonds.held(hold)
            self.fused = Fused(bonds, self.placed, self.model.samples.weights)

    @property
    def carried(self) -> Carried | None:
        """What is carried to the next equilibrium; None before the first. The arrays are not changed later."""
        return None if self._made is None else Carried(*self._made, self._shift)

    def go_on(self, carried: Carried) -> None:
        """Go on where another workspace of the same model stood."""
        self._fuse(carried.hold)
        self.pattern, self._shift = self._analyse(carried.q), carried.shift

    def keep_listed(self, q: FloatArray) -> bool:
        """List the pairs anew if any two strands may have approached by more than the skin; say whether."""
        with self.clock("neighbours"):
            reach = self.model.law.distance + SKIN
            spare = SKIN - self.model.law.onset
            approach = largest_approach(self._listed, q[:, :3] - self._listed, reach, spare)
        if approach > spare:
            self._list_pairs(q)
            return True
        return False

    def _list_pairs(self, q: FloatArray) -> None:
        samples, law = self.model.samples, self.model.law
        with self.clock("neighbours"):
            self.candidates = find_candidates(q, samples, law, SKIN)
            self.pairs = recall(self._memory, self.candidates, self._base, self._lead)
            self._listed = q[:, :3].copy()
        n = len(q)
        kept = None
        if self._linear is not None:
            kept = self._fit(self.pattern, n)
        if kept is None:
            kept = self._fit(self._analyse(q), n)
        if kept is None:
            msg = "a list of pairs within the wider skin must contain those within the skin"
            raise RuntimeError(msg)
        self.pattern = kept

    def _analyse(self, q: FloatArray) -> Pattern:
        """Return a pattern with room to move in about `q`, and make ready to factor it."""
        with self.clock("analyse"):
            bonds = None if self.fused is None else self.fused.bonds
            wide = make_pattern(len(q), find_candidates(q, self.model.samples, self.model.law, PATTERN_SKIN), bonds)
            self._linear = BlockCholesky(wide, q[:, :3])
            self.blocks = np.zeros((wide.rows.size, 4, 4))
            self._made = q.copy(), self._hold
            return wide

    def _fit(self, pattern: Pattern, n: int) -> Pattern | None:
        """Fit pairs and bonds into a pattern, or return None if they need blocks it lacks."""
        if not all(part.fit(pattern, n) for part in self._parts):
            return None
        return update_pattern(pattern, n, self.candidates)

    def move_to(self, q: FloatArray, frames: Frames) -> None:
        """Place samples and edges in configuration `q`."""
        sample_points(q, self.model.samples, self.placed.points)
        place_edges(q, self.model.rods.has_edge, frames, self._base_frames, self.placed)
        for part in self._parts:
            part.place(q, self.model.rods.has_edge, frames)

    def lag(self) -> int:
        """Take friction's loads from the present configuration; return the number of contacts."""
        m = self.model
        if self.poles is not None:
            self.poles.lag()
        return lag(self.placed, self.candidates, m.samples.length, self._law, self.pairs)

    def energy(self, q: FloatArray, source: Frames) -> float:
        """Return elastic, contact and friction energy less the work of dead loads; moves samples."""
        model = self.model
        with self.clock("energy"):
            follow(q, model.rods.has_edge, source, self._trial)
            elastic = sum(rod_energy(q, model.rods, self._trial))
            self.move_to(q, self._trial)
            normal, friction = contact_energy(self.placed, self.candidates, model.samples.length, self._law, self.pairs)
            total = float(elastic + normal + friction - np.vdot(self.loads, q))
            if self.drag:
                moved = q[:, :3] - self._origin[:, :3]
                total += 0.5 * self.drag * float(np.vdot(moved, moved))
            return sum((part.energy() for part in self._parts), total)

    def parts(self, q: FloatArray, frames: Frames) -> FloatArray:
        """Return stretching, bending, twisting and contact energy (4,) at the placed samples."""
        model = self.model
        normal, _ = contact_energy(self.placed, self.candidates, model.samples.length, model.law, self.pairs)
        return np.array([*rod_energy(q, model.rods, frames), normal])

    def gradient(self, q: FloatArray, frames: Frames) -> FloatArray:
        """Return the gradient (N, 4) at the placed samples, fixed unknowns included."""
        model = self.model
        with self.clock("gradient"):
            g = -self.loads
            rod_gradient(q, model.rods, frames, g)
            contact_gradient(self.placed, self.candidates, model.samples, self._law, self.pairs, g)
            if self.drag:
                g[:, :3] += self.drag * (q[:, :3] - self._origin[:, :3])
            for part in self._parts:
                part.add_gradient(g)
        return g

    def assemble(self, q: FloatArray, frames: Frames, *, contacts: float = 1.0) -> None:
        """Assemble the stiffness at the placed samples, fixed unknowns still included.

        Parameters
        ----------
        q : (N, 4) array
            Positions and edge angles.
        frames : Frames
            Their frames.
        contacts : float
            Weight of the second derivatives of distance and slip: without them contacts only add stiffness.
        """
        model = self.model
        with self.clock("assembly"):
            self.blocks[:] = 0.0
            rod_hessian(q, model.rods, frames, 1.0, self.pattern, self.blocks)
            pairs, pattern = self.pairs, self.pattern
            listed = self.candidates
            contact_hessian(self.placed, listed, model.samples, self._law, contacts, pairs, pattern, self.blocks)
            if self.drag:
                self.blocks[self.pattern.diagonal[:, None], range(3), range(3)] += self.drag
            for part in self._parts:
                part.add_hessian(contacts, self.blocks)

    def stiffness_times(self, v: FloatArray) -> FloatArray:
        """Return K v for the assembled stiffness; call before `factor`."""
        out = np.zeros_like(v)
        multiply(self.pattern, self.blocks, v, out)
        return out

    def count_iteration(self) -> None:
        """Count one Newton iteration."""
        self.spent += Cost(iterations=1)

    def keep_pull(self, motion: FloatArray) -> None:
        """Keep what a motion (N, 4) of the fixtures pulls at the free unknowns; call between assembly and factor."""
        pull = self.stiffness_times(motion)
        pull[self.model.fixed] = 0.0
        self._pull = pull, self._linear

    def response(self, motion: FloatArray) -> FloatArray | None:
        """Return the linear response (N, 4) to the motion whose pull was kept; None where the factor is another's."""
        if self._pull is None or self._shift > 0.0 or self._pull[1] is not self._linear:
            return None
        return motion - self.solve(self._pull[0])

    def factor(self, least: float = 0.0) -> bool:
        """Factor the stiffness of the free unknowns, shifted as little as makes it positive, but by `least`."""
        if self._linear is None:
            return False
        shift = self._shift / SHIFT_DECAY
        if shift < SMALLEST_SHIFT:
            shift = 0.0
        shift = max(shift, least)
        with self.clock("factor"):
            fix_unknowns(self.pattern, self.model.fixed, self.blocks)
            while True:
                self.spent += Cost(factorisations=1)
                if self._linear.factor(self.blocks, shift):
                    self._shift = shift
                    return True
                shift = max(SHIFT_GROWTH * shift, SMALLEST_SHIFT)
                if not shift < LARGEST_SHIFT:
                    self._shift = 0.0
                    return False

    @property
    def shift(self) -> float:
        """Shift of the last factorisation [E r]."""
        return self._shift

    def solve(self, b: FloatArray) -> FloatArray:
        """Return K^-1 b for the last factored stiffness; `b` must vanish at fixed unknowns."""
        if self._linear is None:
            msg = "factor before solving"
            raise RuntimeError(msg)
        with self.clock("solve"):
            return self._linear.solve(b)

    def load_coupling(self, v: FloatArray) -> FloatArray:
        """Return the change of the free forces by friction's loads when the strands move by `v`."""
        model = self.model
        out = np.zeros_like(v)
        add_load_coupling(self.placed.points, self.candidates, model.samples, self._law, self.pairs, v, out)
        if self.poles is not None:
            self.poles.add_load_coupling(v, out)
        out[model.fixed] = 0.0
        return out

    def room(self, q: FloatArray, step: FloatArray, share: float) -> float:
        """Return the largest fraction of a step in which no strands can pass through each other.

        Call with samples placed at `q`. Candidates use at most `share` of the
        way to their neighbour's core; others are farther than contact plus skin.
        """
        model = self.model
        with self.clock("neighbours"):
            sample_points(step, model.samples, self._moves)
            part = largest_fraction(self.placed.points, self._moves, self.candidates, model.law, share)
            reach = model.law.distance + SKIN
            used = largest_approach(self._listed, q[:, :3] - self._listed, reach, 0.1)
            limit = SKIN + model.law.overlap_limit - used
            approach = largest_approach(q, step, reach, limit)
        return part if approach <= limit else min(part, limit / approach)

    def settle(self) -> tuple[Memory, PoleMemory, float]:
        """Accept the placed samples as an equilibrium; return what friction remembers, and its work."""
        memory, work = settle(self.placed, self._base, self.candidates, self.model.law, self.pairs, self._lead)
        if self.poles is None:
            return memory, PoleMemory.empty(), work
        poles, rubbed = self.poles.settle()
        return memory, poles, work + rubbed
