"""Boundary conditions of the yarn: unknowns that carriages prescribe, their values, and the forces on carriages.

A fixture that ties nodes of the yarn is a `Grip`. Pins that slide along a pole leave the coordinate along it free;
a clamp, or a plate that loops are fused into, holds every unknown of all nodes inside it. Wires are strands of their
own in the solver's model: their nodes come after the yarn's, held but for the coordinate along the pole, and touch the
yarn by contact. All arrays here are in the solver's units.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from knitlab_core.knits import clamp_nodes, plate_nodes
from rigs.axes import COORDINATE, DIRECTIONS, FACE, SHEARS, SITES
from rigs.protocol.catalogue import clamped_axes

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from numpy.typing import NDArray

    from knitlab_core.equilibrium.model import Model
    from knitlab_core.knits import SiteSet, Specimen
    from rigs.axes import Axis, FloatArray, IntArray
    from rigs.protocol.catalogue import Drive, Fixture, Held

Side = Literal[-1, 1]

CLAMPED: Final[Held] = (True, True, True, True)
"""What a clamp holds of the end of a straight strand: hooks would let it swing."""

_SIDES: Final[tuple[Side, Side]] = (-1, 1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grip:
    """Tie nodes of the yarn to one carriage.

    Attributes
    ----------
    axis : Axis
        Axis of the carriage.
    side : {-1, 1}
        Side of the centre on which it stands; also the way it moves when its pair opens.
    nodes : IntArray, shape (n,)
        Nodes that it holds.
    held : tuple of bool
        Which of x, y, z and the edge's angle it prescribes at these nodes.
    pole : int or None
        Coordinate along which the nodes slide; None in a clamp or a plate.
    anchored : IntArray, shape (m,)
        Those of the nodes that it holds along the pole too.
    travel : float
        Share of its axis' travel that it makes, outwards [1].
    cell : float
        Share of its pull in what the load cell of its axis shows [1].
    wires : tuple of IntArray
        Nodes of the wires through each loop, which slide as one, beside the pins that hold the nodes above.
    """

    axis: Axis
    side: Side
    nodes: IntArray
    held: Held
    pole: int | None
    anchored: IntArray
    travel: float
    cell: float
    wires: tuple[IntArray, ...] = ()

    @property
    def rigid(self) -> bool:
        """Return whether it is a clamp or a plate, which holds its nodes as one body."""
        return self.pole is None and all(self.held)

    @property
    def all_nodes(self) -> IntArray:
        """Return every node that moves with the carriage, (m,)."""
        return np.concatenate([self.nodes, *self.wires])


def grips_on(
    specimen: Specimen, axis: Axis, drive: Drive, fixtures: Mapping[Axis, Fixture] | None = None
) -> tuple[Grip, Grip]:
    """Return the grips of both faces of an axis: pins that slide along their poles, clamps, or plates printed around.

    Parameters
    ----------
    specimen : Specimen
        The knit.
    axis : Axis
        The axis.
    drive : Drive
        Its carriages.
    fixtures : Mapping, optional
        What holds the faces of every axis that is driven: clamps of two axes end where they would meet, and hooks
        hold no site in the jaws of a clamp.

    Returns
    -------
    tuple of two Grip
        On the negative and on the positive side of the centre.
    """
    pole = None if drive.pole is None else COORDINATE[drive.pole]
    if drive.fixture == "plates":
        plates = plate_nodes(specimen)
        edges = [plates.lower, plates.upper]
    elif drive.fixture == "clamps":
        clamps = clamp_nodes(specimen, FACE[axis], clamped_axes(fixtures or {}))
        edges = [clamps.lower, clamps.upper]
    else:
        in_jaws = list(clamped_nodes(specimen, fixtures or {}).values())
        edges = [_outside(specimen.sites[name], in_jaws) for name in SITES[axis]]
    middle = _middle(specimen, edges[0])
    nobody = np.empty(0, dtype=np.int64)
    negative, positive = (
        Grip(
            axis=axis,
            side=side,
            nodes=nodes,
            held=CLAMPED if specimen.fabric.straight else drive.held,
            pole=pole,
            anchored=middle if drive.anchored and side < 0 else nobody,
            travel=drive.travel[number],
            cell=drive.cell[number],
        )
        for number, (side, nodes) in enumerate(zip(_SIDES, edges, strict=True))
    )
    return negative, positive


def ideal_grips(specimen: Specimen, axis: Axis) -> tuple[Grip, Grip]:
    """Return grips that drive a periodic cell along an axis: the second holds a component of a vector, the first none.

    The nodes whose positions are the vectors come after all others of the model: the course's, the wale's, the pile's.
    An axis holds the vector across its face, along its own direction.
    """
    nobody, number, along = np.empty(0, dtype=np.int64), DIRECTIONS.index(FACE[axis]), COORDINATE[axis]
    held: Held = (along == 0, along == 1, along == 2, False)
    vector = np.array([number - len(specimen.cell.vectors) if specimen.cell else 0])
    first = Grip(axis=axis, side=-1, nodes=nobody, held=held, pole=None, anchored=nobody, travel=0.0, cell=0.0)
    return first, replace(first, side=1, nodes=vector, travel=1.0, cell=1.0)


def release(model: Model, driven: Collection[Axis], *, sheared: bool) -> None:
    """Set free, in place, the lengths of a periodic cell along the axes that nothing drives, and its shear if asked."""
    if model.ties is None:
        return
    vectors = dict(zip(DIRECTIONS, model.ties.cell, strict=False))
    for axis in (*DIRECTIONS, *(SHEARS if sheared else ())):
        if FACE[axis] in vectors and axis not in driven:
            model.fixed[vectors[FACE[axis]], COORDINATE[axis]] = False


def clamped_nodes(specimen: Specimen, fixtures: Mapping[Axis, Fixture]) -> dict[SiteSet, IntArray]:
    """Return the nodes in the jaws of clamps by the edge that they hold; empty without clamps."""
    found: dict[SiteSet, IntArray] = {}
    for axis, fixture in fixtures.items():
        if fixture == "clamps":
            clamps = clamp_nodes(specimen, FACE[axis], clamped_axes(fixtures))
            found |= zip(SITES[axis], (clamps.lower, clamps.upper), strict=True)
    return found


def _outside(sites: IntArray, in_jaws: Sequence[IntArray]) -> IntArray:
    """Return the sites of an edge (n,) that are in no jaws."""
    return sites[~np.isin(sites, np.concatenate(in_jaws))] if in_jaws else sites


def _middle(specimen: Specimen, nodes: IntArray) -> IntArray:
    """Return the one of some nodes that is nearest to their mean, (1,)."""
    at = specimen.nodes[nodes]
    nearest = np.argmin(np.linalg.norm(at - at.mean(axis=0), axis=1))
    return nodes[nearest : nearest + 1]


def prescribe(grips: tuple[Grip, ...], fixed: NDArray[np.bool_]) -> None:
    """Mark what the grips hold among the prescribed unknowns, shape (N, 4), in place."""
    for grip in grips:
        fixed[np.ix_(grip.nodes, np.flatnonzero(grip.held))] = True
        if grip.pole is not None:
            fixed[grip.anchored, grip.pole] = True
            for wire in grip.wires:
                fixed[wire] = True
                fixed[wire, grip.pole] = wire[0] in grip.anchored


def place(grips: tuple[Grip, ...], mounted: FloatArray, travel: Mapping[Axis, float]) -> FloatArray:
    """Return where the grips put what they hold.

    Parameters
    ----------
    grips : tuple of Grip
        The grips.
    mounted : FloatArray, shape (N, 4)
        The unknowns when the specimen was mounted [r], [rad].
    travel : Mapping
        Change of the hook-to-hook length of each axis [r]; the two carriages of a pair share it.

    Returns
    -------
    FloatArray, shape (N, 4)
        Target of the held unknowns; the others stand as mounted.
    """
    target = mounted.copy()
    for grip in grips:
        target[grip.all_nodes, COORDINATE[grip.axis]] += grip.travel * grip.side * travel[grip.axis]
    return target


def pull(grip: Grip, reaction: FloatArray) -> float:
    """Return the force with which the specimen draws a carriage to the centre [E r^2], positive in tension.

    Parameters
    ----------
    grip : Grip
        The carriage's grip.
    reaction : FloatArray, shape (N, 4)
        Force of the fixtures on the yarn [E r^2].
    """
    return float(grip.side * reaction[grip.all_nodes, COORDINATE[grip.axis]].sum())


def largest_lateral(grip: Grip, reaction: FloatArray) -> float:
    """Return the largest force along its pole of a hook that is tied to it [E r^2]; zero if none is, and for a plate.

    Parameters
    ----------
    grip : Grip
        The carriage's grip.
    reaction : FloatArray, shape (N, 4)
        Force of the fixtures on the yarn [E r^2].
    """
    if grip.pole is None:
        return 0.0
    hooks = (*grip.wires, *grip.nodes[:, None])
    return max(abs(float(reaction[nodes, grip.pole].sum())) for nodes in hooks)


def rigid_forces(grip: Grip, reaction: FloatArray) -> dict[str, float]:
    """Return the force of a clamp or a plate on the specimen along each direction [E r^2]; empty for hooks.

    Parameters
    ----------
    grip : Grip
        The carriage's grip.
    reaction : FloatArray, shape (N, 4)
        Force of the fixtures on the yarn [E r^2].

    Returns
    -------
    dict of str to float
        By carriage and direction: ``W+_C`` is the force of the upper wale clamp along the course.
    """
    if not grip.rigid:
        return {}
    total = reaction[grip.nodes].sum(axis=0)
    return {
        name: float(total[COORDINATE[along]])
        for name, along in zip(rigid_names(grip.axis, grip.side), DIRECTIONS, strict=True)
    }


def rigid_names(axis: Axis, side: Side) -> list[str]:
    """Return the names of the forces of a clamp or a plate along C, W and P."""
    return [f"{axis}{'+' if side > 0 else '-'}_{along}" for along in DIRECTIONS]
