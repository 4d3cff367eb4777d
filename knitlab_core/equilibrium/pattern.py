"""Which pairs of nodes act on each other: the sparsity of the stiffness, in 4 x 4 blocks."""

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.contact.bonds import Bonds
from knitlab_core.contact.pairs import Candidates
from knitlab_core.equilibrium.links import Links
from knitlab_core.jit import kernel
from knitlab_core.sparse.blocks import Pattern


def _across_keys(candidates: Candidates | Bonds, n: int) -> IndexArray:
    """Return keys (S, 9) = column n + row of the node pairs of span pairs."""
    near = np.arange(-1, 2)
    rows = candidates.span_b[:, None, None] + near[None, :, None]
    columns = candidates.span_a[:, None, None] + near[None, None, :]
    return (columns * n + rows).reshape(-1, 9)


def make_pattern(n: int, candidates: Candidates, bonds: Bonds | None = None, links: Links | None = None) -> Pattern:
    """Make the pattern of n nodes in rods and the given contacts, bonds and links; `across` is that of the contacts."""
    i = np.arange(n)
    across = _across_keys(candidates, n)
    rods = [i * n + i, i[:-1] * n + i[1:], i[:-2] * n + i[2:]]
    bonded = [] if bonds is None else [_across_keys(bonds, n).ravel()]
    linked = [] if links is None else [links.keys(n)]
    keys = np.unique(np.concatenate([*rods, across.ravel(), *bonded, *linked]))
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
def _locate(pattern: Pattern, span_a: IndexArray, span_b: IndexArray, across: IndexArray) -> bool:
    """Fill the blocks of span pairs, -1 where there are none; return whether all were found."""
    whole = True
    rows, n = pattern.rows, pattern.diagonal.size
    for s in range(span_a.size):
        first = span_b[s] - 1
        for y in range(3):
            # A column's blocks are together, its diagonal first; a span's three rows follow each other.
            column = span_a[s] - 1 + y
            at = pattern.diagonal[column]
            end = pattern.diagonal[column + 1] if column + 1 < n else rows.size
            while at < end and rows[at] < first:
                at += 1
            found = at + 2 < end and rows[at] == first and rows[at + 1] == first + 1 and rows[at + 2] == first + 2
            if not found:
                across[s, 0] = -1
                whole = False
                break
            for x in range(3):
                across[s, 3 * x + y] = at + x
    return whole


def locate_across(pattern: Pattern, candidates: Candidates) -> tuple[IndexArray, bool]:
    """Return the blocks (S, 9) of span pairs in a pattern, and whether it has them all; -1 comes first where not."""
    across = np.empty((candidates.span_a.size, 9), dtype=np.int64)
    whole = _locate(pattern, candidates.span_a, candidates.span_b, across)
    return across, whole


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
def free_only(fixed: BoolArray, v: FloatArray) -> None:
    """Set a vector (N, 4) to zero at fixed unknowns."""
    for i in range(v.shape[0]):
        for c in range(4):
            if fixed[i, c]:
                v[i, c] = 0.0


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
