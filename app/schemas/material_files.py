"""Materials: those of the catalogue, and those of a user's file.

A protocol that uses its own names the file next to it, and the material by its name there:

    materials: my-resins.yaml
    specimen: {material: my-resin, ...}
"""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from app.schemas.document import parse_text, read_text
from app.schemas.materials import to_materials
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import MATERIALS

if TYPE_CHECKING:
    from collections.abc import Container, Mapping

    from knitlab_core.materials import Substance

_ALLOWED: Final = "a YAML file in the protocol's folder or below it, such as my-resins.yaml"


def load_materials(path: Path) -> Mapping[str, Substance]:
    """Return the materials of a file, by name.

    Parameters
    ----------
    path : Path
        A YAML file of schema ``knitlab/materials@1``.

    Raises
    ------
    ProtocolError
        For whatever is wrong with it, in one line with file, line and column.
    """
    return MappingProxyType(to_materials(parse_text(read_text(path, "materials"), str(path), "materials")))


def known_materials(path: Path | str | None = None) -> Mapping[str, Substance]:
    """Return the catalogue, and with it the materials of a file; no file can redefine a name of the catalogue."""
    return MATERIALS if path is None else MappingProxyType({**MATERIALS, **load_materials(Path(path))})


def materials_file(protocol: Path, name: str) -> Path:
    """Return the file that a protocol means by `materials: name`.

    Parameters
    ----------
    protocol : Path
        The protocol's file.
    name : str
        A path from the protocol's folder downwards, with forward slashes.

    Raises
    ------
    SpecificationError
        For an absolute path, one that leads out of the folder, also by a link, or one that is not YAML.

    Examples
    --------
    >>> materials_file(Path("tests/p.yaml"), "own/resins.yaml").as_posix()
    'tests/own/resins.yaml'
    """
    return file_beside(protocol, name, {".yaml", ".yml"}, "materials", _ALLOWED)


def centreline_file(protocol: Path, name: str) -> Path:
    """Return the file that a protocol means by `knit: {centreline: name}`.

    Raises
    ------
    SpecificationError
        As `file_beside`.
    """
    allowed = "a CSV file in the protocol's folder or below it, such as my-knit.csv"
    return file_beside(protocol, name, {".csv"}, "centreline", allowed)


def file_beside(protocol: Path, name: str, suffixes: Container[str], field: str, allowed: str) -> Path:
    """Return a file that a protocol names by a path from its folder downwards; `suffixes` are those it may have.

    Raises
    ------
    SpecificationError
        As `materials_file`, with the `field` to blame and what is `allowed` there.
    """
    plain = PurePosixPath(name)
    outside = plain.is_absolute() or ".." in plain.parts or any(sign in name for sign in "\\:\0")
    if outside or plain.suffix not in suffixes:
        raise SpecificationError(field, name, allowed)
    folder = protocol.parent
    path = folder / plain
    if not path.resolve().is_relative_to(folder.resolve()):
        raise SpecificationError(field, name, allowed)
    return path
