"""Edges of a planar knit along its wale: open as they are knitted, or chained."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from knitlab_core.knits import Stitch
from rigs.protocol.bounds import require, require_all

if TYPE_CHECKING:
    from knitlab_core.knits import Fabric, Yarn


MOST_SLACK: Final = 0.35
"""Largest slack of a chain [1]."""


class Edges(NamedTuple):
    """Edges of a planar knit along its wale: `top`, its last row, and `bottom`, its first.

    `slack` is the yarn that a stitch of a chain has beyond that of one drawn tight, as a share of it [1].
    """

    top: Literal["open", "bound-off"] = "open"
    bottom: Literal["open", "cast-on"] = "open"
    slack: float = 0.0

    @property
    def chained(self) -> dict[str, str]:
        """Return the chained edges by name."""
        return {name: edge for name, edge in (("top", self.top), ("bottom", self.bottom)) if edge != "open"}


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
    found = ", ".join(f"{name}: {edge}" for name, edge in edges.chained.items())
    slack, allowed = f"{edges.slack:.4g}", f"0 to {MOST_SLACK:.0%} of a tight chain's yarn"
    require(bool(found), "edges.slack", slack, "0: no edge is chained")
    planar = "open in this knit: plain stockinette can be bound off and cast on"
    one_rod = yarn is None or yarn.model == "yarn"
    require_all(
        lambda: require(0.0 <= edges.slack <= MOST_SLACK, "edges.slack", slack, allowed),
        lambda: require(not periodic, "edges", found, "none: a periodic cell has no edges"),
        lambda: require(type(fabric) is Stitch, "edges", found, planar),
        lambda: require(one_rod, "edges", found, "open in a bundle of fibres: the yarn is one rod in a chain"),
        lambda: require(loops > 1 or edges.bottom == "open", "edges.bottom", "cast-on", "open in a row of one loop"),
    )
