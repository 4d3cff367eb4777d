"""Mounting of a specimen on the rig of a protocol: its model, its fixtures, a yarn laid in and relaxed, its size."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from knitlab_core.equilibrium.cell_relaxation import relax_cell, relax_loops
from knitlab_core.equilibrium.dry_relaxation import knit_in
from knitlab_core.equilibrium.laying_in import lay_in
from knitlab_core.equilibrium.workspace import Workspace
from knitlab_core.knits import BoundEdges
from rigs.machines.fixtures import (
    grips_on,
    ideal_grips,
    prescribe,
    release,
)
from rigs.machines.load_train import load_train
from rigs.machines.machine import instruments_on
from rigs.machines.pins import pins_on
from rigs.machines.wires import hang_on_wires, sliding_hooks
from rigs.protocol.made_specimen import cell_lengths, size_of
from rigs.protocol.strands import model_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.equilibrium.model import Model, State
    from knitlab_core.knits import Specimen
    from rigs.axes import Axis, FloatArray
    from rigs.machines.machine import MachineData
    from rigs.protocol.catalogue import Drive, MachineName
    from rigs.protocol.protocol import Protocol
    from rigs.record import SpecimenSize
from rigs.machines.rig import Rig


def mount(
    specimen: Specimen, protocol: Protocol, data: Mapping[MachineName, MachineData], *, relaxed: bool = True
) -> tuple[Rig, State]:
    """Mount a specimen on the rig of a protocol.

    Parameters
    ----------
    specimen : Specimen
        The knit that the protocol names.
    protocol : Protocol
        Gives rig, material, friction and the rate of the log.
    data : Mapping
        The numbers of the machines of the rig.
    relaxed : bool
        Relax a yarn that is straight at rest into its loops; needless where the rig is put back to a checkpoint.

    Returns
    -------
    Rig, State
        The rig and the specimen's state as mounted.

    Raises
    ------
    SpecificationError
        If a wire is to hold what it cannot.
    GeometryError
        If a wire has no room in its loop.
    ConvergenceError
        If a yarn that is straight at rest finds no balance in its knit.
    """
    spec = protocol.specimen
    drives = protocol.drives
    if specimen.cell is None:
        grips = {axis: grips_on(specimen, axis, drive, protocol.fixtures) for axis, drive in drives.items()}
    else:
        grips = {axis: ideal_grips(specimen, axis) for axis in drives}
    wires: tuple[FloatArray, ...] = ()
    if protocol.hook == "wire":
        wires, grips = hang_on_wires(specimen, grips)
    model, state = model_of(specimen, spec, wires)
    if specimen.cell is None:
        model = replace(model, hooks=sliding_hooks(grips, _rubs(protocol, drives, data), state.q))
        for pair in grips.values():
            prescribe(pair, model.fixed)
    else:
        release(model, grips, sheared=spec.shear == "free")
    work = Workspace(model)
    if relaxed and spec.laid_in is not None:
        state = lay_in(model, state, spec.laid_in / specimen.radius)
    elif relaxed and spec.relaxed:
        state, _ = relax_loops(_with_loose_edges(model, specimen), state)
    elif relaxed and spec.grows_to is not None:
        state, _ = relax_cell(model, state)
    elif relaxed and spec.rest_shape == "straight":
        *_, (_, state, _) = knit_in(work, state)
    size = size_of(specimen, thickness=next(iter(data.values())).convention.thickness.value, fixtures=protocol.fixtures)
    rig = Rig(
        specimen=specimen,
        size=as_mounted(size, specimen, model.scales.length * state.q),
        grips=grips,
        work=work,
        mounted=state.q.copy(),
        instruments=instruments_on(protocol, data),
        breaks_at=spec.breaks_at,
        measured=spec.measured is not None,
        pins=pins_on(specimen, protocol.extensometer),
        relaxed=spec.rest_shape == "straight",
        sheared=spec.shear == "free",
        trains={axis: load_train(data[drive.machine]) for axis, drive in drives.items()},
    )
    return rig, state


def _with_loose_edges(model: Model, specimen: Specimen) -> Model:
    """Return a model whose chained edges nothing holds: jaws close on them when they are at rest."""
    if not isinstance(specimen.fabric, BoundEdges):
        return model
    fixed = model.fixed.copy()
    chained = specimen.fabric.chained(specimen.arc_lengths / specimen.loop_width, specimen.counts)
    fixed[np.flatnonzero(chained), :3] = False
    fixed[:, 3] = np.where(chained, ~model.rods.has_edge, fixed[:, 3])
    return replace(model, fixed=fixed)


def as_mounted(size: SpecimenSize, specimen: Specimen, mounted: FloatArray) -> SpecimenSize:
    """Return the size of a specimen whose unknowns as mounted are (N, 4) [m]: a cell may have relaxed to another."""
    if specimen.cell is None:
        return size
    lengths = cell_lengths(mounted[-len(specimen.cell.vectors) :, :3])
    return replace(size, extents={**size.extents, **lengths})


def _rubs(
    protocol: Protocol, drives: Mapping[Axis, Drive], data: Mapping[MachineName, MachineData]
) -> dict[Axis, float]:
    """Return the coefficient between hooks and poles of each axis [1]."""
    own = {axis: data[drive.machine].pole for axis, drive in drives.items()}
    if protocol.pole_friction is not None:
        return dict.fromkeys(own, protocol.pole_friction)
    return {axis: 0.0 if pole is None else pole.friction.value for axis, pole in own.items()}
