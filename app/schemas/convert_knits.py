"""Conversion of the knit of a file, by its values or its centreline, and back to the data of a file."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, Final

from app.schemas.centrelines import read_centreline, written_centreline
from app.schemas.locate import at
from app.schemas.specimen import CentrelineModel, FilamentModel, StitchModel, VolumetricStitchModel
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import (
    Filament,
    OwnCentreline,
    Stitch,
    VolumetricStitch,
    fabric_named,
    fabric_names,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from app.schemas.base import Model
    from app.schemas.document import Document
    from app.schemas.files_beside import NamedText
    from app.schemas.values import Measure
    from knitlab_core.knits import Fabric


def knit_by_values(knit: Model, loop_width: float, document: Document, text: NamedText | None) -> Fabric:
    """Return a fabric that is given by its values."""
    if isinstance(knit, CentrelineModel):
        return own_centreline(knit, loop_width, document, text)
    with at(document, ("specimen", "knit")):
        return _READERS[type(knit)](knit, loop_width)


def written_knit(fabric: Fabric) -> object:
    """Return a fabric as the data of a file: its values, or its name where it has none in a file.

    Raises
    ------
    SpecificationError
        If they cannot, and it has no name.
    """
    write_values = _WRITERS.get(type(fabric))
    if write_values is not None:
        return write_values(fabric)
    name = next((name for name in fabric_names() if fabric_named(name) == fabric), None)
    if name is None:
        raise SpecificationError("knit", fabric.description, "a fabric that has a name: register it")
    return name


def _filament(model: FilamentModel, loop_width: float) -> Fabric:
    """Return a filament in its lengths."""
    return Filament(fibre_radius=0.5 * in_loop_widths(model.filament, loop_width))


def own_centreline(model: CentrelineModel, loop_width: float, document: Document, text: NamedText | None) -> Fabric:
    """Return the fabric of a centreline, whose text is in a file beside the protocol or in the protocol itself."""
    with at(document, ("specimen", "knit")):
        spot = document.spot(("specimen", "knit", "centreline"))
        path, content, before = (document.path, model.centreline, spot.line) if text is None else (*text, 0)
        return read_centreline(
            content,
            path,
            before=before,
            unit=model.unit,
            loop_width=loop_width,
            fibre_radius=in_loop_widths(model.fibre_radius, loop_width),
        )


def _stitch(model: StitchModel, loop_width: float) -> Fabric:
    """Return a planar stitch in loop widths."""
    return Stitch(**_numbers(model, loop_width))


def _volumetric_stitch(model: VolumetricStitchModel, loop_width: float) -> Fabric:
    """Return a volumetric stitch in loop widths."""
    return VolumetricStitch(**_numbers(model, loop_width))


def _numbers(model: StitchModel | VolumetricStitchModel, loop_width: float) -> dict[str, float]:
    """Return the numbers of a stitch in loop widths."""
    if model.curvature.metres:
        raise SpecificationError("curvature", "a length", "a pure number, such as 1.5")
    return {name: in_loop_widths(getattr(model, name), loop_width) for name in type(model).model_fields}


def _written_filament(filament: Filament) -> dict[str, float]:
    """Return a filament as the data of a file."""
    return {"filament": 2.0 * filament.fibre_radius}


def _written_own(own: OwnCentreline) -> dict[str, object]:
    """Return a centreline as the data of a file that needs no other."""
    return {"centreline": written_centreline(own), "fibre_radius": own.fibre_radius}


def _written_stitch(stitch: Stitch | VolumetricStitch) -> dict[str, float]:
    """Return a stitch by its values."""
    return {field.name: getattr(stitch, field.name) for field in fields(stitch)}


_READERS: Final[Mapping[type, Callable[[Any, float], Fabric]]] = {
    FilamentModel: _filament,
    StitchModel: _stitch,
    VolumetricStitchModel: _volumetric_stitch,
}
"""What makes a fabric of the values of a file and the loop width [m], by their model."""


_WRITERS: Final[Mapping[type, Callable[[Any], object]]] = {
    Filament: _written_filament,
    OwnCentreline: _written_own,
    Stitch: _written_stitch,
    VolumetricStitch: _written_stitch,
}
"""What writes the values of a fabric; others are written by name."""


def in_loop_widths(measure: Measure, loop_width: float) -> float:
    """Return a stitch value in loop widths."""
    if loop_width <= 0.0:
        raise SpecificationError("loop", f"{loop_width:g} m", "a length above 0")
    return measure.value / loop_width if measure.metres else measure.value
