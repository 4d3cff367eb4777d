"""View directions on a knit: a planar one from above, a volumetric one from a corner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rigs.axes import FloatArray

AZIMUTH: Final = np.radians(32.0)
ELEVATION: Final = np.radians(24.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """A view direction, and how a picture is labelled in it.

    Attributes
    ----------
    turn : FloatArray, shape (3, 3)
        Unit vectors to the right, up and to the eye, in course, wale and pile.
    labels : tuple of str or None
        Words below and beside the picture; None where no axis of the knit lies in it, and arrows show them.
    """

    turn: FloatArray
    labels: tuple[str, str] | None

    def seen(self, points: FloatArray) -> FloatArray:
        """Project points (n, 3) to view coordinates: right, up, towards the viewer."""
        return points @ self.turn.T

    def dress(self, axes: Axes) -> None:
        """Label a picture with the directions of the knit."""
        if self.labels is not None:
            axes.set(xlabel=self.labels[0], ylabel=self.labels[1])
            return
        axes.set(xlabel="[mm]", ylabel="[mm]")
        for name, (right, up) in zip(("C", "W", "P"), 0.13 * self.turn[:2].T, strict=True):
            tip = (0.05 + right, 0.06 + up)
            arrow = {"arrowstyle": "<-", "color": "black", "lw": 1.2}
            axes.annotate(
                name,
                xy=(0.05, 0.06),
                xytext=tip,
                xycoords="axes fraction",
                textcoords="axes fraction",
                arrowprops=arrow,
                ha="center",
                va="center",
                fontsize=10,
                zorder=5,
            )


def _corner() -> FloatArray:
    """Return the turn of an eye that looks at the corner of course and wale from above, the pile upright."""
    right = np.array([np.cos(AZIMUTH), np.sin(AZIMUTH), 0.0])
    level = np.array([np.sin(AZIMUTH), -np.cos(AZIMUTH), 0.0])
    eye = np.cos(ELEVATION) * level + np.sin(ELEVATION) * np.array([0.0, 0.0, 1.0])
    return np.stack([right, np.cross(eye, right), eye])


FROM_ABOVE: Final = View(turn=np.eye(3), labels=("course [mm]", "wale [mm]"))
FROM_A_CORNER: Final = View(turn=_corner(), labels=None)


def view_of(*, volumetric: bool) -> View:
    """Return the view that shows a knit."""
    return FROM_A_CORNER if volumetric else FROM_ABOVE
