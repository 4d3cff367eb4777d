"""Materials: those of the catalogue, and those of a user's file.

A protocol that uses its own names the file next to it, and the material by its name there:

    materials: my-resins.yaml
    specimen: {material: my-resin, ...}
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from app.schemas.document import parse_text, read_text
from app.schemas.materials import to_materials
from knitlab_core.materials import MATERIALS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.materials import Substance


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
