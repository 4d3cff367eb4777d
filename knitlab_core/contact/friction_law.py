"""Friction law: Coulomb's, with a spring in place of perfect sticking, as a potential of the slip at a load of 1/mu.

Huber's function: a spring up to the elastic slip `limit`, then a force of 1. Contacts use it, and hooks on their poles.
"""

from knitlab_core.jit import inline_kernel


@inline_kernel
def friction_law(slip: float, limit: float) -> tuple[float, float, float]:
    """Return f, f' / slip and f'' at a slip >= 0 [r]; f' / slip is what resists across the slip, f'' along it.

    f = slip^2 / (2 limit) up to the limit and slip - limit / 2 beyond.
    """
    if slip < limit:
        return 0.5 * slip * slip / limit, 1.0 / limit, 1.0 / limit
    return slip - 0.5 * limit, 1.0 / slip, 0.0
