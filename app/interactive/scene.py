"""The knit as a picture that can be turned: the real tube as a mesh, coloured by the strain of its yarn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from app.views.tubes import tube
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from pathlib import Path

    from app.records.reader import RunReader
    from app.views.tubes import Tube
    from rigs.axes import FloatArray, IntArray
    from rigs.record import Frame

SIDES = 10
"""Corners of a tube's cross-section."""

PER_SPAN = 2
"""Rings of the mesh to a node of the yarn."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A picture that can be turned; in a notebook it shows itself.

    Attributes
    ----------
    figure : plotly.graph_objects.Figure
        The picture.
    """

    figure: Any

    def __repr__(self) -> str:
        """Return what is shown."""
        return f"Scene({self.figure.layout.title.text})"

    def _repr_mimebundle_(self, *given: object, **more: object) -> Any:  # noqa: ANN401 (IPython's)
        return self.figure._repr_mimebundle_(*given, **more)

    def save(self, path: Path | str) -> None:
        """Write a page that shows the picture without the network."""
        self.figure.write_html(str(path), include_plotlyjs=True)


def scene_of(record: RunReader, at: float | None) -> Scene:
    """Return the knit at the stored shape nearest to a strain on the way up, or at the largest.

    Raises
    ------
    SpecificationError
        If plotly is not installed, or no shape is stored.
    """
    try:
        from plotly import graph_objects  # noqa: PLC0415 (optional)
    except ImportError as error:
        raise SpecificationError("plotly", "not installed", "pip install 'knitlab[notebook]'") from error
    frame = shape_at(record, at)
    edges = frame.axial_strain
    drawn = tube(frame.nodes, 100.0 * edges, record.size.fibre_radius, PER_SPAN, strands=record.strands)
    corners, faces = mesh_of(drawn)
    mesh = graph_objects.Mesh3d(
        **dict(zip("xyz", corners.T, strict=True)),
        **dict(zip("ijk", faces.T, strict=True)),
        intensity=np.repeat(drawn.values, SIDES),
        colorscale="RdBu_r",
        cmid=0.0,
        colorbar={"title": "axial strain [%]"},
        flatshading=False,
        hoverinfo="skip",
    )
    strain = ", ".join(f"{axis} {100.0 * value:.1f} %" for axis, value in frame.strain.items())
    figure = graph_objects.Figure(mesh)
    figure.update_layout(
        title=f"{record.provenance.get('name', record.path.parent.name)}: {strain}",
        scene={"aspectmode": "data", **{f"{axis}axis": {"title": f"{axis} [mm]"} for axis in "xyz"}},
        margin={"l": 0, "r": 0, "t": 40, "b": 0},
    )
    return Scene(figure)


def shape_at(record: RunReader, at: float | None) -> Frame:
    """Return the stored shape nearest to a strain on the way up; by default that of the largest strain.

    Raises
    ------
    SpecificationError
        If no shape is stored.
    """
    frames = record.frames()
    if not frames:
        raise SpecificationError("run.shapes", f"none in {record.path}", "a run with a stored shape")
    strains = np.array([max(frame.strain.values(), default=0.0) for frame in frames])
    peak = int(np.argmax(strains))
    return frames[peak] if at is None else frames[int(np.argmin(np.abs(strains[: peak + 1] - at)))]


def mesh_of(tubes: Tube) -> tuple[FloatArray, IntArray]:
    """Return corners (P SIDES, 3) [mm] and triangles (T, 3) of tubes around P points."""
    angles = np.arange(SIDES) * (2.0 * np.pi / SIDES)
    corners, faces, first = [], [], 0
    for points in np.split(tubes.points, np.cumsum(tubes.sizes)[:-1]):
        normals, binormals = _turned_along(points)
        ring = np.cos(angles)[None, :, None] * normals[:, None] + np.sin(angles)[None, :, None] * binormals[:, None]
        corners.append((points[:, None] + tubes.radius * ring).reshape(-1, 3))
        here = first + np.arange(len(points) - 1)[:, None] * SIDES + np.arange(SIDES)
        beside = np.roll(here, -1, axis=1)
        faces.append(
            np.stack([here, beside, here + SIDES, beside, beside + SIDES, here + SIDES], axis=-1).reshape(-1, 3)
        )
        first += len(points) * SIDES
    return np.concatenate(corners), np.concatenate(faces)


def _turned_along(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return normals and binormals along a curve (n, 3) that turn no more than it does."""
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    normals = np.empty_like(points)
    normal = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    for place, tangent in enumerate(tangents):
        normal = normal - normal @ tangent * tangent
        normal = normal / np.linalg.norm(normal)
        normals[place] = normal
    return normals, np.cross(tangents, normals)
