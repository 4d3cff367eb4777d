import numpy as np
import pytest
from numpy.typing import NDArray

from knitlab_core.sparse.gmres import solve_coupled


@pytest.mark.parametrize("size", [0.1, 0.6, 3.0])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-10])
def test_solves_as_a_dense_solver(size: float, tolerance: float) -> None:
    rng = np.random.default_rng(4)
    c = rng.normal(size=(24, 24))
    c *= size / np.linalg.norm(c, 2)
    b = rng.normal(size=(6, 4))
    full = np.eye(24) + c
    x = solve_coupled(lambda v: (c @ v.ravel()).reshape(6, 4), b, tolerance)
    assert x.shape == (6, 4)
    left = np.linalg.norm(full @ x.ravel() - b.ravel()) / np.linalg.norm(b)
    assert left <= 1.0001 * tolerance
    error = np.linalg.norm(x.ravel() - np.linalg.solve(full, b.ravel()))
    assert error <= 1.0001 * tolerance * np.linalg.norm(b) / np.linalg.svd(full, compute_uv=False)[-1]


def test_takes_as_many_products_as_the_coupling_has_directions() -> None:
    rng = np.random.default_rng(5)
    u, v = rng.normal(size=(2, 400))
    products = 0

    def apply(x: NDArray[np.float64]) -> NDArray[np.float64]:
        nonlocal products
        products += 1
        out: NDArray[np.float64] = 0.01 * float(v @ x) * u
        return out

    b = rng.normal(size=400)
    x = solve_coupled(apply, b, 1e-12)
    assert products == 2
    np.testing.assert_allclose(x + apply(x), b, rtol=1e-10, atol=1e-10)


def test_without_coupling_the_answer_is_the_right_hand_side() -> None:
    b = np.arange(8.0).reshape(2, 4)
    np.testing.assert_allclose(solve_coupled(np.zeros_like, b, 1e-8), b, rtol=1e-15)


def test_nothing_asked_is_nothing_found() -> None:
    b = np.zeros((3, 4))
    assert not solve_coupled(lambda v: v, b, 1e-8).any()
