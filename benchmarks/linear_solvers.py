"""Our block Cholesky beside QDLDL and SuperLU on one stiffness: the main job at 33 % strain."""

from __future__ import annotations

from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from knitlab_core.equilibrium.cholesky import BlockCholesky

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.rods.blocks import Pattern


def upper_triangle(pattern: Pattern, blocks: FloatArray) -> sparse.csc_matrix:
    """Return the scalar upper triangle of a stiffness in node blocks."""
    corner = np.arange(4)
    rows = (4 * pattern.rows[:, None, None] + corner[:, None] + 0 * corner).ravel()
    columns = (4 * pattern.columns[:, None, None] + corner + 0 * corner[:, None]).ravel()
    low = rows >= columns
    size = 4 * pattern.diagonal.size
    matrix = sparse.coo_matrix((blocks.ravel()[low], (columns[low], rows[low])), shape=(size, size))
    upper: sparse.csc_matrix = matrix.tocsc()
    upper.sort_indices()
    return upper


def milliseconds(call: Callable[[], object], repeats: int = 20) -> float:
    """Return the median time of a call [ms] after one to warm up."""
    call()
    times = []
    for _ in range(repeats):
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
    return 1e3 * median(times)


def compare(pattern: Pattern, blocks: FloatArray) -> list[tuple[str, float, float, float]]:
    """Return solver, and milliseconds to analyse, to factor and to solve."""
    own = BlockCholesky(pattern)
    b = np.ones((pattern.diagonal.size, 4))
    table = [
        (
            "block Cholesky",
            milliseconds(lambda: BlockCholesky(pattern)),
            milliseconds(lambda: own.factor(blocks)),
            milliseconds(lambda: own.solve(b)),
        )
    ]
    upper = upper_triangle(pattern, blocks)
    try:
        import qdldl  # noqa: PLC0415  (a peer that need not be installed)
    except ImportError:
        pass
    else:
        peer = qdldl.Solver(upper, upper=True)

        def factor_and_check() -> bool:
            peer.update(upper, upper=True)
            return bool((peer.factors()[1] > 0.0).all())

        table += [
            (
                "QDLDL",
                milliseconds(lambda: qdldl.Solver(upper, upper=True)),
                milliseconds(lambda: peer.update(upper, upper=True)),
                milliseconds(lambda: peer.solve(b.ravel())),
            ),
            ("QDLDL, pivots read", float("nan"), milliseconds(factor_and_check), float("nan")),
        ]
    whole = (upper + sparse.triu(upper, 1).T).tocsc()
    lu = splu(whole, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    factor = milliseconds(lambda: splu(whole, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}))
    return [*table, ("SuperLU", float("nan"), factor, milliseconds(lambda: lu.solve(b.ravel())))]
