"""View of a specimen through the microscope: tilt and rotation of the stage, magnification, field of view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.axes import FloatArray

ASPECT: Final = 0.75
"""Height of an image over its width."""

BAR: Final = 0.08
"""Height of the data bar over that of the image."""

ROOM: Final = 0.94
"""Share of the image beside the bar that the specimen fills at most."""

MAGNIFICATIONS: Final = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Magnifications in use, of each power of ten."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """Direction of the beam, and field of view.

    Attributes
    ----------
    turn : FloatArray, shape (3, 3)
        Unit vectors to the right, up in the image and towards the beam, in course, wale and pile.
    centre : FloatArray, shape (3,)
        Point in the middle of the image above the bar [m].
    width, height : int
        Pixels of the image, the bar included.
    magnification : float
        Width of a print over what it shows [1].
    pixel : float
        Side of a pixel in the plane that the beam meets head-on [m].
    """

    turn: FloatArray
    centre: FloatArray
    width: int
    height: int
    magnification: float
    pixel: float

    @property
    def bar(self) -> int:
        """Return the rows of the data bar."""
        return bar_rows(self.height)

    def on_image(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) [m] as column, row and height towards the beam, (n, 3) [pixel]."""
        seen = (points - self.centre) @ self.turn.T / self.pixel
        middle = np.array([0.5 * self.width, 0.5 * (self.height - self.bar), 0.0])
        return np.asarray(middle + seen * np.array([1.0, -1.0, 1.0]))


def bar_rows(height: int) -> int:
    """Return the rows of the data bar in an image of some height."""
    return round(BAR * height)


def turned(tilt: float, rotation: float) -> FloatArray:
    """Return the turn of a view.

    Parameters
    ----------
    tilt : float
        Angle of the beam to the pile [deg]: 0 from above, 90 across it.
    rotation : float
        Of the specimen about its pile [deg]: at 0 the course runs to the right.

    Returns
    -------
    FloatArray, shape (3, 3)
        Unit vectors to the right, up and towards the beam.
    """
    about, off = np.radians(rotation), np.radians(tilt)
    right = np.array([np.cos(about), np.sin(about), 0.0])
    level = np.array([np.sin(about), -np.cos(about), 0.0])
    beam = np.sin(off) * level + np.cos(off) * np.array([0.0, 0.0, 1.0])
    return np.stack([right, np.cross(beam, right), beam])


def fit(shapes: Sequence[FloatArray], radius: float, turn: FloatArray, *, width: int, print_width: float) -> View:
    """Return the view at the largest usual magnification that shows all shapes of a run.

    Parameters
    ----------
    shapes : sequence of FloatArray, shape (n, 3)
        Points that must be seen [m].
    radius : float
        How far the specimen reaches beyond them [m].
    turn : FloatArray, shape (3, 3)
        Where it is seen from.
    width : int
        Pixels along the image.
    print_width : float
        Width of the print that magnifications are told for [m].
    """
    height = round(ASPECT * width)
    seen = np.concatenate(shapes) @ turn.T
    low, high = seen.min(axis=0) - radius, seen.max(axis=0) + radius
    across, up, _ = high - low
    least = max(across / width, up / (height - bar_rows(height))) / ROOM
    magnification = _rounded(print_width / (width * least))
    return View(
        turn=turn,
        centre=0.5 * (low + high) @ turn,
        width=width,
        height=height,
        magnification=magnification,
        pixel=print_width / (magnification * width),
    )


def _rounded(magnification: float) -> float:
    """Return the largest usual magnification that is not above another."""
    power = 10.0 ** np.floor(np.log10(magnification))
    return float(power * max(one for one in MAGNIFICATIONS if one * power <= magnification * (1 + 1e-12)))
