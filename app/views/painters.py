"""Paint tubes onto axes: with VTK where it can be had, else with lines sorted by depth."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from ctypes.util import find_library
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from app.beside import import_path

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

    from app.views.tubes import Tube
    from rigs.axes import FloatArray

Window = tuple[float, float, float, float]

PATIENCE = 120.0
OUTLINE = "#1b1b1b"
LAYERS = 24


_ready: list[subprocess.Popen[bytes]] = []
"""A process of VTK that was started before there was anything to paint."""


def vtk_environment(environment: Mapping[str, str], platform: str) -> dict[str, str] | None:
    """Return the variables under which VTK finds a window class that needs no screen.

    Parameters
    ----------
    environment : mapping of str to str
        The variables as they are.
    platform : str
        As `sys.platform` gives it.

    Returns
    -------
    dict of str to str, or None
        The variables for VTK; None where it could only crash, on Linux with neither a screen nor EGL or OSMesa.
    """
    found = {**environment, "PYTHONPATH": import_path(environment)}
    screen = environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")
    if not platform.startswith("linux") or screen or "VTK_DEFAULT_OPENGL_WINDOW" in environment:
        return found
    for library, window in (("EGL", "vtkEGLRenderWindow"), ("OSMesa", "vtkOSOpenGLRenderWindow")):
        if find_library(library):
            return found | {"VTK_DEFAULT_OPENGL_WINDOW": window}
    return None


def vtk_images(
    tubes: Sequence[Tube], window: Window, *, pixels: float, limits: tuple[float, float], colours: str
) -> list[npt.NDArray[np.uint8]] | str:
    """Render tubes with VTK.

    Parameters
    ----------
    tubes : sequence of Tube
        One image each.
    window : tuple of float
        What the image shows: x₀, x₁, y₀, y₁ [mm].
    pixels : float
        Pixels per mm.
    limits : tuple of float
        Values at the ends of the colours.
    colours : str
        Name of the colour map.

    Returns
    -------
    list of arrays, shape (height, width, 3), or str
        RGB images; or why there are none.
    """
    process = _ready.pop() if _ready else _start()
    if isinstance(process, str):
        return process
    scene: dict[str, object] = {
        "window": np.array(window),
        "pixels": pixels,
        "limits": np.array(limits),
        "colours": colours,
        "count": len(tubes),
    }
    for k, one in enumerate(tubes):
        scene |= {f"points_{k}": one.points, f"values_{k}": one.values, f"radius_{k}": one.radius}
        scene[f"sizes_{k}"] = one.sizes
    try:
        with tempfile.TemporaryDirectory() as folder:
            given, painted = Path(folder) / "scene.npz", Path(folder) / "images.npz"
            np.savez(given, **scene)  # type: ignore[arg-type]
            process.communicate(f"{given}\n{painted}\n".encode(), timeout=PATIENCE)
            if process.returncode != 0:
                return f"VTK did not paint (exit code {process.returncode})"
            with np.load(painted) as images:
                return [images[f"arr_{k}"] for k in range(len(tubes))]
    except (subprocess.SubprocessError, OSError) as error:  # the folder of temporary files may be full
        process.kill()
        process.communicate()
        return f"VTK did not paint ({type(error).__name__})"


def start_painter() -> None:
    """Start the process of VTK for the next call of `vtk_images`, so that it imports in the meantime."""
    process = _start()
    if not isinstance(process, str):
        _ready.append(process)


def _start() -> subprocess.Popen[bytes] | str:
    """Start a process of VTK, which ends when its input does; or say why there is none."""
    if find_spec("pyvista") is None:
        return "pyvista is not installed (extra 'pictures')"
    variables = vtk_environment(os.environ, sys.platform)
    if variables is None:
        return "there is no screen and neither EGL nor OSMesa"
    command = [sys.executable, "-P", "-m", "app.views.vtk_painter"]
    pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
    try:
        return subprocess.Popen(command, env=variables, stdin=pipe, stdout=nowhere, stderr=nowhere)  # noqa: S603
    except OSError as error:
        return f"VTK did not paint ({type(error).__name__})"


def paint_lines(axes: Axes, one: Tube, window: Window, colours: ScalarMappable) -> None:
    """Draw a tube as outlined lines, the lower ones first.

    Parameters
    ----------
    axes : Axes
        In mm; their size on the page must be final.
    one : Tube
        What to draw.
    window : tuple of float
        x₀, x₁, y₀, y₁ [mm].
    colours : ScalarMappable
        Gives the colour of a value.
    """
    from matplotlib.collections import LineCollection  # noqa: PLC0415 - imported when a picture is wanted

    figure = axes.get_figure(root=True)
    if figure is None:
        return
    points_per_mm = 72 * axes.get_position().width * figure.get_figwidth() / (window[1] - window[0])
    width = 2 * one.radius * points_per_mm
    pieces: FloatArray = np.stack([one.points[:-1], one.points[1:]], axis=1)
    joined = np.ones(len(pieces), dtype=np.bool_)
    joined[np.cumsum(one.sizes)[:-1] - 1] = False
    order = np.argsort(pieces[:, :, 2].mean(axis=1))
    order = order[joined[order]]
    shades = colours.to_rgba(0.5 * (one.values[:-1] + one.values[1:]))
    for layer in np.array_split(order, LAYERS):
        lines = list(pieces[layer, :, :2])
        for thick, ink, cap in ((width + 1.0, OUTLINE, "butt"), (width, shades[layer], "round")):
            axes.add_collection(LineCollection(lines, linewidths=thick, colors=ink, capstyle=cap, rasterized=True))


def fit_window(tubes: Sequence[Tube], margin: float = 0.04) -> Window:
    """Return the smallest window that shows every tube, with a margin (share of its size)."""
    low = np.min([one.points.min(axis=0) - one.radius for one in tubes], axis=0)[:2]
    high = np.max([one.points.max(axis=0) + one.radius for one in tubes], axis=0)[:2]
    room = margin * float((high - low).max())
    return (float(low[0] - room), float(high[0] + room), float(low[1] - room), float(high[1] + room))
