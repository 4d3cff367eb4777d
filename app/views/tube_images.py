"""Images of tubes from above: exact and to scale, coloured by a value, lit, with shade where strands cross."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Final

import numpy as np

from app.views.raster import NOTHING, draw_tube, joined, reaches_of, tangents_of
from app.views.tubes import Tube
from knitlab_core.jit import kernel
from knitlab_core.threads import thread_count

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import numpy.typing as npt

    from app.views.tubes import Window
    from rigs.axes import FloatArray

FINENESS: Final = 2
"""Rays along a pixel."""

BAND: Final = 64
"""Rows of pixels that are drawn at a time: what is known of rays is many times the image."""

SHADE: Final = 0.55
"""Light that is lost at most beside and below something [1]."""

LAMPS: Final = np.array([(-0.25, -0.3, 1.0, 0.7), (0.3, 0.25, 1.0, 0.35)])
"""To the right, downwards and to the eye, and strength: nearly from the eye, so that slopes do not pass for strain."""

AMBIENT, DIFFUSE, SPECULAR = 0.28, 0.75, 0.25


@kernel
def light(
    height: npt.NDArray[np.float32],
    normal: npt.NDArray[np.float32],
    value: npt.NDArray[np.float32],
    limits: tuple[float, float],
    table: FloatArray,
    lamps: FloatArray,
    image: npt.NDArray[np.float32],
    seen: npt.NDArray[np.float32],
    highest: npt.NDArray[np.float32],
) -> None:
    """Sum the light of the rays of every pixel by Phong's formula.

    Parameters
    ----------
    height, value : array of float32, shape (FINENESS rows, FINENESS columns)
        As `draw_tube` fills them.
    normal : array of float32, shape (3, FINENESS rows, FINENESS columns)
        As well.
    limits : tuple of float
        Values of the first and the last colour.
    table : FloatArray, shape (n, 3)
        Colours, 0 to 1.
    lamps : FloatArray, shape (m, 4)
        Unit vector to each lamp, and its strength.
    image : array of float32, shape (rows, columns, 3)
        Light of a pixel, 0 to 1; nothing gives none.
    seen : array of float32, shape (rows, columns)
        Share of its rays that meet something [1].
    highest : array of float32, shape (rows, columns)
        The highest that they meet [ray].
    """
    rows, columns = seen.shape
    share = 1.0 / FINENESS**2
    steps = len(table) / (limits[1] - limits[0])
    for i in range(FINENESS * rows):
        for j in range(FINENESS * columns):
            if height[i, j] <= NOTHING:
                continue
            nx, ny, nz = normal[0, i, j], normal[1, i, j], normal[2, i, j]
            diffuse, specular = AMBIENT, 0.0
            for k in range(len(lamps)):
                towards = nx * lamps[k, 0] + ny * lamps[k, 1] + nz * lamps[k, 2]
                if towards <= 0.0:
                    continue
                diffuse += DIFFUSE * lamps[k, 3] * towards
                # The 18th power of the cosine between the eye and the way of mirrored light.
                mirrored = max(0.0, 2.0 * towards * nz - lamps[k, 2])
                square = mirrored * mirrored
                eighth = square * square * square * square
                specular += SPECULAR * lamps[k, 3] * eighth * eighth * square
            step = min(max(int((value[i, j] - limits[0]) * steps), 0), len(table) - 1)
            y, x = i // FINENESS, j // FINENESS
            for c in range(3):
                image[y, x, c] += share * min(1.0, diffuse * table[step, c] + specular)
            seen[y, x] += share
            highest[y, x] = max(highest[y, x], height[i, j])


@kernel
def highest_along(height: npt.NDArray[np.float32], reach: int, found: npt.NDArray[np.float32]) -> None:
    """Compute the maximum within a reach along each row."""
    rows, columns = height.shape
    for i in range(rows):
        for k in range(-min(reach, columns), min(reach, columns) + 1):
            # Slices, for vector code is made of plain indices alone.
            target, beside = found[i, max(0, -k) : columns - max(0, k)], height[i, max(0, k) : columns - max(0, -k)]
            for j in range(len(target)):
                target[j] = max(target[j], beside[j])


@kernel
def blurred_along(given: npt.NDArray[np.float32], weights: FloatArray, found: npt.NDArray[np.float32]) -> None:
    """Smooth each row by weights (2 n + 1,), from n before to n behind."""
    rows, columns = given.shape
    reach = len(weights) // 2
    for i in range(rows):
        for k in range(-min(reach, columns), min(reach, columns) + 1):
            weight = np.float32(weights[k + reach])
            target, beside = found[i, max(0, -k) : columns - max(0, k)], given[i, max(0, k) : columns - max(0, -k)]
            for j in range(len(target)):
                target[j] += weight * beside[j]


def tube_images(
    tubes: Sequence[Tube], window: Window, *, pixels: float, limits: tuple[float, float], table: FloatArray
) -> Iterator[npt.NDArray[np.uint8]]:
    """Render tubes, each in its own image, on white.

    Parameters
    ----------
    tubes : sequence of Tube
        One image each.
    window : tuple of float
        What the image shows: x₀, x₁, y₀, y₁ [mm].
    pixels : float
        Pixels per mm.
    limits : tuple of float
        Values of the first and the last colour.
    table : FloatArray, shape (n, 3)
        Colours from one to the other, 0 to 1.

    Yields
    ------
    array of uint8, shape (rows, columns, 3)
        RGB image that fills the window.
    """
    x0, x1, y0, y1 = window
    shape = round(pixels * (y1 - y0)), round(pixels * (x1 - x0))
    rays = FINENESS * pixels

    def image_of(one: Tube) -> npt.NDArray[np.uint8]:
        points = rays * (one.points - np.array([x0, y1, 0.0])) * np.array([1.0, -1.0, 1.0])
        image, seen, highest = _lit(one, points, rays * one.radius, shape, limits, table)
        dark = _shade(highest, rays * one.radius)
        light_left = (1.0 - np.float32(SHADE) * dark)[..., None] * image + (1.0 - seen)[..., None]
        return np.asarray(np.round(255.0 * light_left.clip(0.0, 1.0)), dtype=np.uint8)

    with ThreadPoolExecutor(thread_count()) as pool:
        yield from pool.map(image_of, tubes)


def _lit(
    one: Tube, points: FloatArray, radius: float, shape: tuple[int, int], limits: tuple[float, float], table: FloatArray
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return light, coverage, and height [ray] of a tube's pixels, from points and radius in rays."""
    rows, columns = shape
    image, seen = np.zeros((rows, columns, 3), dtype=np.float32), np.zeros(shape, dtype=np.float32)
    highest = np.full(shape, NOTHING, dtype=np.float32)
    lamps = LAMPS / np.append(np.linalg.norm(LAMPS[:, :3], axis=1, keepdims=True) * np.ones(3), np.ones((2, 1)), axis=1)
    tangents, pieces = tangents_of(points, one.sizes), joined(one)
    reaches = reaches_of(points, pieces, radius)
    for top in range(0, rows, BAND):
        band = slice(top, min(top + BAND, rows))
        fine = (FINENESS * (band.stop - top), FINENESS * columns)
        height, normal = np.full(fine, NOTHING, dtype=np.float32), np.empty((3, *fine), dtype=np.float32)
        value = np.empty(fine, dtype=np.float32)
        lowered = points - np.array([0.0, FINENESS * top, 0.0])
        draw_tube(lowered, tangents, one.values, pieces, reaches, radius, height, normal, value)
        light(height, normal, value, limits, table, lamps, image[band], seen[band], highest[band])
    return image, seen, highest


def _shade(highest: npt.NDArray[np.float32], radius: float) -> npt.NDArray[np.float32]:
    """Return the shade beside and below what is seen, 0 to 1, so that crossings are visible (ambient occlusion).

    Parameters
    ----------
    highest : array of float32, shape (rows, columns)
        Height of what is seen [ray].
    radius : float
        Of the tube [ray]; the shade reaches half of it.
    """
    reach = 0.5 * radius / FINENESS
    around = highest
    for _ in range(2):
        found = around.copy()
        highest_along(around, round(reach), found)
        around = np.ascontiguousarray(found.T)
    dark = ((around - highest) / np.float32(radius) - np.float32(0.8)).clip(0.0, 1.0)
    spread = max(0.4 * reach, 1e-3)
    far = np.arange(-round(4.0 * spread), round(4.0 * spread) + 1)
    weights = np.exp(-0.5 * (far / spread) ** 2)
    for _ in range(2):
        found = np.zeros_like(dark)
        blurred_along(dark, weights / weights.sum(), found)
        dark = np.ascontiguousarray(found.T)
    return dark


def prepare() -> None:
    """Load the kernels, or compile them, by a minimal render."""
    ends = np.array([[0.2, 0.5, 0.0], [0.8, 0.5, 0.0]])
    one = Tube(points=ends, values=np.zeros(2), radius=0.1, sizes=np.array([2]))
    for _ in tube_images([one], (0.0, 1.0, 0.0, 1.0), pixels=4.0, limits=(0.0, 1.0), table=np.zeros((2, 3))):
        pass
