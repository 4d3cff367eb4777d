"""Everything an equilibrium search keeps between iterations: the terms of the energy, the stiffness, the clock."""

import numpy as np

from knitlab_core.arrays import FloatArray
from knitlab_core.contact.friction import STEADY, Lead, Memory
from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.contact.samples import sample_points
from knitlab_core.contact.slip import Placed, material_frames, place_edges
from knitlab_core.equilibrium.bonds import BondTerm
from knitlab_core.equilibrium.contacts import ContactTerm
from knitlab_core.equilibrium.hook_friction import HookTerm, PoleMemory
from knitlab_core.equilibrium.links import LinkTerm
from knitlab_core.equilibrium.model import Model
from knitlab_core.equilibrium.solver_state import SolverState
from knitlab_core.equilibrium.stiffness import Stiffness
from knitlab_core.equilibrium.stopwatch import Stopwatch
from knitlab_core.equilibrium.terms import DeadLoads, Drag, RodTerm, Term
from knitlab_core.equilibrium.ties import gather
from knitlab_core.rods.frames import Frames, follow
from knitlab_core.sparse.gmres import make_basis

PATTERN_SKIN = 1.0
"""Extra distance within which sample pairs have blocks in the stiffness [r]: blocks that stay empty cost time too."""


class Workspace:
    """Buffers of one model. What is computed is that of the configuration last placed: `move_to`, `energy`.

    Parameters
    ----------
    model : Model
        What is solved.
    clock : Stopwatch, optional
        That of a workspace whose place it takes; by default one of its own.

    Attributes
    ----------
    rods, contacts, bonds, links, hooks, dead, drag : Term
        Terms of the energy; None where strands do not fuse, nothing is linked, hooks neither rub nor are wires, and
        where nothing drags.
        `dead.loads` (N, 4) may be written to.
    stiffness : Stiffness
        Second derivatives of all terms.
    clock : Stopwatch
        Where the time went, and all iterations and factorisations, those of failed searches and snaps included.
    placed : Placed
        Samples and edges in the configuration last placed.
    """

    def __init__(self, model: Model, clock: Stopwatch | None = None) -> None:
        n = len(model.fixed)
        self.model, self.clock = model, Stopwatch() if clock is None else clock
        self.placed = Placed.zeros(n, n * len(model.samples.weights))
        self.rods, self.dead = RodTerm(model.rods), DeadLoads(n)
        self.contacts = ContactTerm(self.placed, model.samples, model.law, self.clock)
        self.hooks = None if model.hooks is None else HookTerm(model.hooks, model.law.slip)
        self.bonds: BondTerm | None = None
        self.links = None if model.links is None else LinkTerm(model.links)
        self.drag: Drag | None = None
        self.stiffness = Stiffness(model.fixed, self.clock, model.ties)
        self.basis = make_basis(4 * n)  # of Krylov vectors, for `coupling`
        self._base_frames, self._trial = np.zeros((n, 3, 3)), Frames.zeros(n)
        self._hold: FloatArray | None = None
        self._made: tuple[FloatArray, FloatArray | None] | None = None

    @property
    def terms(self) -> list[Term]:
        """Return the terms in the order of their sums; hooks last, whose loads are the forces of all others."""
        terms = (self.rods, self.contacts, self.dead, self.drag, self.bonds, self.links, self.hooks)
        return [term for term in terms if term is not None]

    def start_step(
        self,
        q: FloatArray,
        frames: Frames,
        memory: Memory,
        hold: FloatArray | None = None,
        poles: PoleMemory | None = None,
        lead: Lead = STEADY,
        *,
        rods: RodTerm | None = None,
        drag: float = 0.0,
    ) -> None:
        """Begin at an equilibrium: list what is near and recall what friction remembers of it; place it.

        `hold` (B,) is the share of its stiffness that each bond has, by default all of it; `lead` how slip is
        extrapolated in the step; `rods` those of the step, by default the model's; `drag` its resistance [E r].
        """
        model = self.model
        self.rods = RodTerm(model.rods) if rods is None else rods
        self.drag = Drag(drag, q) if drag else None
        self._fuse(hold)
        if self.hooks is not None:
            self.hooks.start(q, poles)
        material_frames(q, model.rods.has_edge, frames, self._base_frames)
        self.contacts.start(q, memory, lead)
        if not (self.stiffness.analysed and self._terms_fit()):
            self._analyse(q)
        self.move_to(q, frames)

    def _fuse(self, hold: FloatArray | None) -> None:
        self._hold, bonds = hold, self.model.bonds
        if bonds is not None:
            bonds = bonds if hold is None else bonds.held(hold)
            self.bonds = BondTerm(bonds, self.placed, self.model.samples.weights, self.model.rods.has_edge)

    @property
    def solver_state(self) -> SolverState | None:
        """What is carried to the next equilibrium; None before the first. The arrays are not changed later."""
        return None if self._made is None else SolverState(*self._made, self.stiffness.shift)

    def restore(self, state: SolverState) -> None:
        """Take the place of another workspace of the same model, to the last bit."""
        self._fuse(state.hold)
        self._analyse(state.q)
        self.stiffness.shift = state.shift

    def _analyse(self, q: FloatArray) -> None:
        """Make a pattern with room to move in about `q`, and make ready to factor it."""
        with self.clock("analyse"):
            near = find_candidates(q, self.model.samples, self.model.law, PATTERN_SKIN)
            bonds = None if self.bonds is None else self.bonds.bonds
            self.stiffness.analyse(q, near, bonds, self.model.links)
            self._made = q.copy(), self._hold
        self._terms_fit()

    def _terms_fit(self) -> bool:
        """Give the pattern to all terms; return False if bonds lack blocks in it. Contacts are fitted as they come."""
        return all(term.fits(self.stiffness.pattern) for term in self.terms if term is not self.contacts)

    def move_to(self, q: FloatArray, frames: Frames) -> None:
        """Place samples, edges and all terms in a configuration, and find what touches there."""
        with self.clock("pairs"):
            sample_points(q, self.model.samples, self.placed.points)
            place_edges(q, self.model.rods.has_edge, frames, self._base_frames, self.placed)
            for term in self.terms:
                term.place(q, frames)

    def lag(self) -> int:
        """Take friction's loads from the configuration; return the number of contacts."""
        with self.clock("friction"):
            if self.hooks is not None:
                self.hooks.lag()
            return self.contacts.lag()

    def energy(self, q: FloatArray, source: Frames) -> float:
        """Place a configuration whose frames follow from those of another, and return its energy [E r^3]."""
        with self.clock("energy"):
            follow(q, self.model.rods.has_edge, source, self._trial)
            self.move_to(q, self._trial)
            return sum(term.energy() for term in self.terms)

    def gradient(self) -> FloatArray:
        """Return the gradient of the energy (N, 4), fixed unknowns included; that of images is at what they follow."""
        g = np.zeros((len(self.model.fixed), 4))
        with self.clock("gradient"):
            for term in self.terms:
                term.add_gradient(g)
            if self.model.ties is not None:
                gather(self.model.ties, g)
        return g

    def assemble(self, *, exact: float = 1.0) -> None:
        """Assemble the stiffness, fixed unknowns included; without `exact` derivatives contacts only add stiffness."""
        stiffness = self.stiffness
        if not self.contacts.fits(stiffness.pattern):
            self._analyse(self.rods.q)
            self.contacts.drop_far_pairs(stiffness.pattern)
        with self.clock("assembly"):
            blocks = stiffness.clear()
            for term in self.terms:
                term.add_hessian(exact, blocks)

    def settle(self) -> tuple[Memory, PoleMemory, float]:
        """Accept the configuration as an equilibrium; return what friction remembers, and its work."""
        with self.clock("friction"):
            memory, work = self.contacts.settle()
            poles, rubbed = (PoleMemory.empty(), 0.0) if self.hooks is None else self.hooks.settle()
            return memory, poles, work + rubbed
