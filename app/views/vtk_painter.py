"""Paint tubes with VTK, in a process of its own: ``python -m app.views.vtk_painter``.

Two lines come on its standard input, when there is something to paint: the file of the scene and that of the images.

A graphics driver that is missing or broken takes down the process it is loaded into, and that
must not be the one which holds a run.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, TypeAlias

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pyvista
from scipy.ndimage import gaussian_filter, maximum_filter

if TYPE_CHECKING:
    from collections.abc import Iterator

FloatImage: TypeAlias = npt.NDArray[np.float32]

SHADE = 0.55
# Direction of each lamp from the knit, and its strength: nearly from the eye, so that slopes do not pass for strain.
LAMPS = (((-0.25, 0.3, 1.0), 0.7), ((0.3, -0.25, 1.0), 0.35))
# Rendered pixels along a pixel of the image; a software renderer's own smoothing costs three times as much.
FINENESS = 2
SIDES = 16


def paint(scene: np.lib.npyio.NpzFile) -> Iterator[npt.NDArray[np.uint8]]:
    """Render every tube of a scene from above, to scale, on white.

    Parameters
    ----------
    scene : NpzFile
        ``window`` (x₀, x₁, y₀, y₁) [mm], ``pixels`` per mm, ``limits`` of the colours, ``colours`` (name of the
        map), and ``points_k``, ``values_k``, ``radius_k`` and
        ``sizes_k`` (points of every piece) of tube k.

    Yields
    ------
    array, shape (height, width, 3)
        RGB image that fills the window.
    """
    x0, x1, y0, y1 = scene["window"]
    fine = FINENESS * float(scene["pixels"])
    size = [FINENESS * round(float(scene["pixels"]) * length) for length in (x1 - x0, y1 - y0)]
    plotter = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
    plotter.disable_anti_aliasing()
    plotter.background_color = pyvista.Color("white")
    for position, strength in LAMPS:
        plotter.add_light(pyvista.Light(position=position, light_type="camera light", intensity=strength))
    plotter.camera.parallel_projection = True
    middle = ((x0 + x1) / 2, (y0 + y1) / 2, 0.0)
    plotter.camera.focal_point = middle
    plotter.camera.position = (*middle[:2], 10 * (y1 - y0))
    plotter.camera.up = (0.0, 1.0, 0.0)
    plotter.camera.parallel_scale = (y1 - y0) / 2
    for k in range(int(scene["count"])):
        radius = float(scene[f"radius_{k}"])
        line = pyvista.PolyData(scene[f"points_{k}"], lines=cells(scene[f"sizes_{k}"]))
        line["value"] = scene[f"values_{k}"]
        plotter.add_mesh(
            line.tube(radius=radius, n_sides=SIDES),
            name="yarn",
            reset_camera=False,
            scalars="value",
            cmap=mpl.colormaps[str(scene["colours"])],
            clim=tuple(scene["limits"]),
            show_scalar_bar=False,
            smooth_shading=True,
            ambient=0.28,
            diffuse=0.75,
            specular=0.25,
            specular_power=18,
        )
        plotter.reset_camera_clipping_range()
        image = np.asarray(plotter.screenshot(return_img=True))
        yield shrink(shade(image, np.asarray(plotter.get_image_depth()), radius, fine))
    plotter.close()


def cells(sizes: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return polylines as VTK lists them, (n + k,): of every piece its number of points, then their indices."""
    begins = np.cumsum(sizes) - sizes
    return np.concatenate([[size, *range(begin, begin + size)] for begin, size in zip(begins, sizes, strict=True)])


def shade(image: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32], radius: float, pixels: float) -> FloatImage:
    """Darken what lies close beside and below something, so that over and under are told apart.

    Parameters
    ----------
    image : array, shape (height, width, 3)
        RGB image.
    depth : array, shape (height, width)
        Height of what is seen [mm], rising to the eye; NaN where there is nothing.
    radius : float
        Radius of the tubes [mm]; the shade reaches half of it.
    pixels : float
        Pixels per mm.

    Returns
    -------
    array, shape (height, width, 3)
        The image with shade.
    """
    height = np.where(np.isnan(depth), -1e3, depth).astype(np.float32)
    reach = 0.5 * radius * pixels
    above = maximum_filter(height, size=2 * round(reach) + 1) - height
    dark = gaussian_filter(np.clip(above / radius - 0.8, 0.0, 1.0), 0.4 * reach)
    light = 1 - np.float32(SHADE) * np.where(np.isnan(depth), np.float32(0.0), dark)
    return image * light[..., None]


def shrink(image: FloatImage) -> npt.NDArray[np.uint8]:
    """Average squares of `FINENESS` pixels: edges come out smooth."""
    height, width, colours = image.shape
    squares = image.reshape(height // FINENESS, FINENESS, width // FINENESS, FINENESS, colours)
    return np.asarray(np.round(squares.mean(axis=(1, 3))), dtype=np.uint8)


if __name__ == "__main__":
    names = sys.stdin.buffer.read().decode().splitlines()
    if len(names) == 2:  # else whoever wanted to paint is gone
        with np.load(names[0]) as given:
            np.savez(names[1], *paint(given))
