"""Look of curves in every figure: colours, dashes and names of axes, styles of strokes, marks of limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.views.curves import Role
    from rigs.axes import Axis

#: Okabe and Ito's palette: told apart by colour-blind readers.
COLOURS: dict[Axis, str] = {
    "C": "#0072B2",
    "W": "#D55E00",
    "P": "#009E73",
    "WC": "#CC79A7",
    "PC": "#56B4E9",
    "PW": "#E69F00",
}
NAMES: dict[Axis, str] = {"C": "course", "W": "wale", "P": "pile", "WC": "shear WC", "PC": "shear PC", "PW": "shear PW"}
#: Curves that lie on each other show through each other's dashes.
DASHES: dict[Axis, str | tuple[float, tuple[float, ...]]] = {
    "C": "-",
    "W": (0, (4, 3)),
    "P": (0, (2, 2)),
    "WC": "-.",
    "PC": (0, (6, 2, 1, 2)),
    "PW": (0, (1, 2)),
}
#: Strain that an extensometer reads.
PINNED: tuple[float, tuple[float, ...]] = (0, (1, 1.5))
STYLES: Mapping[Role, str] = {"loading": "-", "unloading": "--", "hold": ":", "held": "-.", "free": "-."}
ROLE_LABELS: Mapping[Role, str] = {
    "loading": "loading",
    "unloading": "unloading",
    "hold": "all axes at rest",
    "held": "held, another axis driven",
    "free": "free, another axis driven",
}
#: Styles of lines in words.
LINES: Mapping[str, str] = {"-": "full", "--": "dashed", ":": "dotted or a dot", "-.": "dash-dotted"}
#: Marks of the limits of a material, in the order of their strains, and their colour.
MARKS = ("X", "P")
BEYOND = "#A3005C"
MOST_CYCLES = 4
#: Height of titles, on top of the axes: said, for matplotlib looks for it among all ticks else, a tenth of the time.
TITLE = 1.0
