"""The solver's model of a specimen's strands: what they are made of, and how they touch."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypedDict

from knitlab_core.contact.compression import Compression
from knitlab_core.equilibrium.model import make_model
from knitlab_core.equilibrium.periodic import Period, make_cell
from knitlab_core.rods.relaxation import Relaxation
from knitlab_core.rods.section import SOLID, Section, measured_section, yarn_section
from knitlab_core.rods.yielding import make_yielding

if TYPE_CHECKING:
    from collections.abc import Sequence

    from knitlab_core.equilibrium.model import Model, State
    from knitlab_core.knits import Specimen
    from rigs.axes import FloatArray
    from rigs.protocol.specimen import SpecimenSpec


class _Body(TypedDict):
    """What strands are made of, as `make_model` takes it."""

    radius: float
    young_modulus: float
    poisson_ratio: float
    friction: float
    section: Section
    compression: Compression | None


def _body_of(specimen: Specimen, spec: SpecimenSpec) -> _Body:
    """Return what the strands of a specimen are made of: a solid, or a yarn by measurement."""
    measured, yarn = spec.measured, specimen.yarn
    if measured is not None:
        return _Body(
            radius=specimen.radius,
            young_modulus=measured.reference_modulus,
            poisson_ratio=0.0,
            friction=spec.friction,
            section=measured_section(measured),
            compression=Compression.of(measured),
        )
    return _Body(
        radius=specimen.radius,
        young_modulus=spec.solid.young_modulus.value,
        poisson_ratio=spec.solid.poisson_ratio.value,
        friction=spec.friction,
        section=yarn_section(yarn) if yarn.model == "yarn" and yarn.fibres > 1 else SOLID,
        compression=None,
    )


def model_of(specimen: Specimen, spec: SpecimenSpec, wires: Sequence[FloatArray]) -> tuple[Model, State]:
    """Make the solver's model of a specimen and of wires, and its state as printed.

    Parameters
    ----------
    specimen : Specimen
        The knit, or a periodic cell of it.
    spec : SpecimenSpec
        Its material or yarn, friction, shape at rest and options.
    wires : sequence of (n, 3) arrays
        Rigid wires that hold it [m].
    """
    straight = spec.rest_shape == "straight"
    body = _body_of(specimen, spec)
    if specimen.cell is None:
        model, state = make_model(
            specimen.strands, **body, straight=straight, printed=not straight, bonds=spec.fused, wires=wires
        )
    else:
        periods = [
            Period(nodes[:-2], shift) for nodes, shift in zip(specimen.strands, specimen.cell.shifts, strict=True)
        ]
        cell = specimen.cell
        model, state = make_cell(
            periods,
            cell.vectors,
            cell.reach,
            neighbours=cell.neighbours,
            stitches=cell.stitches,
            straight=straight,
            **body,
        )
    if spec.measured is not None:
        return model, state
    relaxation = Relaxation.of(spec.solid) if spec.viscoelastic else None
    lasting = 1.0 if relaxation is None else relaxation.lasting
    yielding = make_yielding(spec.solid, body["section"], lasting) if spec.yields else None
    return replace(model, relaxation=relaxation, yielding=yielding), state
