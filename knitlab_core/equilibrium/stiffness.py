"""The stiffness of a specimen in 4 x 4 blocks: its pattern, its factor, and what is solved with it."""

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.contact.bonds import Bonds
from knitlab_core.contact.pairs import Candidates
from knitlab_core.equilibrium.pattern import fix_unknowns, free_only, make_pattern, multiply
from knitlab_core.equilibrium.stopwatch import Stopwatch
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

    def __init__(self, fixed: BoolArray, clock: Stopwatch) -> None:
        self._fixed, self._clock = fixed, clock
        self._linear: BlockCholesky | None = None
        self._pull: tuple[FloatArray, BlockCholesky] | None = None
        self._whole = False
        self.blocks = np.zeros((0, 4, 4))
        self.shift = 0.0

    @property
    def analysed(self) -> bool:
        """Return whether there is a pattern."""
        return self._linear is not None

    def analyse(self, q: FloatArray, near: Candidates, bonds: Bonds | None) -> None:
        """Make the pattern of rods, sample pairs and bonds, and an order of elimination by places `q`."""
        self.pattern = make_pattern(len(q), near, bonds)
        self._linear = BlockCholesky(self.pattern, q[:, :3])
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
            fix_unknowns(self.pattern, self._fixed, self.blocks)
            self._whole = False
            while True:
                self._clock.factorisations += 1
                if self._linear.factor(self.blocks, shift):
                    self.shift = shift
                    return True
                shift = max(SHIFT_GROWTH * shift, SMALLEST_SHIFT)
                if not shift < LARGEST_SHIFT:
                    self.shift = 0.0
                    return False

    def solve(self, b: FloatArray) -> FloatArray:
        """Return K^-1 b (N, 4) for the last factor; `b` must vanish at fixed unknowns.

        Raises
        ------
        RuntimeError
            If nothing has been factored.
        """
        if self._linear is None:
            msg = "factor before solving"
            raise RuntimeError(msg)
        with self._clock("solve"):
            return self._linear.solve(b)
