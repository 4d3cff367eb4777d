"""Edges of a planar knit along its wale: open as they are knitted, or chained."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from knitlab_core.knits import Stitch
from rigs.protocol.bounds import require, require_all

if TYPE_CHECKING:
    from knitlab_core.knits import Fabric, Yarn


class Edges(NamedTuple):
    """Edges of a planar knit along its wale: `top`, its last row, and `bottom`, its first."""

    top: Literal["open", "bound-off"] = "open"
    bottom: Literal["open", "cast-on"] = "open"


OPEN: Final = Edges()
"""Edges as they are knitted."""


def require_chainable(edges: Edges, fabric: Fabric, loops: int, yarn: Yarn | None, *, periodic: bool) -> None:
    """Raise unless a knit can have chained edges.

    Parameters
    ----------
    edges : Edges
        Those that shall be chained.
    fabric : Fabric
        The knit.
    loops : int
        Loops in a row [1].
    yarn : Yarn or None
        The fibres of its yarn.
    periodic : bool
        Whether it is a cell of an endless fabric.
    """
    found = ", ".join(f"{name}: {edge}" for name, edge in edges._asdict().items() if edge != "open")
    planar = "open in this knit: plain stockinette can be bound off and cast on"
    one_rod = yarn is None or yarn.model == "yarn"
    require_all(
        lambda: require(not periodic, "edges", found, "none: a periodic cell has no edges"),
        lambda: require(type(fabric) is Stitch, "edges", found, planar),
        lambda: require(one_rod, "edges", found, "open in a bundle of fibres: the yarn is one rod in a chain"),
        lambda: require(loops > 1 or edges.bottom == "open", "edges.bottom", "cast-on", "open in a row of one loop"),
    )
