"""Turn the specimen of a file into the domain's, and back into the data of a file."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import TYPE_CHECKING, Any, cast

from app.schemas.errors import Faults
from app.schemas.locate import at
from app.schemas.specimen import FilamentModel, StitchModel
from app.schemas.units import write
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import Filament, Stitch, VolumetricStitch, Yarn, same_area
from knitlab_core.materials import DEFAULT_FRICTION, MATERIALS, material_named
from rigs.protocol.specimen import MESHES, NAMED_KNITS, SpecimenSpec

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Document
    from app.schemas.specimen import FusedModel, SpecimenModel, VolumetricStitchModel, YarnModel
    from app.schemas.values import Measure
    from knitlab_core.materials import Material


def to_specimen(model: SpecimenModel, document: Document, own: Mapping[str, Material]) -> SpecimenSpec:
    """Return the specimen a model describes; inline stitch values may be lengths.

    Parameters
    ----------
    model : SpecimenModel
        The file's content.
    document : Document
        Its text, for the spots of errors.
    own : Mapping
        Materials that the protocol brings.

    Raises
    ------
    ProtocolError
        For a value out of its range.
    """
    faults = Faults()
    knit = model.knit if isinstance(model.knit, str) else _stitch(model.knit, model.loop, document)
    rows, loops, *layers = model.loops
    fused = faults.of(lambda: _fused(model.fused, document), None)
    # An unknown name is refused by the specimen, with those that are known.
    stitch = NAMED_KNITS.get(knit) if isinstance(knit, str) else knit
    known = {**MATERIALS, **own}
    substance = faults.of(lambda: material_named(model.material, "material", known), None)

    def whole() -> SpecimenSpec:
        return SpecimenSpec(
            knit=knit,
            rows=rows,
            loops=loops,
            layers=layers[0] if layers else 1,
            loop_width=model.loop,
            # Another stands in for one that is not known, to look for more mistakes.
            material=next(iter(known)) if substance is None else substance if model.material in own else model.material,
            friction=DEFAULT_FRICTION.value if model.friction is None else model.friction,
            nodes_per_loop=nodes,
            rest_shape=model.rest_shape,
            yarn=yarn,
            fused=fused,
            viscoelastic=model.viscoelastic and substance is not None,
            rupture="off" if substance is None else model.rupture,
        )

    with at(document, ("specimen",)):
        nodes = faults.of(lambda: _nodes_per_loop(model), MESHES["default"])
        yarn = faults.of(lambda: _made_yarn(model, stitch), None)
        spec = faults.of(whole, None)
        if spec is not None and bool(layers) != ("P" in spec.axes):
            allowed = "[rows, loops in a row, layers]" if not layers else "[rows, loops in a row] of a planar knit"
            faults.found.append(SpecificationError("loops", model.loops, allowed))
        faults.raise_any()
    return cast("SpecimenSpec", spec)


def _made_yarn(model: SpecimenModel, stitch: Stitch | VolumetricStitch | Filament | None) -> Yarn | None:
    """Return the yarn of fibres that a specimen asks for, if it does and its knit is known."""
    return None if model.yarn is None or stitch is None else _yarn(model.yarn, stitch.fibre_radius, model.loop)


def _nodes_per_loop(model: SpecimenModel) -> int:
    """Return how finely a yarn is divided: by name or by number, not by both."""
    if model.nodes_per_loop is None:
        return MESHES["default" if model.mesh is None else model.mesh]
    if model.mesh is not None:
        raise SpecificationError("mesh", f"{model.mesh} and nodes_per_loop", "one of the two")
    return model.nodes_per_loop


def written(spec: SpecimenSpec, hook: str, pole_friction: float | None) -> dict[str, Any]:
    """Return a specimen as the data of a file."""
    knit: object = spec.knit
    if isinstance(spec.knit, Filament):
        knit = {"filament": 2.0 * spec.knit.fibre_radius}
    elif not isinstance(spec.knit, str):
        knit = {field.name: getattr(spec.knit, field.name) for field in fields(spec.knit)}
    return {
        "knit": knit,
        "loops": [spec.rows, spec.loops, *([spec.layers] if "P" in spec.axes else [])],
        "loop": write(spec.loop_width, "length"),
        "material": spec.substance.name,
        "friction": spec.friction,
        "hook": hook,
        **({} if pole_friction is None else {"pole_friction": pole_friction}),
        "nodes_per_loop": spec.nodes_per_loop,
        "rest_shape": spec.rest_shape,
        **({} if spec.yarn is None else {"yarn": {one.name: getattr(spec.yarn, one.name) for one in fields(Yarn)}}),
        **({} if spec.fused is None else {"fused": _written_law(spec.fused)}),
        "viscoelastic": "on" if spec.viscoelastic else "off",
        "rupture": spec.rupture,
    }


def _stitch(
    model: StitchModel | VolumetricStitchModel | FilamentModel, loop_width: float, document: Document
) -> Stitch | VolumetricStitch | Filament:
    """Return a stitch in loop widths, or a filament in its lengths."""
    if isinstance(model, FilamentModel):
        with at(document, ("specimen", "knit")):
            return Filament(fibre_radius=0.5 * _in_loop_widths(model.filament, loop_width))
    kind = Stitch if isinstance(model, StitchModel) else VolumetricStitch
    given = {name: getattr(model, name) for name in type(model).model_fields}
    with at(document, ("specimen", "knit")):
        if model.curvature.metres:
            raise SpecificationError("curvature", "a length", "a pure number, such as 1.5")
        return kind(**{name: _in_loop_widths(one, loop_width) for name, one in given.items()})


def _in_loop_widths(measure: Measure, loop_width: float) -> float:
    """Return a stitch value in loop widths."""
    if loop_width <= 0.0:
        raise SpecificationError("loop", f"{loop_width:g} m", "a length above 0")
    return measure.value / loop_width if measure.metres else measure.value


def _yarn(model: YarnModel, single_radius: float, loop_width: float) -> Yarn:
    """Return a yarn in loop widths: unless told otherwise its fibres have the stitch's own area and lie just apart."""
    given = {
        name: _in_loop_widths(measure, loop_width)
        for name in ("fibre_radius", "winding_radius")
        if (measure := getattr(model, name)) is not None
    }
    count = model.fibres
    values: dict[str, Any] = {"fibre_radius": single_radius, "winding_radius": 0.0}
    if count > 0:
        radius = given.get("fibre_radius", single_radius / math.sqrt(count))
        values = {"fibre_radius": radius, "winding_radius": same_area(radius * math.sqrt(count), count).winding_radius}
    return Yarn(
        fibres=count,
        model=model.model,
        twist=float(model.twist),
        phase=float(model.phase),
        bonding=float(model.bonding),
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
