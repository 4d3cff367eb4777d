"""Conversion of the specimen of a file to the domain's, and back to the data of a file."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Any, cast

from app.schemas.convert_knits import in_loop_widths, knit_by_values, written_knit
from app.schemas.convert_substance import by_name, friction_of, substance_of
from app.schemas.errors import Faults
from app.schemas.locate import at
from app.schemas.specimen import YarnModel
from app.schemas.units import write
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import (
    Yarn,
    fabric_named,
    fabric_names,
    same_area,
)
from knitlab_core.materials import MATERIALS
from rigs.protocol.edges import OPEN, Edges
from rigs.protocol.specimen import MESHES, SpecimenSpec

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Document
    from app.schemas.files_beside import NamedText
    from app.schemas.specimen import FusedModel, SpecimenModel
    from knitlab_core.knits import Fabric
    from knitlab_core.materials import Substance
    from rigs.protocol.protocol import Protocol


def to_specimen(
    model: SpecimenModel, document: Document, own: Mapping[str, Substance], text: NamedText | None = None
) -> SpecimenSpec:
    """Return the specimen a model describes; inline stitch values may be lengths.

    Parameters
    ----------
    model : SpecimenModel
        The file's content.
    document : Document
        Its text, for the spots of errors.
    own : Mapping
        Materials that the protocol brings.
    text : NamedText, optional
        The centreline that it names.

    Raises
    ------
    ProtocolError
        For a value out of its range.
    """
    faults = Faults()
    knit = model.knit if isinstance(model.knit, str) else knit_by_values(model.knit, model.loop, document, text)
    rows, loops, *layers = model.loops
    fused = faults.of(lambda: _fused(model.fused, document), None)
    # An unknown name is refused by the specimen, with those that are known.
    named = fabric_named(knit) if isinstance(knit, str) and knit in fabric_names() else None
    fabric = named if isinstance(knit, str) else knit
    known: dict[str, Substance] = {**MATERIALS, **own}
    substance = faults.of(lambda: substance_of(model, known, document), None)

    def whole() -> SpecimenSpec:
        return SpecimenSpec(
            knit=knit,
            rows=rows,
            loops=loops,
            layers=layers[0] if layers else 1,
            loop_width=model.loop,
            # One that is not known is replaced by another, to find more mistakes.
            material=next(iter(MATERIALS)) if substance is None else by_name(substance),
            friction=friction_of(model, substance),
            nodes_per_loop=nodes,
            rest_shape=model.rest_shape,
            yarn=yarn,
            fused=fused,
            viscoelastic=model.viscoelastic and substance is not None,
            yields=model.yields and substance is not None,
            rupture="off" if substance is None else model.rupture,
            periodic=model.periodic,
            shear=model.shear,
            laid_in=None if model.laid_in == "relaxed" else model.laid_in,
            relaxed=model.laid_in == "relaxed",
            edges=Edges(**model.edges.model_dump()),
        )

    with at(document, ("specimen",)):
        nodes = faults.of(lambda: _nodes_per_loop(model), MESHES["default"])
        yarn = faults.of(lambda: _made_yarn(model, fabric), None)
        spec = faults.of(whole, None)
        if spec is not None and bool(layers) != ("P" in spec.axes):
            allowed = "[rows, loops in a row, layers]" if not layers else "[rows, loops in a row] of a planar knit"
            faults.found.append(SpecificationError("loops", model.loops, allowed))
        faults.raise_any()
    return cast("SpecimenSpec", spec)


def _made_yarn(model: SpecimenModel, fabric: Fabric | None) -> Yarn | None:
    """Return the yarn of fibres of a specimen, if it has one and its knit is known."""
    if not isinstance(model.yarn, YarnModel) or fabric is None:
        return None
    return _yarn(model.yarn, fabric.fibre_radius, model.loop, printed=model.rest_shape == "as-printed")


def _nodes_per_loop(model: SpecimenModel) -> int:
    """Return how finely a yarn is divided: by name or by number, not by both."""
    if model.nodes_per_loop is None:
        return MESHES["default" if model.mesh is None else model.mesh]
    if model.mesh is not None:
        raise SpecificationError("mesh", f"{model.mesh} and nodes_per_loop", "one of the two")
    return model.nodes_per_loop


def written(spec: SpecimenSpec, protocol: Protocol) -> dict[str, Any]:
    """Return the specimen of a protocol, with what holds it, as the data of a file."""
    rubs, grips = protocol.pole_friction, protocol.grips
    return {
        "knit": spec.knit if isinstance(spec.knit, str) else written_knit(spec.knit),
        "loops": [spec.rows, spec.loops, *([spec.layers] if "P" in spec.axes else [])],
        "loop": write(spec.loop_width, "length"),
        "material": spec.substance.name,
        "friction": spec.friction,
        **({} if grips == "hooks" else {"grips": grips if isinstance(grips, str) else dict(grips)}),
        "hook": protocol.hook,
        **({} if rubs is None else {"pole_friction": rubs}),
        "nodes_per_loop": spec.nodes_per_loop,
        "rest_shape": spec.rest_shape,
        **({} if spec.laid_in is None else {"laid_in": write(spec.laid_in, "length")}),
        **({"laid_in": "relaxed"} if spec.relaxed else {}),
        **({} if spec.edges == OPEN else {"edges": {**spec.edges.chained, "slack": spec.edges.slack}}),
        **({} if spec.yarn is None else {"yarn": {one.name: getattr(spec.yarn, one.name) for one in fields(Yarn)}}),
        **({} if spec.fused is None else {"fused": _written_law(spec.fused)}),
        "viscoelastic": "on" if spec.viscoelastic else "off",
        "yield": "on" if spec.yields else "off",
        "rupture": spec.rupture,
        **({"periodic": "on", "shear": spec.shear} if spec.periodic else {}),
    }


def _yarn(model: YarnModel, single_radius: float, loop_width: float, *, printed: bool) -> Yarn:
    """Return a yarn in loop widths: unless told otherwise its fibres have the stitch's own area and lie just apart.

    Fibres that are printed so near fuse: seen as one rod, such a yarn is glued unless told otherwise.
    """
    given = {
        name: in_loop_widths(measure, loop_width)
        for name in ("fibre_radius", "winding_radius")
        if (measure := getattr(model, name)) is not None
    }
    count = model.fibres
    values: dict[str, Any] = {"fibre_radius": single_radius, "winding_radius": 0.0}
    if count > 0:
        radius = given.get("fibre_radius", single_radius / math.sqrt(count))
        values = {"fibre_radius": radius, "winding_radius": same_area(radius * math.sqrt(count), count).winding_radius}
    fuses = printed and model.model == "yarn" and model.winding_radius is None
    return Yarn(
        fibres=count,
        model=model.model,
        twist=float(model.twist),
        phase=float(model.phase),
        bonding=float(fuses) if model.bonding is None else float(model.bonding),
        **{**values, **given},
    )


def _fused(model: FusedModel | None, document: Document) -> BondLaw | None:
    """Return the law of the fused points, if there are any."""
    with at(document, ("specimen", "fused")):
        return None if model is None else _law(model)


def _law(model: FusedModel) -> BondLaw:
    """Return the law of the fused points."""
    return BondLaw(
        fuse_gap=model.gap,
        patch_radius=model.patch_radius,
        strength=model.strength,
        shear_strength=model.shear_strength,
        locate=model.locate,
    )


def _written_law(law: BondLaw) -> dict[str, Any]:
    """Return the law of the fused points as the data of a file."""
    shear = {} if law.shear_strength is None else {"shear_strength": write(law.shear_strength, "stress")}
    return {
        "gap": write(law.fuse_gap, "length"),
        "patch_radius": write(law.patch_radius, "length"),
        "strength": write(law.strength, "stress"),
        **shear,
        "locate": law.locate,
    }
