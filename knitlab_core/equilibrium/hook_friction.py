"""Hooks that slide along poles in one step: what holds a wire together, and friction between hook and pole.

A hook is a pin, one node of the yarn, or the rigid wires through a loop, strands of their own whose nodes are
prescribed but for their coordinate along the pole. Springs tie these to each other, so that wires go along the pole
as one. Friction is Coulomb's with memory, as between strands: with s what a hook has slid since the last equilibrium
and xi the elastic slip from before, it stores mu load Huber(xi + s; eps); the load is the hook's pull across the pole.
"""

from typing import NamedTuple, Self

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.contact.friction_law import friction_law
from knitlab_core.equilibrium.pattern import multiply
from knitlab_core.sparse.blocks import Pattern

TIE = 100.0
"""Stiffness between neighbouring nodes of a wire, along the pole [E r]: they part by 1e-4 r at the largest forces."""

DRAG = 1e-6
"""Stiffness with which a wire keeps its place from step to step [E r]: one that touches nothing stays there."""


class Hooks(NamedTuple):
    """What slides along poles.

    `nodes`: (n,) nodes of all hooks, hook by hook, and `hook`: (n,) the hook of each; `pull`, `pole`: (H,)
    coordinates that a hook's carriage drives, and along which it slides; `slider`: (H,) node at which the pole
    holds it; `friction`: (H,) coefficient between hook and pole; `tied`: (T,) nodes of wires that go along the
    pole with the node before, and `apart`: (T,) how far ahead of it [r].
    """

    nodes: IndexArray
    hook: IndexArray
    pull: IndexArray
    pole: IndexArray
    slider: IndexArray
    friction: FloatArray
    tied: IndexArray
    apart: FloatArray

    @property
    def rubs(self) -> bool:
        """Return whether any pole has friction."""
        return bool((self.friction > 0.0).any())


class PoleMemory(NamedTuple):
    """What hooks had at the last equilibrium: `slip` (H,) elastic slip [r] and `load` (H,) across the pole [E r^2]."""

    slip: FloatArray
    load: FloatArray

    @classmethod
    def empty(cls) -> Self:
        """Remember nothing: no hook has been pulled, or none slides along a pole."""
        return cls(np.zeros(0), np.zeros(0))


def pole_forces(hooks: Hooks, memory: PoleMemory, limit: float) -> FloatArray:
    """Return the force (H,) of each hook along its pole at an equilibrium [E r^2]; `limit` as in `HookTerm`."""
    return hooks.friction * memory.load * memory.slip / limit


class HookTerm:
    """Hooks on their poles, between two equilibria.

    Parameters
    ----------
    hooks : Hooks
        The hooks.
    limit : float
        Elastic slip before sliding [r].
    """

    def __init__(self, hooks: Hooks, limit: float) -> None:
        self.hooks = hooks
        self._limit = limit
        self._along = hooks.pole[hooks.hook]
        place = np.zeros(int(hooks.nodes.max()) + 1, dtype=np.int64)
        place[hooks.nodes] = self._along
        self._tie_pole = place[hooks.tied]
        # Only wires are dragged: a pin goes where its yarn goes.
        self._is_wire = np.bincount(hooks.hook) > 1
        self._due = False
        self._load = np.zeros(hooks.slider.size)
        self._pull = np.zeros(hooks.slider.size)

    def start(self, q: FloatArray, memory: PoleMemory | None) -> None:
        """Begin at an equilibrium."""
        hooks = self.hooks
        nothing = np.zeros(hooks.slider.size)
        slip, load = (nothing, nothing) if memory is None or not memory.slip.size else memory
        self._base = q[hooks.slider, hooks.pole]
        self._before = slip
        self._start_load = load
        self._load = load.copy()

    def fits(self, pattern: Pattern) -> bool:
        """Take a pattern of the stiffness, which has all blocks of nodes that follow each other."""
        self._pattern = pattern
        return True

    def place(self, q: FloatArray, *_: object) -> None:
        """Move the hooks to configuration `q`."""
        hooks = self.hooks
        self._slid = q[hooks.slider, hooks.pole] - self._base
        self._slip = self._before + self._slid
        self._parted = q[hooks.tied, self._tie_pole] - q[hooks.tied - 1, self._tie_pole] - hooks.apart

    def lag(self) -> None:
        """Take the loads from the next forces that are computed."""
        self._due = self.hooks.rubs

    def energy(self) -> float:
        """Return what ties and friction store [E r^3]."""
        stored, _, _ = self._law()
        rubbing = np.sum(self.hooks.friction * self._load * stored)
        return float(
            rubbing + 0.5 * TIE * np.sum(self._parted**2) + 0.5 * DRAG * np.sum(self._slid[self._is_wire] ** 2)
        )

    def add_gradient(self, gradient: FloatArray) -> None:
        """Add the forces along the poles to a gradient (N, 4) that has all others."""
        hooks = self.hooks
        if self._due:
            self._pull = self._sum(gradient)
            self._load = np.abs(self._pull)
            self._due = False
        force = hooks.friction * self._load * self._direction() + DRAG * self._is_wire * self._slid
        np.add.at(gradient, (hooks.slider, hooks.pole), force)
        tension = TIE * self._parted
        np.add.at(gradient, (hooks.tied, self._tie_pole), tension)
        np.add.at(gradient, (hooks.tied - 1, self._tie_pole), -tension)

    def _sum(self, forces: FloatArray) -> FloatArray:
        """Return the pull (H,) of forces (N, 4) on each hook across its pole."""
        hooks = self.hooks
        pull: FloatArray = np.zeros(hooks.slider.size)
        np.add.at(pull, hooks.hook, forces[hooks.nodes, hooks.pull[hooks.hook]])
        return pull

    def _direction(self) -> FloatArray:
        """Return friction's share of its limit (H,), from -1 to 1."""
        _, over, _ = self._law()
        direction: FloatArray = self._slip * over
        return direction

    def _law(self) -> FloatArray:
        """Return what `friction_law` says of every hook, (3, H)."""
        law: FloatArray = np.empty((3, self._slip.size))
        for hook, slip in enumerate(self._slip.tolist()):
            law[:, hook] = friction_law(abs(slip), self._limit)
        return law

    def add_hessian(self, _: float, blocks: FloatArray) -> None:
        """Add the stiffness along the poles to the blocks, and keep what the pulls depend on."""
        hooks, pattern = self.hooks, self._pattern
        _, _, along = self._law()
        stiffness = hooks.friction * self._load * along + DRAG * self._is_wire
        np.add.at(blocks, (pattern.diagonal[hooks.slider], hooks.pole, hooks.pole), stiffness)
        i, c = hooks.tied, self._tie_pole
        np.add.at(blocks, (pattern.diagonal[i], c, c), TIE)
        np.add.at(blocks, (pattern.diagonal[i - 1], c, c), TIE)
        np.add.at(blocks, (pattern.below[i], c, c), -TIE)
        if hooks.rubs:
            held = np.zeros(pattern.diagonal.size, dtype=np.bool_)
            held[hooks.nodes] = True
            about = np.flatnonzero(held[pattern.rows] | held[pattern.columns])
            self._pulls = pattern._replace(rows=pattern.rows[about], columns=pattern.columns[about]), blocks[about]

    def add_load_coupling(self, v: FloatArray, out: FloatArray) -> None:
        """Add to `out` (N, 4) how friction changes because a motion `v` (N, 4) changes the pulls."""
        hooks = self.hooks
        if not hooks.rubs:
            return
        forces = np.zeros_like(v)
        multiply(*self._pulls, v, forces)
        force = hooks.friction * np.sign(self._pull) * self._sum(forces) * self._direction()
        np.add.at(out, (hooks.slider, hooks.pole), force)

    def settle(self) -> tuple[PoleMemory, float]:
        """Accept an equilibrium; return what hooks remember and the work against friction (trapezium rule)."""
        slip = self._limit * self._direction()
        # The slip carried from before is what pulled at first.
        mean = 0.5 * self.hooks.friction * (self._start_load * self._before + self._load * slip) / self._limit
        return PoleMemory(slip, self._load.copy()), float(np.sum(mean * self._slid))

    def fixture_forces(self, gradient: FloatArray, held: BoolArray) -> FloatArray:
        """Return the sizes (n,) of what fixtures exert at held coordinates (N, 3): on a wire, all of it together."""
        hooks = self.hooks
        single = held.copy()
        single[hooks.nodes[self._is_wire[hooks.hook]]] = False
        sums = np.zeros((hooks.slider.size, 3))
        np.add.at(sums, hooks.hook, gradient[hooks.nodes, :3])
        whole = held[hooks.slider] & self._is_wire[:, None]
        sizes: FloatArray = np.abs(np.concatenate([gradient[:, :3][single], sums[whole]]))
        return sizes
