"""Everything an equilibrium search keeps between iterations: pairs, pattern, blocks, factor."""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.friction import STEADY, Lead, Memory, step_law
from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.contact.samples import sample_points
from knitlab_core.contact.slip import Placed, material_frames, place_edges
from knitlab_core.equilibrium.carried import Carried
from knitlab_core.equilibrium.contacts import Contacts
from knitlab_core.equilibrium.fused import Fused
from knitlab_core.equilibrium.hook_friction import PoleMemory, Poles
from knitlab_core.equilibrium.model import Model
from knitlab_core.equilibrium.pattern import fix_unknowns, free_only, make_pattern, multiply
from knitlab_core.equilibrium.stopwatch import Stopwatch
from knitlab_core.rods.energies import rod_energy, rod_gradient
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.rods.stiffness import add_rod_hessian, rod_hessian
from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.cholesky import BlockCholesky
from knitlab_core.sparse.gmres import make_basis, solve_coupled
from knitlab_core.sparse.sums import inner
from knitlab_core.threads import both

PATTERN_SKIN = 1.0
"""Extra distance within which sample pairs have blocks in the stiffness [r]: blocks that stay empty cost time too."""

HALVES_FROM = 4000
"""Nodes from which rods are assembled in halves: below, waiting for a thread on a busy machine costs what it saves."""

SMALLEST_SHIFT = 1e-8
LARGEST_SHIFT = 1e6
SHIFT_DECAY = 64.0
SHIFT_GROWTH = 10.0


class Workspace:
    """Buffers of one model: pairs in contact, stiffness blocks and their factor.

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
        Where the time went, and all iterations and factorisations, those of failed searches and snaps included.
    placed : Placed
        Samples and edges in the configuration last moved to.
    contacts : Contacts
        Pairs of samples that touch or rub.
    fused : Fused or None
        Bonds that hold; None where strands do not fuse.
    poles : Poles or None
        Hooks on poles that rub, and wires; None without either.
    drag : float
        Resistance of every node to its motion since the step began [E r], as by a viscous fluid; zero but in snaps.
    """

    pattern: Pattern

    def __init__(self, model: Model) -> None:
        n = len(model.fixed)
        samples = n * len(model.samples.weights)
        self.model = model
        self.loads = np.zeros((n, 4))
        self.clock = Stopwatch()
        self.placed = Placed.zeros(n, samples)
        self.contacts = Contacts(self.placed, model.samples)
        self.fused: Fused | None = None
        self.poles = None if model.hooks is None else Poles(model.hooks, model.law.slip)
        self.drag = 0.0
        self._origin = np.zeros((n, 4))
        self._base_frames = np.zeros((n, 3, 3))
        self._trial = Frames.zeros(n)
        self._basis = make_basis(4 * n)
        self._law = model.law
        self._pull: tuple[FloatArray, BlockCholesky | None] | None = None
        self._shift = 0.0
        self._hold: FloatArray | None = None
        self._made: tuple[FloatArray, FloatArray | None] | None = None
        self._linear: BlockCholesky | None = None
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
        """Begin at an equilibrium: list what is near and recall what friction remembers of them, and of poles.

        `hold` (B,) is the share of its stiffness that each bond has, by default all of it; `lead` how slip is
        extrapolated in the step.
        """
        self._law = step_law(self.model.law, lead)
        self._fuse(hold)
        self._origin = q.copy()
        if self.poles is not None:
            self.poles.start(q, poles)
        material_frames(q, self.model.rods.has_edge, frames, self._base_frames)
        with self.clock("neighbours"):
            self.contacts.start(q, memory, self.model.law, lead)
        if self._linear is None or not self._parts_fit():
            self._analyse(q)
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
        self._analyse(carried.q)
        self._shift = carried.shift

    def keep_listed(self, q: FloatArray) -> bool:
        """List what is near again if strands may have approached by much of the skin; say whether. Forces stay."""
        with self.clock("neighbours"):
            return self.contacts.keep_listed(q, self.model.law)

    def _analyse(self, q: FloatArray) -> None:
        """Make a pattern with room to move in about `q`, and make ready to factor it."""
        with self.clock("analyse"):
            bonds = None if self.fused is None else self.fused.bonds
            near = find_candidates(q, self.model.samples, self.model.law, PATTERN_SKIN)
            self.pattern = make_pattern(len(q), near, bonds)
            self._linear = BlockCholesky(self.pattern, q[:, :3])
            self.blocks = np.zeros((self.pattern.rows.size, 4, 4))
            self._made = q.copy(), self._hold
        if not self._parts_fit():
            msg = "a pattern made for bonds must contain them"
            raise RuntimeError(msg)

    def _parts_fit(self) -> bool:
        """Fit bonds and poles into the pattern; return False if they need blocks it lacks."""
        return all(part.fit(self.pattern, len(self.model.fixed)) for part in self._parts)

    def move_to(self, q: FloatArray, frames: Frames) -> None:
        """Place samples and edges in configuration `q`, and find what touches there."""
        with self.clock("pairs"):
            sample_points(q, self.model.samples, self.placed.points)
            place_edges(q, self.model.rods.has_edge, frames, self._base_frames, self.placed)
            self.contacts.place(q, self.model.law)
            for part in self._parts:
                part.place(q, self.model.rods.has_edge, frames)

    def lag(self) -> int:
        """Take friction's loads from the present configuration; return the number of contacts."""
        with self.clock("friction"):
            if self.poles is not None:
                self.poles.lag()
            return self.contacts.lag(self._law)

    def energy(self, q: FloatArray, source: Frames) -> float:
        """Return elastic, contact and friction energy less the work of dead loads; moves samples."""
        model = self.model
        with self.clock("energy"):
            follow(q, model.rods.has_edge, source, self._trial)
            elastic = sum(rod_energy(q, model.rods, self._trial))
            self.move_to(q, self._trial)
            total = elastic + self.contacts.energy(self._law) - inner(self.loads, q)
            if self.drag:
                moved = q[:, :3] - self._origin[:, :3]
                total += 0.5 * self.drag * inner(moved, moved)
            return sum((part.energy() for part in self._parts), total)

    def parts(self, q: FloatArray, frames: Frames) -> FloatArray:
        """Return stretching, bending, twisting and contact energy (4,) at the placed samples."""
        return np.array([*rod_energy(q, self.model.rods, frames), self.contacts.normal_energy(self.model.law)])

    def gradient(self, q: FloatArray, frames: Frames) -> FloatArray:
        """Return the gradient (N, 4) at the placed samples, fixed unknowns included."""
        model = self.model
        with self.clock("gradient"):
            g = -self.loads
            rod_gradient(q, model.rods, frames, g)
            self.contacts.add_gradient(self._law, g)
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
        if not self.contacts.fits(self.pattern):
            self._analyse(q)
            self.contacts.part(self.pattern)
        with self.clock("assembly"):
            self.blocks[:] = 0.0
            self._add_rods(q, frames)
            self.contacts.add_hessian(self._law, contacts, self.pattern, self.blocks)
            if self.drag:
                self.blocks[self.pattern.diagonal[:, None], range(3), range(3)] += self.drag
            for part in self._parts:
                part.add_hessian(contacts, self.blocks)

    def _add_rods(self, q: FloatArray, frames: Frames) -> None:
        """Add the rods' stiffness to the blocks; in two halves that share no block, then the nodes between them."""
        if len(q) < HALVES_FROM:
            rod_hessian(q, self.model.rods, frames, 1.0, self.pattern, self.blocks)
            return
        rods, middle = self.model.rods, len(q) // 2

        def add(first: int, last: int) -> None:
            add_rod_hessian(q, rods, frames, 1.0, self.pattern, self.blocks, first, last)

        # A span acts on its two neighbours.
        both(lambda: add(0, middle), lambda: add(middle + 2, len(q)))
        add(middle, middle + 2)

    def stiffness_times(self, v: FloatArray) -> FloatArray:
        """Return K v for the assembled stiffness; call before `factor`."""
        out = np.zeros_like(v)
        multiply(self.pattern, self.blocks, v, out)
        return out

    def count_iteration(self) -> None:
        """Count one Newton iteration."""
        self.clock.iterations += 1

    def keep_pull(self, motion: FloatArray) -> None:
        """Keep what a motion (N, 4) of the fixtures pulls at the free unknowns; call between assembly and factor."""
        pull = self.stiffness_times(motion)
        free_only(self.model.fixed, pull)
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
                self.clock.factorisations += 1
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
        out = np.zeros_like(v)
        with self.clock("coupling"):
            self.contacts.add_load_coupling(self._law, v, out)
            if self.poles is not None:
                self.poles.add_load_coupling(v, out)
            free_only(self.model.fixed, out)
        return out

    def solve_coupled(self, step: FloatArray, tolerance: float) -> FloatArray:
        """Return a Newton step (N, 4) that brings friction's loads along, of the one that holds them.

        `tolerance` is that of its residual, relative to `step`.
        """
        with self.clock("coupling"):
            return solve_coupled(lambda v: self.solve(self.load_coupling(v)), step, tolerance, self._basis)

    def room(self, q: FloatArray, step: FloatArray, share: float) -> float:
        """Return the largest fraction of a step in which no strands can pass through each other.

        Call with samples placed at `q`. Pairs use at most `share` of the way to their neighbour's core.
        """
        with self.clock("neighbours"):
            return self.contacts.room(q, step, share, self.model.law)

    def settle(self) -> tuple[Memory, PoleMemory, float]:
        """Accept the placed samples as an equilibrium; return what friction remembers, and its work."""
        with self.clock("friction"):
            memory, work = self.contacts.settle(self.model.law)
            if self.poles is None:
                return memory, PoleMemory.empty(), work
            poles, rubbed = self.poles.settle()
            return memory, poles, work + rubbed
