"""Factor and solve in two halves: the same bits with one thread and with two."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from knitlab_core import threads
from knitlab_core.sparse import subtrees
from knitlab_core.sparse.cholesky import BlockCholesky
from knitlab_core.sparse.supernodes import analyse
from tests.knitlab_core.sparse.blocks import dense, random_blocks, random_pattern

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(autouse=True)
def split_all(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(subtrees, "SPLIT_ABOVE", 0.0)
    before = threads.thread_count()
    yield
    threads.use_threads(before)


@pytest.mark.parametrize(("n", "contacts"), [(3, 0), (40, 10), (120, 60)])
def test_halves_are_subtrees_that_share_nothing(n: int, contacts: int) -> None:
    plan = analyse(random_pattern(n, contacts, seed=n))
    parts = subtrees.split(plan, 1.0)
    everyone = np.concatenate([parts.first, parts.second, parts.rest])
    np.testing.assert_array_equal(np.sort(everyone), np.arange(plan.first.size - 1))
    owner = np.empty(everyone.size, np.int64)
    for k, members in enumerate(parts[:3]):
        assert (np.diff(members) > 0).all()
        owner[members] = k
    for s in range(everyone.size):
        for t in plan.owner[plan.row_start[s] : plan.row_start[s + 1]]:
            assert owner[t] in {owner[s], 2}
    assert n == 3 or not parts.is_whole


@pytest.mark.parametrize(("n", "contacts"), [(3, 0), (40, 10), (120, 60), (400, 150)])
def test_threads_change_no_bit(n: int, contacts: int) -> None:
    pattern = random_pattern(n, contacts, seed=n)
    blocks = random_blocks(pattern, seed=n + 1, diagonal=150.0)
    b = np.random.default_rng(n).normal(size=(n, 4))
    found = []
    for count in (1, 2, 2):
        threads.use_threads(count)
        linear = BlockCholesky(pattern)
        assert linear.factor(blocks)
        found.append(linear.solve(b))
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
    expected = np.linalg.solve(dense(pattern, blocks), b.ravel())
    np.testing.assert_allclose(found[0].ravel(), expected, rtol=1e-11, atol=1e-14)


def test_halves_agree_with_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    pattern = random_pattern(300, 100, seed=2)
    blocks = random_blocks(pattern, seed=3, diagonal=150.0)
    b = np.random.default_rng(4).normal(size=(300, 4))
    halves = BlockCholesky(pattern)
    monkeypatch.setattr(subtrees, "SPLIT_ABOVE", np.inf)
    whole = BlockCholesky(pattern)
    assert halves.factor(blocks)
    assert whole.factor(blocks)
    np.testing.assert_allclose(halves.solve(b), whole.solve(b), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("count", [1, 2])
def test_a_half_that_is_not_positive_is_found(count: int) -> None:
    threads.use_threads(count)
    pattern = random_pattern(120, 60, seed=5)
    blocks = random_blocks(pattern, seed=6, diagonal=150.0)
    for node in (0, 60, 119):
        worse = blocks.copy()
        worse[pattern.diagonal[node], 1, 1] = -1.0
        assert not BlockCholesky(pattern).factor(worse)
