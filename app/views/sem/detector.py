"""Secondary-electron detector: grey levels of what the beam hits.

The yield of a surface rises as the beam grazes it, as the secant of the angle but bounded; electrons from a gap find
their way out where the sky is open, and to the detector's side more of them. Then come what charging, lines and the
number of electrons do.

References
----------
L. Reimer, Scanning Electron Microscopy, 2nd ed. (1998), 4.2 (yield over tilt), 6.1 (type-1 and shadow contrast).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
from scipy.ndimage import gaussian_filter, uniform_filter
from scipy.signal import lfilter

from app.views.raster import NOTHING, draw_tube, joined, reaches_of, tangents_of
from app.views.sem.raster import draw_block, openness

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from app.views.sem.blocks import Block
    from app.views.sem.view import View
    from app.views.tubes import Tube
    from rigs.axes import FloatArray, IntArray
    from rigs.machines.microscope import Microscope

FloatImage: TypeAlias = "npt.NDArray[np.float32]"
FINENESS: Final = 2
"""Rays along a pixel."""

DIRECTIONS: Final = 10
DISTANCES: Final = 10
NEAREST: Final = 1.5
REACH: Final = 0.2
"""Where it is looked for what hides the sky: from this distance at least [pixel] to this one [image's width]."""

WIDTH: Final = 1.2
"""Width of what is looked at there, over its distance."""

BRIGHTNESS: Final = 0.055
CONTRAST: Final = 0.40
"""Grey of no signal, and of a surface met head-on under an open sky, over full scale; an operator's knobs."""


def image(
    yarn: Tube, blocks: Sequence[Block], view: View, microscope: Microscope, seed: Sequence[int]
) -> npt.NDArray[np.uint8]:
    """Render a frame without its data bar.

    Parameters
    ----------
    yarn : Tube
        The yarn [mm].
    blocks : sequence of Block
        What holds it.
    view : View
        Where it is seen from.
    microscope : Microscope
        Its numbers.
    seed : sequence of int
        Of the noise.

    Returns
    -------
    array of uint8, shape (rows, columns)
        Grey levels.
    """
    signal = emission(yarn, blocks, view, microscope)
    return _detected(signal, microscope, np.random.default_rng(seed))


def emission(yarn: Tube, blocks: Sequence[Block], view: View, microscope: Microscope) -> FloatImage:
    """Return the detector signal without noise, 1 for resin at normal incidence under an open sky."""
    height, facing, silicon = _surfaces(yarn, blocks, view)
    seen = height > NOTHING
    g = microscope.grazing.value
    given = np.where(seen, (1.0 + g) / (facing + g), 0.0)
    given[silicon] *= microscope.silicon_yield.value
    stray = microscope.stray.value
    # Beside and below the specimen there is nothing that hides anything.
    ground = np.where(seen, height, height[seen].min(initial=0.0)).astype(np.float32)
    radius = 1e-3 * yarn.radius / view.pixel
    collected = stray + (1.0 - stray) * _open_sky(_shrunk(ground / np.float32(FINENESS)), radius, view, microscope)
    return (_shrunk(given) * collected).astype(np.float32)


def _shrunk(fine: FloatImage) -> FloatImage:
    """Return the means of squares of `FINENESS` rays."""
    rows, columns = fine.shape
    squares = fine.reshape(rows // FINENESS, FINENESS, columns // FINENESS, FINENESS)
    return np.asarray(squares.mean(axis=(1, 3)), dtype=np.float32)


def _surfaces(yarn: Tube, blocks: Sequence[Block], view: View) -> tuple[FloatImage, FloatImage, npt.NDArray[np.bool_]]:
    """Return height [fine pixel] and cosine to the beam of visible surfaces, and where they are silicon."""
    shape = (FINENESS * view.height, FINENESS * view.width)
    height, normal = np.full(shape, NOTHING, dtype=np.float32), np.ones((3, *shape), dtype=np.float32)
    facing, value = normal[2], np.empty_like(height)
    silicon = np.zeros(shape, dtype=np.bool_)
    origin = view.centre - view.turn.T @ (view.on_image(view.centre[None])[0] * np.array([1.0, -1.0, 1.0]) * view.pixel)
    steps = view.turn * np.array([[1.0], [-1.0], [1.0]]) * view.pixel / FINENESS
    for block in blocks:
        hit = np.zeros(shape, dtype=np.bool_)
        window = _window(FINENESS * view.on_image(block.corners), shape)
        draw_block(origin, steps, block.low, block.high, window, height, facing, hit)
        silicon[hit] = not block.printed
    before = height.copy()
    points = FINENESS * view.on_image(1e-3 * yarn.points)
    radius = 1e-3 * yarn.radius / view.pixel * FINENESS
    pieces = joined(yarn)
    reaches = reaches_of(points, pieces, radius)
    draw_tube(points, tangents_of(points, yarn.sizes), yarn.values, pieces, reaches, radius, height, normal, value)
    silicon[height > before] = False
    return height, facing, silicon


def _window(corners: FloatArray, shape: tuple[int, int]) -> IntArray:
    """Return first and last row and column of the bounding box of corners (n, 3) [fine pixel] in an image."""
    low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
    rows, columns = np.clip([low[1], high[1]], 0, shape[0]), np.clip([low[0], high[0]], 0, shape[1])
    return np.array([*rows, *columns], dtype=np.int64)


def _open_sky(height: FloatImage, radius: float, view: View, microscope: Microscope) -> FloatImage:
    """Return the share of electrons that are collected from every pixel, towards the detector more of them.

    What is nearer than a fibre's radius [pixel] hides nothing: it is the slope of the fibre itself.
    """
    angles = 2.0 * np.pi * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    towards = np.cos(angles - np.radians(microscope.collector_azimuth.value))
    weights = (1.0 + microscope.collector_pull.value * towards) / DIRECTIONS
    reaches = np.geomspace(max(NEAREST, radius), REACH * view.width, DISTANCES)
    ways = np.stack([-np.sin(angles), np.cos(angles)], axis=1)[:, None] * reaches[:, None]
    # Far away the mean height of the surroundings counts, as a thin strand hides little.
    around = np.stack([_spread(height, WIDTH * reach) for reach in reaches])
    found = np.empty_like(height)
    openness(height, around, np.round(ways).astype(np.int64), reaches, weights, found)
    return found


def _spread(height: FloatImage, width: float) -> FloatImage:
    """Return the mean height over a width [pixel], with weights that fall to its edges."""
    size = max(1, round(0.5 * width))
    return np.asarray(uniform_filter(uniform_filter(height, size), size))


def _detected(signal: FloatImage, microscope: Microscope, random: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Return the grey levels of a signal: spot, charging, shot noise, lines."""
    spread = gaussian_filter(signal, microscope.spot.value)
    fade = np.exp(-1.0 / microscope.charging_length.value)
    left_behind = lfilter([0.0, 1.0 - fade], [1.0, -fade], spread, axis=1)
    charged = spread - microscope.charging.value * left_behind * (spread > 0.0)
    dose = microscope.dose.value
    # Electrons of the beam and of the surface both scatter in number: twice Poisson's variance.
    noisy = charged + np.sqrt(2.0 * (charged.clip(0.0) + 0.05) / dose) * random.standard_normal(signal.shape)
    lines = microscope.line_noise.value * lfilter([1.0], [1.0, -0.6], random.standard_normal(len(signal)))
    grey = BRIGHTNESS + CONTRAST * noisy + 0.8 * lines[:, None]
    return np.asarray(np.clip(np.round(255.0 * grey), 0, 255), dtype=np.uint8)
