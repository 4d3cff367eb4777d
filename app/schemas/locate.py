"""Translation of errors of pydantic and the domain into one line with the place in the file."""

from __future__ import annotations

import re
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

from app.schemas import materials
from app.schemas.base import BRANCH
from app.schemas.document import dotted
from app.schemas.errors import ProtocolError, in_order, nearest, shown
from app.schemas.here import allowed_here, axis_meant
from app.schemas.models import MODELS, NOT_YET, ProtocolModel
from app.schemas.specimen import (
    CENTRELINE,
    FILAMENT,
    MEASURED,
    VOLUMETRIC,
    CentrelineModel,
    FilamentModel,
    VolumetricStitchModel,
)
from app.schemas.step_parts import CycleLogModel, StepLogModel
from app.schemas.steps import STEPS
from app.schemas.yarns import CompressionModel, MeasuredYarnModel
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import fabric_names
from rigs.axes import AXES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from pydantic import ValidationError

    from app.schemas.base import Model
    from app.schemas.document import Document, Place

# Fields whose name in the file differs from the domain's.
_FILE_NAMES: Final = {"loop_width": "loop", "rows": "loops", "layers": "loops", "duration": "for", "fuse_gap": "gap"}
_KNITS: Final[Mapping[str, type[Model]]] = {
    VOLUMETRIC: VolumetricStitchModel,
    FILAMENT: FilamentModel,
    CENTRELINE: CentrelineModel,
}
_PART: Final = re.compile(r"[^.\[\]]+")
_WORD: Final = re.compile(r"'([^']*)'")


def form_errors(document: Document, error: ValidationError) -> list[ProtocolError]:
    """Return all errors of pydantic in a protocol, in our words."""
    return [
        materials.translate(document, details) if _in_material(details) else _translate(document, details)
        for details in materials.own_mistakes(error)
    ]


def locate(document: Document, error: SpecificationError, place: Place = ()) -> ProtocolError:
    """Return an error of the domain with the spot of the field it blames.

    Parameters
    ----------
    document : Document
        The protocol's text.
    error : SpecificationError
        Its `field` is looked for below `place`, then in the specimen.
    place : tuple
        Where the value that raised it is described.
    """
    return in_order([_located(document, one, place) for one in (error, *error.more)])


def _located(document: Document, error: SpecificationError, place: Place) -> ProtocolError:
    """Return one error with its line and column."""
    if isinstance(error, ProtocolError):
        return error
    names = tuple(int(part) if part.isdigit() else _FILE_NAMES.get(part, part) for part in _PART.findall(error.field))
    roots = (place, ("specimen",), ("specimen", "knit"))
    tails = (names, names[-1:])
    candidates = [(*root, *tail) for tail in tails for root in roots]
    found = next((candidate for candidate in candidates if candidate in document.values), None)
    # A default has no place of its own; an error of shape is the knit's.
    own = place or names[0] in ProtocolModel.model_fields
    field = found or ((*place, *names) if own else ("specimen", "knit"))
    wording = error.found if isinstance(error.found, str) else shown(error.found)
    hint = ""
    if names == ("knit",) and isinstance(error.found, str) and error.expected.startswith("one of "):
        hint = nearest(error.found, allowed_here(document.data, field, fabric_names()))
    return ProtocolError(document.path, document.spot(field), dotted(field), wording, f"{error.expected}{hint}")


@contextmanager
def at(document: Document, place: Place) -> Iterator[None]:
    """Locate errors of the domain raised in this block at a mapping of the file."""
    try:
        yield
    except SpecificationError as error:
        raise locate(document, error, place) from error


def _in_material(details: Mapping[str, Any]) -> bool:
    """Return whether an error is in a material that the protocol itself defines."""
    return details["loc"][:1] == ("materials",) and len(details["loc"]) > 2


def _translate(document: Document, details: Mapping[str, Any]) -> ProtocolError:
    """Return one of pydantic's errors in our words."""
    place: Place = tuple(part for part in details["loc"] if not str(part).startswith(BRANCH))
    place = tuple("schema" if part == "schema_id" else part for part in place)
    kind, found = details["type"], details["input"]
    models: Mapping[str, type[Model]] = MODELS
    for branch, model in _KNITS.items():
        if branch in details["loc"]:
            models = {**MODELS, "knit": model}
    if MEASURED in details["loc"]:
        models = {**MODELS, "yarn": MeasuredYarnModel, "compression": CompressionModel}
    if place[:1] == ("steps",):
        models = {**MODELS, "log": CycleLogModel if "cycle" in place else StepLogModel}
    path, field = document.path, dotted(place) or "protocol"
    if kind == "extra_forbidden":
        known = allowed_here(document.data, ("",), _fields(place[:-1], models))
        hint = _not_yet(place[-1]) or nearest(str(place[-1]), known)
        spot = document.spot(place, key=True)
        return ProtocolError(path, spot, field, "an unknown field", f"{', '.join(known)}{hint}")
    spot = document.spot(place)
    if kind == "missing":
        return ProtocolError(path, spot, field, "nothing", _phrase(place, models), missing=True)
    if kind.startswith("union_tag"):
        return _unknown_step(document, place, found)
    if kind == "literal_error":
        return _unknown_word(document, place, found, details["ctx"]["expected"])
    if kind == "refused":
        return ProtocolError(path, spot, field, shown(found), details["ctx"]["expected"])
    return ProtocolError(path, spot, field, shown(found), _phrase(place, models))


def _unknown_word(document: Document, place: Place, found: object, literal: str) -> ProtocolError:
    """Return the error of a word that is none of a list; what another rig allows is not offered."""
    words = _WORD.findall(literal)
    here = allowed_here(document.data, place, words)
    meant = axis_meant(str(found), here) if words == list(AXES) else None
    hint = f" (did you mean {meant}?)" if meant else _not_yet(found) or nearest(str(found), here)
    # The rig itself may be wrong, so all are named.
    listed = " or ".join(", ".join(words if place == ("rig",) else here or words).rsplit(", ", 1))
    return ProtocolError(document.path, document.spot(place), dotted(place), shown(found), f"{listed}{hint}")


def _unknown_step(document: Document, place: Place, found: object) -> ProtocolError:
    """Return the error of a step that is none of the known ones."""
    expected = f"a step: {', '.join(STEPS)}"
    if isinstance(found, dict) and len(found) == 1:
        name = str(next(iter(found)))
        spot = document.spot((*place, name), key=True)
        hint = _not_yet(name) or nearest(name, STEPS)
        return ProtocolError(document.path, spot, dotted(place), f"step {name!r}", f"{expected}{hint}")
    if isinstance(found, dict):
        wording = f"a mapping of {len(found)} keys"
        return ProtocolError(
            document.path, document.spot(place), dotted(place), wording, f"one key, the name of {expected}"
        )
    return ProtocolError(document.path, document.spot(place), dotted(place), shown(found), expected)


def _not_yet(name: object) -> str:
    """Return the remark on a word of the language that no rig supports yet."""
    return f" ({name} is not available yet)" if isinstance(name, str) and name in NOT_YET else ""


def _fields(place: Place, models: Mapping[str, type[Model]]) -> dict[str, str]:
    """Return the fields of the mapping at a place, with what each allows."""
    name = str(place[-1]) if place else ""
    model = models.get(name)
    if model is None:
        return {}
    return {field.alias or key: field.description or "a value" for key, field in model.model_fields.items()}


def _phrase(place: Place, models: Mapping[str, type[Model]]) -> str:
    """Return the phrase that describes what is allowed at a place."""
    if not place:
        return "a mapping of fields: " + ", ".join(_fields((), models))
    last = place[-1]
    if isinstance(last, int):
        if "compression" in place:
            return "a compression and a force by length, such as [0.1 mm, 0.2 mN/mm]"
        return {"steps": "a step", "loops": "a whole number"}.get(str(place[-2]), "a name")
    if last in STEPS:
        return "a mapping of fields: " + ", ".join(_fields(place, models))
    free = {
        "params": "a number or a text",
        "sweep": "a list of values, such as [0, 0.1]",
        "of": "the two ends of a range",
    }
    return _fields(place[:-1], models).get(last, free.get(str(place[0]), "a value"))
