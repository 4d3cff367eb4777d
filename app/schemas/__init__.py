"""Read and write protocols: the only place that parses what a user wrote.

document  YAML to plain data that knows its places
params    `${param}` replaced by its value
values    quantities and other single values
base, models, specimen, materials  structure, published as JSON Schema
locate    errors with file, line and column
convert, convert_specimen  models to the domain's protocol, and back to text
material_files  the files that materials of one's own stand in
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from app.schemas.convert import to_domain, to_yaml
from app.schemas.document import Document, parse_text, read_text
from app.schemas.errors import ProtocolError
from app.schemas.locate import at, first_error, locate
from app.schemas.material_files import materials_file
from app.schemas.materials import to_materials
from app.schemas.models import ProtocolModel
from app.schemas.params import substitute
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from knitlab_core.materials import Material
    from rigs.protocol import Protocol

__all__ = ["Loaded", "ProtocolError", "from_yaml", "json_schema", "load", "loads", "loads_data", "to_yaml"]

_UNNAMED = "test"


@dataclass(frozen=True, slots=True, kw_only=True)
class Loaded:
    """Hold a protocol, the text it came from and that of the materials it brings, empty if they are in no file."""

    protocol: Protocol
    document: Document
    materials: str = ""

    @property
    def text(self) -> str:
        """Return the text, verbatim."""
        return self.document.text

    def locate(self, error: SpecificationError) -> ProtocolError:
        """Return an error found later, with file, line and column of what it blames."""
        return locate(self.document, error)


def load(path: Path) -> Loaded:
    """Read a protocol file; a protocol without a name takes the file's.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    """

    def beside(name: str) -> Document:
        file = materials_file(path, name)
        return parse_text(read_text(file, "materials"), str(file), "materials")

    return _loaded(parse_text(read_text(path), str(path)), path.stem, beside)


def loads(text: str, path: str = "<protocol>", *, name: str = _UNNAMED, materials: str = "") -> Loaded:
    """Read a protocol from text.

    Parameters
    ----------
    text : str
        The protocol.
    path, name : str
        What stands for the file it came from.
    materials : str
        Text of the file that it names under `materials`.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    """
    return _loaded(parse_text(text, path), name, lambda file: _given(file, materials))


def loads_data(data: dict[str, Any], text: str, *, name: str = _UNNAMED, materials: str = "") -> Loaded:
    """Read a protocol from plain data, as a sweep makes it; its errors name fields, no lines.

    Parameters
    ----------
    data : dict
        What a YAML parser finds in `text`.
    text : str
        The same, to be kept.
    name : str
        Name of a protocol that gives itself none.
    materials : str
        Text of the file that it names under `materials`.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    """
    document = Document(path="<protocol>", text=text, data=data, keys={}, values={})
    return _loaded(document, name, lambda file: _given(file, materials))


def _given(file: str, materials: str) -> Document:
    """Return the materials that came with a text."""
    if not materials:
        raise SpecificationError("materials", file, "materials by name: a text without a file has none beside it")
    return parse_text(materials, file, "materials")


def _loaded(document: Document, name: str, find: Callable[[str], Document]) -> Loaded:
    """Return the protocol of a document; `find` finds the materials that it names."""
    data = substitute(document)
    try:
        model = ProtocolModel.model_validate(data)
    except ValidationError as error:
        raise first_error(document, error) from error
    own: dict[str, Material] = {}
    text = ""
    if isinstance(model.materials, str):
        with at(document, ()):
            found = find(model.materials)
        own, text = to_materials(found), found.text
    return Loaded(protocol=to_domain(model, document, name, own), document=document, materials=text)


def from_yaml(text: str, materials: str = "") -> Protocol:
    """Return the protocol of a text, and of that of the materials file it names; the inverse of `to_yaml`."""
    return loads(text, materials=materials).protocol


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a protocol file."""
    schema = ProtocolModel.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
