from __future__ import annotations

import math

import pytest
from scipy.stats import spearmanr

from rigs.analysis.ranks import rank_correlation


def test_ranks_do_not_see_the_form_of_a_curve() -> None:
    assert rank_correlation([0.0, 0.1, 0.2, 0.4], [1.0, 1.1, 9.0, 1e6]) == pytest.approx(1.0)
    assert rank_correlation([1.0, 2.0, 3.0], [5.0, 4.0, -1.0]) == pytest.approx(-1.0)


def test_ties_share_their_rank() -> None:
    x, y = [1.0, 2.0, 2.0, 4.0, 5.0], [2.0, 1.0, 3.0, 3.0, 5.0]
    assert rank_correlation(x, y) == pytest.approx(float(spearmanr(x, y).statistic))


def test_a_constant_has_no_correlation() -> None:
    assert math.isnan(rank_correlation([1.0, 2.0], [3.0, 3.0]))
