"""Our block Cholesky beside QDLDL, MKL's Pardiso and SuperLU: ``python -m benchmarks.linear_solvers``.

Stiffnesses of the main job at 33 % strain, of a volumetric 4x4x4 pulled along its pile, and of a 6x6x6 as printed.
That one has no contacts yet: its pattern has room for those of every pair of strands within some radii.
"""

from __future__ import annotations

import os
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from benchmarks.main_job import stiffness
from knitlab_core.contact.neighbours import find_candidates
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.model import Model, State, make_model
from knitlab_core.equilibrium.pattern import fix_unknowns, make_pattern
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import NAMED_VOLUMETRIC_STITCHES, Specimen, knit_specimen
from knitlab_core.rods.stiffness import rod_hessian
from knitlab_core.sparse.cholesky import BlockCholesky
from knitlab_core.sparse.ordering import choose_order, node_graph

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.arrays import FloatArray
    from knitlab_core.sparse.blocks import Pattern

SHIFT = 1e-2
"""Added to a diagonal that may have floppy modes [E r]."""


class System(NamedTuple):
    """Pattern and blocks of a stiffness, and where its nodes are, if that is known."""

    name: str
    pattern: Pattern
    blocks: FloatArray
    positions: FloatArray | None


def volumetric(size: int) -> tuple[Specimen, Model, State]:
    """Make size x size x size stitches, held at both pile faces in wale and pile."""
    stitch = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
    specimen = knit_specimen(stitch, rows=size, loops=size, layers=size, loop_width=8e-3)
    model, state = make_model(
        [specimen.nodes], radius=specimen.radius, young_modulus=0.82e9, poisson_ratio=0.37, friction=0.3
    )
    for face in ("pile-", "pile+"):
        model.fixed[specimen.sites[face], 1:3] = True
    return specimen, model, state


def shifted(name: str, pattern: Pattern, blocks: FloatArray, state: State, model: Model) -> System:
    """Return the stiffness of the free unknowns, made positive definite."""
    fix_unknowns(pattern, model.fixed, blocks)
    blocks[pattern.diagonal] += SHIFT * np.eye(4)
    return System(name, pattern, blocks, state.q[:, :3])


def pulled(size: int, strain: float) -> System:
    """Return the stiffness of a volumetric knit pulled along its pile."""
    specimen, model, state = volumetric(size)
    up, down, start = specimen.sites["pile+"], specimen.sites["pile-"], state.q.copy()
    gauge = start[up, 2].mean() - start[down, 2].mean()

    def path(share: float) -> FloatArray:
        q = start.copy()
        q[up, 2] += 0.5 * gauge * strain * share
        q[down, 2] -= 0.5 * gauge * strain * share
        return q

    work = Workspace(model)
    for _, end, _ in march(work, state, path, longest=0.25):
        state = end
    work.start_step(state.q, state.frames, state.memory)
    work.assemble()
    return shifted(
        f"volumetric {size}x{size}x{size}, {strain:.0%}", work.stiffness.pattern, work.stiffness.blocks, state, model
    )


def printed(size: int, skin: float) -> System:
    """Return the stiffness of a knit as printed, in a pattern for contacts within a skin [r]."""
    _, model, state = volumetric(size)
    pattern = make_pattern(len(state.q), find_candidates(state.q, model.samples, model.law, skin))
    blocks = np.zeros((pattern.rows.size, 4, 4))
    rod_hessian(state.q, model.rods, state.frames, 1.0, pattern, blocks)
    return shifted(f"volumetric {size}x{size}x{size}, within {skin:g} r", pattern, blocks, state, model)


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


def milliseconds(call: Callable[[], object], longest: float = 3.0) -> tuple[float, float]:
    """Return the median and the least time of a call [ms], 3 to 20 of them after one to warm up."""
    call()
    times: list[float] = []
    while len(times) < 3 or (len(times) < 20 and sum(times) < longest):
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
    return 1e3 * median(times), 1e3 * min(times)


Times = tuple[float, float]
Line = tuple[str, Times, Times, Times]
NOT_APART: Times = (float("nan"), float("nan"))


def _qdldl(upper: sparse.csc_matrix, b: FloatArray) -> list[Line]:
    try:
        import qdldl  # noqa: PLC0415  (a peer that need not be installed)
    except ImportError:
        return []
    peer = qdldl.Solver(upper, upper=True)

    def factor_and_check() -> bool:
        peer.update(upper, upper=True)
        return bool((peer.factors()[1] > 0.0).all())

    return [
        (
            "QDLDL",
            milliseconds(lambda: qdldl.Solver(upper, upper=True)),
            milliseconds(lambda: peer.update(upper, upper=True)),
            milliseconds(lambda: peer.solve(b.ravel())),
        ),
        ("QDLDL, pivots read", NOT_APART, milliseconds(factor_and_check), NOT_APART),
    ]


def _pardiso(upper: sparse.csc_matrix, b: FloatArray) -> list[Line]:
    os.environ.setdefault("MKL_NUM_THREADS", "1")  # before MKL is loaded: one core, as for all others
    try:
        import pypardiso  # noqa: PLC0415  (a peer that need not be installed)
    except ImportError:
        return []
    peer = pypardiso.PyPardisoSolver(mtype=2)
    rows, right = sparse.csr_matrix(upper), b.ravel()[:, None].copy(order="F")

    def phase(number: int) -> Callable[[], object]:
        def run() -> object:
            peer.set_phase(number)
            return peer._call_pardiso(rows, right)  # noqa: SLF001  (it offers no phase by itself)

        return run

    analyse, factor, solve = (milliseconds(phase(number)) for number in (11, 22, 33))
    return [("MKL Pardiso, 1 thread", analyse, factor, solve)]


def _superlu(upper: sparse.csc_matrix, b: FloatArray) -> list[Line]:
    whole = (upper + sparse.triu(upper, 1).T).tocsc()

    def factor() -> object:
        return splu(whole, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    lu = splu(whole, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return [("SuperLU", NOT_APART, milliseconds(factor), milliseconds(lambda: lu.solve(b.ravel())))]


def compare(system: System) -> list[Line]:
    """Return solver, and milliseconds (median, least) to analyse, to factor and to solve."""
    _, pattern, blocks, positions = system
    own = BlockCholesky(pattern, positions)
    b = np.ones((pattern.diagonal.size, 4))
    upper = upper_triangle(pattern, blocks)
    return [
        (
            "block Cholesky",
            milliseconds(lambda: BlockCholesky(pattern, positions)),
            milliseconds(lambda: own.factor(blocks)),
            milliseconds(lambda: own.solve(b)),
        ),
        *_qdldl(upper, b),
        *_pardiso(upper, b),
        *(_superlu(upper, b) if positions is None else []),
    ]


def show(system: System) -> None:
    """Print what each solver takes for a system."""
    _, pattern, blocks, positions = system
    work = choose_order(node_graph(pattern), positions).operations
    stored = BlockCholesky(pattern, positions).factor_blocks
    print(
        f"{system.name}: {4 * pattern.diagonal.size} unknowns, {len(blocks)} blocks; "
        f"{stored} in the factor ({128e-6 * stored:.0f} MB), {1e-9 * work:.3g} Gflop"
    )
    for name, *times in compare(system):
        print(f"  {name:22s} " + " ".join(f"{middle:8.2f} {least:8.2f}" for middle, least in times))


def main() -> None:
    """Print the table of every system."""
    print("linear solvers           analyse    least   factor    least    solve    least  [ms]")
    pattern, blocks = stiffness()
    show(System("planar 6x6, 33 %", pattern, blocks, None))
    show(pulled(4, 0.1))
    show(printed(6, 2.3))
    show(printed(6, 3.0))


if __name__ == "__main__":
    main()
