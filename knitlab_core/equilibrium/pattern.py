"""Which pairs of nodes act on each other: the sparsity of the stiffness, in 4 x 4 blocks."""

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.contact.bonds import Bonds
from knitlab_core.contact.neighbours import Candidates
from knitlab_core.jit import kernel
from knitlab_core.rods.blocks import Pattern


def _across_keys(candidates: Candidates | Bonds, n: int) -> IndexArray:
    """Return keys (S, 9) = column n + row of the node pairs of span pairs."""
    near = np.arange(-1, 2)
    rows = candidates.span_b[:, None, None] + near[None, :, None]
    columns = candidates.span_a[:, None, None] + near[None, None, :]
    return (columns * n + rows).reshape(-1, 9)


def make_pattern(n: int, candidates: Candidates, bonds: Bonds | None = None) -> Pattern:
    """Make the pattern of n nodes in rods and the given contacts and bonds; `across` is that of the contacts."""
    i = np.arange(n)
    across = _across_keys(candidates, n)
    rods = [i * n + i, i[:-1] * n + i[1:], i[:-2] * n + i[2:]]
    bonded = [] if bonds is None else [_across_keys(bonds, n).ravel()]
    keys = np.unique(np.concatenate([*rods, across.ravel(), *bonded]))
    none = np.full(2, -1, dtype=np.int64)
    places = [np.searchsorted(keys, k) for k in rods]
    return Pattern(
        rows=keys % n,
        columns=keys // n,
        diagonal=places[0],
        below=np.concatenate([none[:1], places[1]]),
        below2=np.concatenate([none, places[2]]),
        across=np.searchsorted(keys, across),
    )


def update_pattern(pattern: Pattern, n: int, candidates: Candidates | Bonds) -> Pattern | None:
    """Fit new candidates or bonds into a pattern, or return None if they need blocks it lacks."""
    keys = pattern.columns * n + pattern.rows
    wanted = _across_keys(candidates, n)
    places = np.minimum(np.searchsorted(keys, wanted), keys.size - 1)
    if not np.array_equal(keys[places], wanted):
        return None
    return pattern._replace(across=places)


@kernel
def fix_unknowns(pattern: Pattern, fixed: BoolArray, blocks: FloatArray) -> None:
    """Make rows and columns of fixed unknowns those of the unit matrix."""
    for b in range(pattern.rows.size):
        i, j = pattern.rows[b], pattern.columns[b]
        for r in range(4):
            for c in range(4):
                if fixed[i, r] or fixed[j, c]:
                    blocks[b, r, c] = 1.0 if i == j and r == c else 0.0


@kernel
def multiply(pattern: Pattern, blocks: FloatArray, v: FloatArray, out: FloatArray) -> None:
    """Fill out = K v for vectors (N, 4)."""
    out[:] = 0.0
    for b in range(pattern.rows.size):
        i, j = pattern.rows[b], pattern.columns[b]
        for r in range(4):
            for c in range(4):
                out[i, r] += blocks[b, r, c] * v[j, c]
                if i != j:
                    out[j, c] += blocks[b, r, c] * v[i, r]
