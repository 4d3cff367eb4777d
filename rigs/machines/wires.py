"""Wire hooks: which hooks of an edge become wires, and what slides along the poles."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from knitlab_core.knits import wires_through
from rigs.axes import COORDINATE, SITES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from knitlab_core.equilibrium.hook_friction import Hooks
    from knitlab_core.knits import Specimen
    from rigs.axes import Axis, FloatArray
    from rigs.machines.fixtures import Grip

    Pairs = Mapping[Axis, tuple[Grip, Grip]]


class Hung(NamedTuple):
    """Wires of a rig: nodes (n, 3) [m] as the solver's model counts them, and the grips that carry them."""

    wires: tuple[FloatArray, ...]
    grips: dict[Axis, tuple[Grip, Grip]]


def hang_on_wires(specimen: Specimen, pins: Pairs) -> Hung:
    """Replace every pin that has a loop to go through by a wire; the others stay pins.

    Parameters
    ----------
    specimen : Specimen
        A planar knit.
    pins : Mapping
        The grips of each axis, of pins.

    Raises
    ------
    GeometryError
        If a wire has no room in its loop.
    """
    wires: list[FloatArray] = []
    begin = len(specimen.nodes)

    def hang(axis: Axis, grip: Grip) -> Grip:
        nonlocal begin
        # A pin holds a node of every fibre.
        pins = list(grip.nodes.reshape(-1, len(specimen.strands)))
        left, hung = dict(enumerate(pins)), []
        anchored = grip.anchored
        for loop in wires_through(specimen, SITES[axis][(grip.side + 1) // 2]):
            count = sum(len(nodes) for nodes in loop.nodes)
            hung.append(np.arange(begin, begin + count))
            begin += count
            wires.extend(loop.nodes)
            gone = np.concatenate([left.pop(hook) for hook in loop.hooks])
            if np.isin(gone, grip.anchored).any():
                anchored = hung[-1]
        nodes = np.concatenate([grip.nodes[:0], *left.values()])
        return replace(grip, nodes=nodes, wires=tuple(hung), anchored=anchored)

    grips = {axis: (hang(axis, pair[0]), hang(axis, pair[1])) for axis, pair in pins.items()}
    return Hung(tuple(wires), grips)


def require_room(specimen: Specimen, axes: Sequence[Axis]) -> None:
    """Refuse wires on some axes that have no room in their loops.

    Raises
    ------
    GeometryError
        Naming the loop.
    """
    for axis in axes:
        for edge in SITES[axis]:
            wires_through(specimen, edge)


def sliding_hooks(grips: Pairs, friction: Mapping[Axis, float], q: FloatArray) -> Hooks | None:
    """Return what slides along the poles and is more than a node that is free to.

    Parameters
    ----------
    grips : Mapping
        The grips of each axis.
    friction : Mapping
        Coefficient between hook and pole for each axis [1].
    q : FloatArray, shape (N, 4)
        The unknowns as mounted [r], [rad].

    Returns
    -------
    Hooks or None
        The wires of every loop, and every pin whose pole rubs; None if there are none.
    """
    from knitlab_core.equilibrium.hook_friction import Hooks  # noqa: PLC0415 (kernels: a plan needs none)

    found = [
        (nodes, COORDINATE[axis], grip.pole, 0.0 if nodes[0] in grip.anchored else friction[axis])
        for axis, pair in grips.items()
        for grip in pair
        if grip.pole is not None
        for nodes in (*grip.wires, *(grip.nodes[:, None] if friction[axis] > 0.0 else ()))
    ]
    if not found:
        return None
    hooks, pulls, poles, coefficients = zip(*found, strict=True)
    tied = np.concatenate([nodes[1:] for nodes in hooks])
    along = np.repeat(poles, [len(nodes) - 1 for nodes in hooks])
    return Hooks(
        nodes=np.concatenate(hooks),
        hook=np.repeat(np.arange(len(hooks)), [len(nodes) for nodes in hooks]),
        pull=np.array(pulls),
        pole=np.array(poles),
        slider=np.array([nodes[len(nodes) // 2] for nodes in hooks]),
        friction=np.array(coefficients),
        tied=tied,
        apart=q[tied, along] - q[tied - 1, along],
    )
