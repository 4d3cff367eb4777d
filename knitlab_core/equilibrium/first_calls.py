"""Call kernels of the search on next to nothing, for a process that compiles them ahead of the one that needs them."""

import numpy as np

from knitlab_core.contact.pairs import Candidates
from knitlab_core.equilibrium.pattern import fix_unknowns, free_only, locate_across, make_pattern, multiply
from knitlab_core.rods.frames import Frames
from knitlab_core.rods.rod import Rods
from knitlab_core.rods.stiffness import rod_hessian
from knitlab_core.sparse.cholesky import BlockCholesky
from knitlab_core.sparse.sums import inner

NODES = 8


def call_search() -> None:
    """Call the kernels that a search needs last, in that order: analysis, stiffness of rods, factor, solution.

    About half of what there is to compile for a first equilibrium.
    """
    none = Candidates.empty(0, 0)
    pattern = make_pattern(NODES, none)
    solver = BlockCholesky(pattern)
    q, blocks = np.zeros((NODES, 4)), np.zeros((pattern.rows.size, 4, 4))
    rod_hessian(q, _loose_nodes(NODES), Frames.zeros(NODES), 1.0, pattern, blocks)
    blocks[pattern.diagonal] = np.eye(4)
    fixed = np.zeros((NODES, 4), dtype=np.bool_)
    fix_unknowns(pattern, fixed, blocks)
    solver.factor(blocks)
    force = np.ones((NODES, 4))
    free_only(fixed, force)
    inner(force, solver.solve(force))
    multiply(pattern, blocks, force, q)
    locate_across(pattern, none)


def _loose_nodes(n: int) -> Rods:
    """Return rods without an edge."""
    no, zero, two = np.zeros(n, dtype=np.bool_), np.zeros(n), np.zeros((n, 2))
    return Rods(
        has_edge=no,
        is_inner=no,
        rest_length=zero,
        span=zero,
        stretched=zero,
        evenness=zero,
        easing=zero,
        stretch_stiffness=zero,
        bend_stiffness=zero,
        twist_stiffness=zero,
        rest_stretch=two,
        rest_curvature=two,
        rest_twist=zero,
    )
