"""Files of a knit's surface for a printer: binary STL and 3MF, both in mm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias

import trimesh

from app.records.folder import write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from app.printing.fibres import Fibre

Format: TypeAlias = Literal["stl", "3mf"]


def write_surface(fibres: Sequence[Fibre], path: Path, kind: Format) -> Path:
    """Write the fibres to a file.

    Parameters
    ----------
    fibres : sequence of Fibre
        What to print.
    path : Path
        Where the file shall stand.
    kind : {'stl', '3mf'}
        STL holds triangles alone, all fibres in one body, and names no unit: mm is what is read into it. 3MF
        says millimeter and keeps one object per fibre.

    Returns
    -------
    Path
        The same path.
    """
    scene = trimesh.Scene()
    for number, fibre in enumerate(fibres, start=1):
        scene.add_geometry(fibre.mesh, geom_name=f"fibre {number}", node_name=f"fibre {number}")
    content = scene.export(file_type=kind)
    return write_whole(path, [content])
