"""Lay a thick yarn into its loops: its strands overlap as laid in, so its contact radius grows as it relaxes.

    state = lay_in(model, state, 0.4)

The yarn relaxes at a share of its contact radius at which its strands are clear of each other, as `dry_relaxation` has
it. Then the radius grows to the whole one in stages, each an equilibrium; loops that snap on the way are followed down.
"""

from dataclasses import replace

from knitlab_core.contact.law import ContactLaw, scaled_law
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.dry_relaxation import DIRECT, REACH, follow_down, idle, knit_in, settled_rods
from knitlab_core.equilibrium.model import Model, State
from knitlab_core.equilibrium.newton import Options
from knitlab_core.equilibrium.terms import RodTerm
from knitlab_core.equilibrium.workspace import Workspace

GROWTH = 0.05
"""Growth of the contact radius in a stage [r]: two strands then overlap by as much more as a mesh may overlap them."""


def lay_in(model: Model, state: State, share: float, *, options: Options = DIRECT) -> State:
    """Relax a yarn into its loops at a share of its contact radius, and grow it to the whole radius.

    Parameters
    ----------
    model : Model
        The specimen, its yarn straight at rest, its fixtures prescribed.
    state : State
        The knit as laid in, strands clear of each other at that share of the radius.
    share : float
        Contact radius as laid in over the model's [1], above 0 and up to 1.
    options : Options
        How hard to try.

    Returns
    -------
    State
        The equilibrium from which a test begins.

    Raises
    ------
    ConvergenceError
        If the yarn comes to no rest.
    """
    *_, (_, state, _) = knit_in(Workspace(replace(model, law=_law(model, share))), state)
    rods = settled_rods(model)
    stages = max(1, round((1.0 - share) / GROWTH)) if share < 1.0 else 0
    for stage in range(1, stages + 1):
        radius = share + (1.0 - share) * stage / stages
        work = Workspace(replace(model, law=_law(model, radius)))
        found, _ = advance(work, state, state.q, options, rods=RodTerm(rods))
        if found is None:
            found, _ = follow_down(work, state, rods, options, radius, REACH)
        state = idle(found)
    return state


def _law(model: Model, share: float) -> ContactLaw:
    """Return the contact law of a share of the radius: as much force where strands overlap by the same share of it.

    Hertz's force grows with overlap^(3/2) and the crossing with the radius; rods bend as those of the whole radius do.
    """
    return scaled_law(model.law, share, share**-2.5)
