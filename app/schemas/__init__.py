"""Read and write protocols: the only place that parses what a user wrote.

document  YAML to plain data that knows its places
params    `${param}` replaced by its value
values    quantities and other single values
models    structure, published as JSON Schema
locate    errors with file, line and column
convert   models to the domain's protocol, and back to text
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from app.schemas.convert import to_domain, to_yaml
from app.schemas.document import parse_text, read_text
from app.schemas.errors import ProtocolError
from app.schemas.locate import first_error, locate
from app.schemas.models import ProtocolModel
from app.schemas.params import substitute

if TYPE_CHECKING:
    from pathlib import Path

    from app.schemas.document import Document
    from knitlab_core.errors import SpecificationError
    from rigs.protocol import Protocol

__all__ = ["Loaded", "ProtocolError", "from_yaml", "json_schema", "load", "loads", "to_yaml"]

_UNNAMED = "test"


@dataclass(frozen=True, slots=True, kw_only=True)
class Loaded:
    """Hold a protocol and the text it came from."""

    protocol: Protocol
    document: Document

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
    return loads(read_text(path), str(path), name=path.stem)


def loads(text: str, path: str = "<protocol>", *, name: str = _UNNAMED) -> Loaded:
    """Read a protocol from text; `path` and `name` stand for the file it came from.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    """
    document = parse_text(text, path)
    data = substitute(document)
    try:
        model = ProtocolModel.model_validate(data)
    except ValidationError as error:
        raise first_error(document, error) from error
    return Loaded(protocol=to_domain(model, document, name), document=document)


def from_yaml(text: str) -> Protocol:
    """Return the protocol of a text; the inverse of `to_yaml`."""
    return loads(text).protocol


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a protocol file."""
    schema = ProtocolModel.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
