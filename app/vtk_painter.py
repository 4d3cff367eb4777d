"""Paint tubes with VTK, in a process of its own: ``python -m app.vtk_painter scene.npz images.npz``.

A graphics driver that is missing or broken takes down the process it is loaded into, and that
must not be the one which holds a run.
"""

from __future__ import annotations

import sys

import matplotlib as mpl
import numpy as np
import pyvista
from scipy.ndimage import gaussian_filter, maximum_filter

SHADE = 0.55
# Direction of each lamp from the knit, and its strength: nearly from the eye, so that slopes do not pass for strain.
LAMPS = (((-0.25, 0.3, 1.0), 0.7), ((0.3, -0.25, 1.0), 0.35))


def paint(scene: np.lib.npyio.NpzFile) -> list[np.ndarray]:
    """Render every tube of a scene from above, to scale.

    Parameters
    ----------
    scene : NpzFile
        ``window`` (x₀, x₁, y₀, y₁) [mm], ``pixels`` per mm, ``limits`` of the colours, ``colours`` (name of the
        map), and ``points_k``, ``values_k``, ``radius_k`` of tube k.

    Returns
    -------
    list of arrays, shape (height, width, 4)
        RGBA images that fill the window.
    """
    x0, x1, y0, y1 = scene["window"]
    size = [round(float(scene["pixels"]) * length) for length in (x1 - x0, y1 - y0)]
    images = []
    for k in range(int(scene["count"])):
        plotter = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
        _light(plotter)
        points = scene[f"points_{k}"]
        line = pyvista.MultipleLines(points)
        line["value"] = scene[f"values_{k}"]
        plotter.add_mesh(
            line.tube(radius=float(scene[f"radius_{k}"]), n_sides=18),
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
        plotter.camera.parallel_projection = True
        middle = ((x0 + x1) / 2, (y0 + y1) / 2, 0.0)
        plotter.camera.focal_point = middle
        plotter.camera.position = (*middle[:2], 10 * (y1 - y0))
        plotter.camera.up = (0.0, 1.0, 0.0)
        plotter.camera.parallel_scale = (y1 - y0) / 2
        plotter.reset_camera_clipping_range()
        image = plotter.screenshot(transparent_background=True, return_img=True)
        radius = float(scene[f"radius_{k}"])
        images.append(shade(np.asarray(image), np.asarray(plotter.get_image_depth()), radius, float(scene["pixels"])))
        plotter.close()
    return images


def shade(image: np.ndarray, depth: np.ndarray, radius: float, pixels: float) -> np.ndarray:
    """Darken what lies close beside and below something, so that over and under are told apart.

    Parameters
    ----------
    image : array, shape (height, width, 4)
        RGBA image.
    depth : array, shape (height, width)
        Height of what is seen [mm], rising to the eye; NaN where there is nothing.
    radius : float
        Radius of the tubes [mm]; the shade reaches half of it.
    pixels : float
        Pixels per mm.

    Returns
    -------
    array, shape (height, width, 4)
        The image with shade.
    """
    height = np.where(np.isnan(depth), -1e3, depth).astype(np.float32)
    reach = 0.5 * radius * pixels
    above = maximum_filter(height, size=2 * round(reach) + 1) - height
    dark = gaussian_filter(np.clip(above / radius - 0.8, 0.0, 1.0), 0.4 * reach)
    shaded = image.astype(float)
    shaded[..., :3] *= (1 - SHADE * np.where(np.isnan(depth), 0.0, dark))[..., None]
    return np.round(shaded).astype(np.uint8)


def _light(plotter: pyvista.Plotter) -> None:
    for position, strength in LAMPS:
        plotter.add_light(pyvista.Light(position=position, light_type="camera light", intensity=strength))


if __name__ == "__main__":
    with np.load(sys.argv[1]) as given:
        painted = paint(given)
    np.savez(sys.argv[2], *painted)
