"""The stiffness of a specimen in 4 x 4 blocks: its pattern, its factor, and what is solved with it."""

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.contact.bonds import Bonds
from knitlab_core.contact.pairs import Candidates
from knitlab_core.equilibrium.links import Links
from knitlab_core.equilibrium.pattern import fix_unknowns, free_only, make_pattern, multiply
from knitlab_core.equilibrium.stopwatch import Stopwatch
from knitlab_core.equilibrium.ties import Folding, Ties, fold, gather, make_folding, spread
from knitlab_core.sparse.blocks import Pattern
from knitlab_core.sparse.cholesky import BlockCholesky

SMALLEST_SHIFT = 1e-8
LARGEST_SHIFT = 1e6
SHIFT_DECAY = 64.0
SHIFT_GROWTH = 10.0


class Stiffness:
    """Blocks of a symmetric stiffness that are assembled, factored with fixed unknowns held, and solved with.

    Parameters
    ----------
    fixed : (N, 4) bool array
        Unknowns that are prescribed.
    clock : Stopwatch
        Where time and factorisations are counted.
    ties : Ties, optional
        Nodes that are images of others; vectors that are solved for have their motions too.

    Attributes
    ----------
    pattern : Pattern
        Which blocks there are.
    blocks : (B, 4, 4) array
        The blocks.
    shift : float
        Shift of the diagonal in the last factor [E r].
    """

    pattern: Pattern

    def __init__(self, fixed: BoolArray, clock: Stopwatch, ties: Ties | None = None) -> None:
        self._fixed, self._clock, self._ties = fixed, clock, ties
        self._folding: Folding | None = None
        self._folded = np.zeros((0, 4, 4))
        self._linear: BlockCholesky | None = None
        self._pull: tuple[FloatArray, BlockCholesky] | None = None
        self._whole = False
        self.blocks = np.zeros((0, 4, 4))
        self.shift = 0.0

    @property
    def analysed(self) -> bool:
        """Return whether there is a pattern."""
        return self._linear is not None

    def analyse(self, q: FloatArray, near: Candidates, bonds: Bonds | None, links: Links | None = None) -> None:
        """Make the pattern of rods, sample pairs, bonds and links, and an order of elimination by places `q`."""
        self.pattern = make_pattern(len(q), near, bonds, links)
        if self._ties is None:
            self._linear = BlockCholesky(self.pattern, q[:, :3])
        else:
            self._folding = make_folding(self._ties, self.pattern)
            folded = self._folding.pattern
            self._linear = BlockCholesky(folded, q[self._ties.kept, :3])
            self._folded = np.zeros((folded.rows.size, 4, 4))
        self.blocks = np.zeros((self.pattern.rows.size, 4, 4))

    def clear(self) -> FloatArray:
        """Set all blocks to zero, to be assembled; return them."""
        self.blocks[:] = 0.0
        self._whole = True
        return self.blocks

    def times(self, v: FloatArray) -> FloatArray:
        """Return K v (N, 4) with rows and columns of fixed unknowns, which the factor drops.

        Raises
        ------
        RuntimeError
            If they have been dropped.
        """
        if not self._whole:
            msg = "the stiffness has been factored: assemble it again"
            raise RuntimeError(msg)
        out = np.zeros_like(v)
        multiply(self.pattern, self.blocks, v, out)
        if self._ties is not None:
            gather(self._ties, out)
        return out

    def pull(self, motion: FloatArray) -> FloatArray:
        """Return what a motion (N, 4) of the fixtures pulls at the free unknowns; it is kept for `response`."""
        pull = self.times(motion)
        free_only(self._fixed, pull)
        if self._linear is not None:
            self._pull = pull, self._linear
        return pull

    def response(self, motion: FloatArray) -> FloatArray | None:
        """Return the linear response (N, 4) to the motion whose pull was kept; None where the factor is another's."""
        if self._pull is None or self.shift > 0.0 or self._pull[1] is not self._linear:
            return None
        return motion - self.solve(self._pull[0])

    def factor(self, least: float = 0.0) -> bool:
        """Factor the stiffness of the free unknowns, shifted as little as makes it positive, but by `least`.

        Returns False where no shift does.
        """
        if self._linear is None:
            return False
        shift = self.shift / SHIFT_DECAY
        if shift < SMALLEST_SHIFT:
            shift = 0.0
        shift = max(shift, least)
        with self._clock("factor"):
            blocks = self._held()
            while True:
                self._clock.factorisations += 1
                if self._linear.factor(blocks, shift):
                    self.shift = shift
                    return True
                shift = max(SHIFT_GROWTH * shift, SMALLEST_SHIFT)
                if not shift < LARGEST_SHIFT:
                    self.shift = 0.0
                    return False

    def _held(self) -> FloatArray:
        """Return the blocks of the unknowns that are solved for, with fixed ones held."""
        if self._ties is None or self._folding is None:
            fix_unknowns(self.pattern, self._fixed, self.blocks)
            self._whole = False
            return self.blocks
        fold(self._folding, self.blocks, self._folded)
        fix_unknowns(self._folding.pattern, self._fixed[self._ties.kept], self._folded)
        return self._folded

    def solve(self, b: FloatArray) -> FloatArray:
        """Return K^-1 b (N, 4) for the last factor; `b` must vanish at fixed unknowns, and counts for no images.

        Raises
        ------
        RuntimeError
            If nothing has been factored.
        """
        if self._linear is None:
            msg = "factor before solving"
            raise RuntimeError(msg)
        with self._clock("solve"):
            if self._ties is None:
                return self._linear.solve(b)
            x = np.zeros_like(b)
            x[self._ties.kept] = self._linear.solve(b[self._ties.kept])
            spread(self._ties, x)
            return x
