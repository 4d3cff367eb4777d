"""Images in a periodic cell: T^T g and T^T K T against matrices, for any images."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knitlab_core.contact.pairs import Candidates
from knitlab_core.equilibrium.links import Links, LinkTerm
from knitlab_core.equilibrium.pattern import make_pattern, multiply
from knitlab_core.equilibrium.periodic import Period, half_space, lay_out
from knitlab_core.equilibrium.ties import Ties, fold, gather, make_folding, spread
from knitlab_core.rods.frames import Frames


def ties_of(sizes: tuple[int, ...], reach: tuple[int, int]) -> tuple[Ties, int]:
    """Return the ties of a cell of strands that go on along the course, every second one back, and all its nodes."""
    strands = [Period(np.zeros((n, 3)), (1 - 2 * (k % 2), 0)) for k, n in enumerate(sizes)]
    layout = lay_out(strands, reach)
    return layout.ties, layout.copied.size


def matrix_of(ties: Ties, n: int) -> np.ndarray:
    """Return T (4 N, 4 M) from its definition: columns are motions of one unknown that is no image."""
    columns = []
    for node in ties.kept:
        for c in range(4):
            v = np.zeros((n, 4))
            v[node, c] = 1.0
            spread(ties, v)
            columns.append(v.ravel())
    return np.array(columns).T


SIZES = st.lists(st.integers(3, 5), min_size=1, max_size=2).map(tuple)


@given(sizes=SIZES, reach=st.tuples(st.integers(0, 2), st.integers(0, 1)), seed=st.integers(0, 2**32 - 1))
def test_forces_and_stiffness_are_brought_back_to_what_is_no_image(
    sizes: tuple[int, ...], reach: tuple[int, int], seed: int
) -> None:
    ties, n = ties_of(sizes, reach)
    rng, whole = np.random.default_rng(seed), matrix_of(ties, n)
    gradient = rng.normal(size=(n, 4))
    gathered = gradient.copy()
    gather(ties, gathered)
    expected = np.zeros((n, 4))
    expected[ties.kept] = (whole.T @ gradient.ravel()).reshape(-1, 4)
    np.testing.assert_allclose(gathered, expected, atol=1e-12)

    # Nodes that are spans apart act on each other in contact; here any three and three do.
    pattern = make_pattern(n, Candidates(*(np.array(part) for part in ([1], [n - 2], [0, 0], [], []))))
    blocks = rng.normal(size=(pattern.rows.size, 4, 4))
    blocks[pattern.diagonal] += blocks[pattern.diagonal].transpose(0, 2, 1)
    stiffness = np.zeros((4 * n, 4 * n))
    for k in range(4 * n):
        one, out = np.zeros((n, 4)), np.zeros((n, 4))
        one.flat[k] = 1.0
        multiply(pattern, blocks, one, out)
        stiffness[k] = out.ravel()
    folding = make_folding(ties, pattern)
    folded = np.zeros((folding.pattern.rows.size, 4, 4))
    fold(folding, blocks, folded)
    m = ties.kept.size
    found = np.zeros((4 * m, 4 * m))
    for k in range(4 * m):
        one, out = np.zeros((m, 4)), np.zeros((m, 4))
        one.flat[k] = 1.0
        multiply(folding.pattern, folded, one, out)
        found[k] = out.ravel()
    np.testing.assert_allclose(found, whole.T @ stiffness @ whole, atol=1e-10)


@given(reach=st.lists(st.integers(0, 3), min_size=1, max_size=3))
def test_of_two_opposite_images_there_is_one(reach: list[int]) -> None:
    shifts = half_space(reach)
    every = {*shifts, *(tuple(-k for k in shift) for shift in shifts)}
    assert len(every) == 2 * len(shifts) == np.prod([2 * most + 1 for most in reach]) - 1


def test_links_are_springs_with_their_own_stiffness() -> None:
    rng = np.random.default_rng(1)
    links = Links(
        np.array([[5, 4, 3, 1], [5, 3, 2, 0]]), rng.normal(size=(2, 4)), rng.normal(size=(2, 3)), rng.random((2, 3))
    )
    term, q, frames = LinkTerm(links), rng.normal(size=(6, 4)), Frames.zeros(6)
    pattern = make_pattern(
        6, Candidates(*(np.array(part, dtype=np.int64) for part in ([], [], [0], [], []))), links=links
    )
    assert term.fits(pattern)
    term.place(q, frames)
    gradient, blocks = np.zeros((6, 4)), np.zeros((pattern.rows.size, 4, 4))
    term.add_gradient(gradient)
    term.add_hessian(1.0, blocks)
    step = rng.normal(size=(6, 4))
    curved = np.zeros((6, 4))
    multiply(pattern, blocks, step, curved)
    ahead, behind = np.zeros((6, 4)), np.zeros((6, 4))
    energies = []
    for sign, out in ((1e-3, ahead), (-1e-3, behind)):
        term.place(q + sign * step, frames)
        energies.append(term.energy())
        term.add_gradient(out)
    np.testing.assert_allclose((ahead - behind) / 2e-3, curved, atol=1e-9)
    assert (energies[0] - energies[1]) / 2e-3 == pytest.approx((gradient * step).sum(), rel=1e-9)
