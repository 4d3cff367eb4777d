"""Reading of protocols, from files, texts, data and Python: what is wrong with one is said in one line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from pydantic import ValidationError

from app.extensions import load_extensions
from app.schemas.convert import to_domain, to_yaml
from app.schemas.defaults import defaults_of
from app.schemas.document import Document, parse_text, read_text, text_of
from app.schemas.errors import Faults, ProtocolError, SweptProtocolError, in_order
from app.schemas.files_beside import (
    FilesBeside,
    FolderFiles,
    RecordedFiles,
    SentFiles,
)
from app.schemas.further import BY_MATERIAL, further_errors, is_within
from app.schemas.locate import form_errors, locate
from app.schemas.models import ProtocolModel
from app.schemas.named_files import brought_materials, named_centreline
from app.schemas.params import substitute
from app.schemas.sweep import points_of
from app.schemas.tables import with_tables
from knitlab_core.errors import SpecificationError
from rigs.protocol.bounds import as_label
from rigs.protocol.protocol import Protocol

if TYPE_CHECKING:
    from app.schemas.document import Data
    from app.schemas.sweep import Point
    from knitlab_core.materials import Substance

_UNNAMED = "test"


@dataclass(frozen=True, slots=True, kw_only=True)
class Loaded:
    """A protocol with the text it came from and that of its materials.

    Attributes
    ----------
    protocol : Protocol
        The protocol.
    document : Document
        The text it came from.
    materials : str
        Text of the materials that it brings; empty if they are in no file.
    resolved : str
        Text of the protocol with values chosen for parameters and the points of tables; empty if there are none.
    points : tuple of Point
        The points of its sweep, where it has one and none was chosen.
    defaults : Mapping
        Defaults of fields that the file leaves out, by their place in it.
    """

    protocol: Protocol
    document: Document
    materials: str = ""
    resolved: str = ""
    points: tuple[Point, ...] = ()
    defaults: Mapping[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """Return the text of the protocol, verbatim where no value and no table was put into it."""
        return self.resolved or self.document.text

    def beside(self, materials: str) -> str:
        """Return the materials file that goes with this text: the one that it came with, or none that it needs."""
        return "" if self.resolved else materials

    def one_test(self) -> Loaded:
        """Return this protocol if it is one test, with steps.

        Raises
        ------
        ProtocolError
            If it is a sweep (`SweptProtocolError`), or has no steps.
        """
        if not self.protocol.steps:
            spot = self.document.spot(("steps",))
            raise ProtocolError(self.document.path, spot, "steps", "[]", "one step or more")
        return self.no_sweep()

    def no_sweep(self) -> Loaded:
        """Return this protocol if it is not a sweep.

        Raises
        ------
        SweptProtocolError
            If it is.
        """
        if not self.points:
            return self
        first = " ".join(f"--set {name}={value}" for name, value in self.points[0].values.items())
        found, path = f"a sweep of {len(self.points)} points", self.document.path
        expected = f"one test: run all with `knitlab sweep {path}`, or one with `{first}`"
        raise SweptProtocolError(path, self.document.spot(("sweep",), key=True), "sweep", found, expected)

    def locate(self, error: SpecificationError) -> ProtocolError:
        """Return an error found later with file, line and column of the field it blames."""
        return locate(self.document, error)


Source: TypeAlias = "Path | str | Mapping[str, Any] | Protocol | Loaded"
"""Where a protocol comes from: the path of its file, its text, data as in a file, Python, or an earlier `load`."""


def load(source: Source, chosen: Mapping[str, Data] | None = None) -> Loaded:
    """Read a protocol file, or take a protocol that was built in Python.

    Parameters
    ----------
    source : Path, str, Mapping, Protocol or Loaded
        Path of the file, text of more than one line, data such as a file holds, or the protocol. One that is built in
        Python goes through its text, as a file's does. One without a name takes that of its file, with `_` for what no
        name may hold.
    chosen : Mapping, optional
        Values for some of the parameters, in the place of its own.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    SpecificationError
        If values are chosen for a `Protocol`, which has no parameters.
    """
    if isinstance(source, Protocol | Loaded):
        if chosen:
            raise SpecificationError("chosen", ", ".join(chosen), "no values: only a text has parameters")
        if isinstance(source, Protocol):
            return loads(to_yaml(source), f"<{source.name}>")
        # It may come from another process, which had them.
        load_extensions()
        return source
    if isinstance(source, Mapping) or (isinstance(source, str) and "\n" in source):
        text, name = (source, "<text>") if isinstance(source, str) else (text_of(source), "<data>")
        return _loaded(parse_text(text, name), _UNNAMED, SentFiles(), chosen or {})
    path = Path(source)
    document = parse_text(read_text(path), str(path))
    return _loaded(document, as_label(path.stem, _UNNAMED), FolderFiles(path), chosen or {})


def texts_of(path: Path) -> tuple[str, Mapping[str, str]]:
    """Return the text of a protocol file, and those of the files that it names by their names.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    """
    files = RecordedFiles(FolderFiles(path))
    document = parse_text(read_text(path), str(path))
    _loaded(document, as_label(path.stem, _UNNAMED), files, {})
    return document.text, files.texts


def loads(
    text: str,
    path: str = "<protocol>",
    *,
    name: str = _UNNAMED,
    materials: str = "",
    files: Mapping[str, str] | None = None,
) -> Loaded:
    """Read a protocol from text.

    Parameters
    ----------
    text : str
        The protocol.
    path, name : str
        Names of the file it came from, or of what it is in place of one.
    materials : str
        Text of the file that it names under `materials`.
    files : Mapping, optional
        Texts of other files that it names, by their names.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    """
    return loads_document(parse_text(text, path), name=name, materials=materials, files=files)


def loads_document(
    document: Document, *, name: str = _UNNAMED, materials: str = "", files: Mapping[str, str] | None = None
) -> Loaded:
    """Read a protocol from a document, as a sweep makes many of one.

    Parameters
    ----------
    document : Document
        The protocol.
    name : str
        Name of a protocol that gives itself none.
    materials, files
        As in `loads`.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line.
    """
    return _loaded(document, name, SentFiles(materials, files or {}), {})


def _loaded(document: Document, name: str, files: FilesBeside, chosen: Mapping[str, Data]) -> Loaded:
    """Return the protocol of a document, with the files that it names."""
    load_extensions()
    faults = Faults()
    data, unknown = substitute(document, chosen, faults)
    data, tables = with_tables(document, data, files, faults)
    try:
        model = ProtocolModel.model_validate(data)
    except ValidationError as error:
        faults.found += [one for one in form_errors(document, error) if one.spot not in unknown]
        faults.found += further_errors(document, data, faults.found, name)
        raise _all_of(faults) from error
    nothing: tuple[Mapping[str, Substance], str] = ({}, "")
    none: tuple[Point, ...] = ()
    own, text = faults.of(lambda: brought_materials(model, document, files), nothing)
    points = faults.of(lambda: points_of(model, document), none)
    before = len(faults.found)
    yarn = faults.of(lambda: named_centreline(model, document, files), None)
    if len(faults.found) > before:
        raise _all_of(faults)
    whole = faults.of(lambda: to_domain(model, document, name, own, yarn), None)
    if faults.found or whole is None:
        raise _all_of(faults)
    points = tuple(point for point in points if not set(point.values) <= set(chosen))
    protocol, defaults = whole, defaults_of(model, whole)
    put_in = [*tables, *([] if yarn is None else ["its centreline"])]
    # A sweep is read once more for each of its points; any other text must be complete without its tables.
    if not chosen and (points or not put_in):
        return Loaded(protocol=protocol, document=document, materials=text, points=points, defaults=defaults)
    said = ", ".join([*(f"{name} = {value}" for name, value in chosen.items()), *put_in])
    resolved = f"# {document.path.rpartition('/')[2]} with {said}\n{to_yaml(protocol)}"
    return Loaded(protocol=protocol, document=document, resolved=resolved, points=points, defaults=defaults)


def _all_of(faults: Faults) -> ProtocolError:
    """Return the first of all that is wrong, with the rest as its `more`."""
    every = [one for error in faults.found for one in (error, *error.more) if isinstance(one, ProtocolError)]
    for one in every:
        one.more = ()
    if any(is_within(one.field, "materials") for one in every):
        # A material with mistakes is none that the specimen could have.
        every = [one for one in every if one.field not in BY_MATERIAL]
    return in_order(every)


def from_yaml(text: str, materials: str = "") -> Protocol:
    """Return the protocol of a text, and of that of the materials file it names; the inverse of `to_yaml`."""
    return loads(text, materials=materials).protocol


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of a protocol file."""
    load_extensions()
    schema = ProtocolModel.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
