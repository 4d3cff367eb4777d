"""Slicing of a knit's surface into the layers of a printer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import trimesh
from trimesh.intersections import mesh_plane

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from app.printing.fibres import Fibre
    from rigs.axes import FloatArray

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layer:
    """Section through the middle of a layer.

    Attributes
    ----------
    number : int
        From 0, at the tray.
    height : float
        Of its middle above the tray [mm].
    outline : FloatArray
        Pieces of the outline (k, 2, 2): from point, to point, material on their left [mm].
    """

    number: int
    height: float
    outline: FloatArray

    @property
    def area(self) -> float:
        """Return the area of the section, half the sum of ``x dy - y dx`` around it [mm²]."""
        start, end = self.outline[:, 0], self.outline[:, 1]
        return 0.5 * float(np.sum(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]))


class _Stack:
    """Triangles of a mesh sorted by height, so that a cut visits few of them."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        self._vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        heights = self._vertices[:, 2][faces]
        lowest = heights.min(axis=1)
        order = np.argsort(lowest)
        self._faces, self._low, self._top = faces[order], lowest[order], heights.max(axis=1)[order]
        self._tallest = float((self._top - self._low).max())

    def cut(self, height: float) -> FloatArray:
        """Return the outline (k, 2, 2) at a height, with the material on its left."""
        first, last = np.searchsorted(self._low, height - self._tallest), np.searchsorted(self._low, height, "right")
        near = self._faces[first:last][self._top[first:last] >= height]
        if not len(near):
            return np.empty((0, 2, 2))
        used, renamed = np.unique(near, return_inverse=True)
        band = trimesh.Trimesh(self._vertices[used], renamed.reshape(-1, 3), process=False)
        lines, cut = mesh_plane(band, _UP, height * _UP, return_faces=True)
        return _turned(lines[:, :, :2], _outward(np.asarray(band.triangles)[cut]))


class Slicer:
    """Slicer of fibres at any height; triangles are sorted by height once.

    Parameters
    ----------
    fibres : sequence of Fibre
        What to cut, standing on the tray, z = 0.
    layer_height : float
        Height of a layer [mm].
    """

    def __init__(self, fibres: Sequence[Fibre], layer_height: float) -> None:
        self._stacks = [_Stack(fibre.mesh) for fibre in fibres]
        self.layer_height = layer_height
        extent = max(float(fibre.mesh.bounds[1, 2]) for fibre in fibres)
        # The last layer is the last one whose middle is inside.
        self.count = max(1, math.ceil(extent / layer_height - 0.5))

    def layer(self, number: int) -> Layer:
        """Cut through the middle of a layer."""
        height = (number + 0.5) * self.layer_height
        outlines = [stack.cut(height) for stack in self._stacks]
        return Layer(number=number, height=height, outline=np.concatenate(outlines))

    def every(self, step: int) -> range:
        """Return the numbers of the layers in the middle of each `step` of them."""
        return range(min(step // 2, self.count - 1), self.count, step)


def sliced_volume(
    slicer: Slicer, most_layers: int, progress: Callable[[float], None]
) -> tuple[float, NDArray[np.int64], FloatArray]:
    """Sum the areas of layers times their height, a volume independent of the mesh's volume formula.

    Parameters
    ----------
    slicer : Slicer
        The fibres.
    most_layers : int
        At most about so many are cut, evenly spread.
    progress : callable
        Told the share done [1].

    Returns
    -------
    volume : float
        [mm³].
    numbers, areas : array
        The layers that were cut and their areas [mm²].
    """
    step = max(1, math.ceil(slicer.count / most_layers))
    numbers = np.array(slicer.every(step))
    areas = np.array(list(_areas(slicer, numbers, progress)))
    return float(areas.sum()) * step * slicer.layer_height, numbers, areas


def _areas(slicer: Slicer, numbers: NDArray[np.int64], progress: Callable[[float], None]) -> Iterator[float]:
    for done, number in enumerate(numbers, start=1):
        yield slicer.layer(int(number)).area
        progress(done / len(numbers))


def _outward(triangles: FloatArray) -> FloatArray:
    """Return the horizontal part of the triangles' outward normals, of any length, (k, 3, 3) -> (k, 2)."""
    normal: FloatArray = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return normal[:, :2]


def _turned(lines: FloatArray, outward: FloatArray) -> FloatArray:
    """Orient pieces of outline (k, 2, 2) so that outward is to their right."""
    way = lines[:, 1] - lines[:, 0]
    wrong = way[:, 1] * outward[:, 0] - way[:, 0] * outward[:, 1] < 0.0
    return np.where(wrong[:, None, None], lines[:, ::-1], lines)
