"""Range checks of a protocol that also has errors of form, so that all are reported at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from pydantic import ValidationError

from app.schemas.convert import to_domain
from app.schemas.errors import ProtocolError, nearest
from app.schemas.models import SCHEMA, ProtocolModel
from app.schemas.yarns import is_measured
from knitlab_core.knits import fabric_named, fabric_names

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.schemas.document import Data, Document
    from knitlab_core.errors import SpecificationError

_SPECIMEN: Final[dict[str, Data]] = {"knit": "stockinette-default", "loop": "1 mm", "material": "RGD8530-DM"}
_LOOPS: Final[Mapping[bool, Data]] = {False: [1, 1], True: [1, 1, 1]}
_STEP: Final[Data] = {"zero": {"channels": ["force"]}}
_LEFT_OUT: Final = frozenset({"materials", "sample", "sweep"})

#: Fields whose values only the rig, the knit and the material decide.
_BY_RIG: Final = ("mount", "others", "specimen.knit", "log.clock_offset", "log.clock_skew")
_BY_KNIT: Final = (
    "mount",
    "specimen.knit",
    "specimen.loops",
    "specimen.grips",
    "specimen.hook",
    "specimen.yarn",
    "specimen.laid_in",
    "specimen.edges",
    "specimen.fused",
)
_BY_COUNT: Final = ("specimen.grips", "extensometer")
BY_MATERIAL: Final = ("specimen.material", "specimen.viscoelastic", "specimen.yield", "specimen.rupture")


def further_errors(
    document: Document, data: Data, found: Sequence[SpecificationError], name: str
) -> list[ProtocolError]:
    """Return what is out of range in the parts of a protocol that have no mistake of form.

    Parameters
    ----------
    document : Document
        Its text.
    data : Data
        Its data, parameters replaced.
    found : sequence of SpecificationError
        The mistakes of form.
    name : str
        Name of a protocol that gives itself none.
    """
    if not isinstance(data, dict):
        return []
    fields = [error.field for error in found]
    rigless = "rig" not in data or "rig" in fields
    specimen = data.get("specimen")
    knit = specimen.get("knit") if isinstance(specimen, dict) else None
    if isinstance(knit, dict) and "centreline" in knit:
        # The file that it may be in is not available here.
        fields.append("specimen.knit")
    knitless = any(is_within(field, "specimen.knit") for field in fields)
    try:
        to_domain(ProtocolModel.model_validate(_mended(data, fields, rigless=rigless)), document, name, {})
    except ValidationError:
        return []
    except ProtocolError as error:
        every = [one for one in (error, *error.more) if isinstance(one, ProtocolError)]
    else:
        return []
    stood_in = [*fields, *(_BY_RIG if rigless else ()), *(_BY_KNIT if knitless else ())]
    # How many stitches there are for clamps and pins is not known here.
    stood_in += _BY_COUNT if any(is_within(field, "specimen") for field in fields) else ()
    # The materials of the file have not been read here.
    stood_in += BY_MATERIAL if "materials" in data else ()
    for one in every:
        one.more = ()
    return [
        one
        for one in every
        if not any(is_within(one.field, part) for part in stood_in)
        and not (rigless and one.field.endswith(".axes"))
        and not (one.found == "nothing" and _is_misspelt(one.field, found))
    ]


def _mended(data: dict[str, Data], fields: Sequence[str], *, rigless: bool) -> Data:
    """Return data of the right form: parts with errors are left out or substituted."""
    specimen = _good(data.get("specimen"), fields, "specimen.")
    if "knit" not in specimen:
        specimen.pop("loops", None)
    if is_measured(specimen.get("yarn")):
        specimen.setdefault("material", None)
    knit = specimen.get("knit")
    volumetric = isinstance(knit, str) and knit in fabric_names() and "P" in fabric_named(knit).axes
    steps = data.get("steps")
    numbered = dict(enumerate(steps)) if isinstance(steps, list) else {}
    fine = [not any(is_within(field, f"steps[{number}]") for field in fields) for number in numbered]
    mended: dict[str, Data] = {
        **_good({key: value for key, value in data.items() if key not in _LEFT_OUT}, fields),
        "schema": SCHEMA,
        "specimen": {**_SPECIMEN, "loops": _LOOPS[volumetric], **specimen},
        "log": _good(data.get("log"), fields, "log."),
        "steps": [step if good else _STEP for step, good in zip(numbered.values(), fine, strict=True)] or [_STEP],
    }
    return {**mended, "rig": "biaxial-hook", "others": "hold", "mount": None} if rigless else mended


def _good(values: Data, fields: Sequence[str], within: str = "") -> dict[str, Data]:
    """Return the values of a mapping that have no error of form."""
    named = values if isinstance(values, dict) else {}
    return {key: value for key, value in named.items() if not any(is_within(field, within + key) for field in fields)}


def _is_misspelt(field: str, found: Sequence[SpecificationError]) -> bool:
    """Return whether an unknown field is a misspelling of one that is missing."""
    unknown = (error.field for error in found if error.found == "an unknown field")
    return any(nearest(one, [field]) for one in unknown)


def is_within(field: str, part: str) -> bool:
    """Return whether a field is a given part of a protocol, or inside it."""
    return field == part or field.startswith((f"{part}.", f"{part}["))
