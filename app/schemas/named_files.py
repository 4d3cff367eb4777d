"""Files that a protocol names, read: its materials and its centreline; `tables` has those of points."""

from __future__ import annotations

from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING

from app.schemas.document import parse_text
from app.schemas.files_beside import CENTRELINE, MATERIALS, NamedText
from app.schemas.locate import at
from app.schemas.materials import to_materials
from app.schemas.specimen import CentrelineModel

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Document
    from app.schemas.files_beside import FilesBeside
    from app.schemas.models import ProtocolModel
    from knitlab_core.materials import Substance


def brought_materials(
    model: ProtocolModel, document: Document, files: FilesBeside
) -> tuple[Mapping[str, Substance], str]:
    """Return the materials of the file that a protocol names, and their text."""
    if not isinstance(model.materials, str):
        return {}, ""
    with at(document, ()):
        path, text = files.read(model.materials, MATERIALS)
        return _read_materials(text, path), text


def named_centreline(model: ProtocolModel, document: Document, files: FilesBeside) -> NamedText | None:
    """Return the centreline that a protocol names, if it names one."""
    knit = model.specimen.knit
    if not isinstance(knit, CentrelineModel) or "\n" in knit.centreline:
        return None
    with at(document, ("specimen", "knit")):
        return files.read(knit.centreline, CENTRELINE)


@lru_cache(maxsize=4)
def _read_materials(text: str, path: str) -> Mapping[str, Substance]:
    """Return the materials of a text; read once, for every job of a sweep brings the same."""
    return MappingProxyType(to_materials(parse_text(text, path, "materials")))
