"""Stockinette with its last row bound off, or a cast-on below its first row: a knit that does not unravel there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from knitlab_core.errors import GeometryError
from knitlab_core.knits.centreline import Centreline
from knitlab_core.knits.chain import Chain, EdgeShape, chain_along, loosened
from knitlab_core.knits.distance import closest_approach
from knitlab_core.knits.fabric import Clasps
from knitlab_core.knits.planar import arc_length_at

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.arrays import BoolArray, FloatArray
    from knitlab_core.axes import Axis
    from knitlab_core.knits.centreline import SiteSet
    from knitlab_core.knits.fabric import Counts, LoopBudget, Pin, PlateRoom
    from knitlab_core.knits.stitch import Stitch

_SAMPLES: Final = 40
"""Samples of a chain's bend per loop width."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundEdges:
    """Stockinette whose upper edge, lower edge or both are chained. A `Fabric`.

    Parameters
    ----------
    knit : Stitch
        The knit between the edges.
    top : bool
        Bound off: the yarn goes on from the last row through all its loops.
    bottom : bool
        Cast on: the yarn comes from a chain through the sinkers of the first row, which are one fewer than its loops.
    slack : float
        Yarn that a stitch of a chain has beyond that of one that is drawn tight, as a share of it [1].
    """

    knit: Stitch
    top: bool
    bottom: bool
    slack: float = 0.0

    @property
    def fibre_radius(self) -> float:
        """Return the radius of a yarn of one fibre [loop widths]."""
        return self.knit.fibre_radius

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return course and wale."""
        return self.knit.axes

    @property
    def straight(self) -> bool:
        """Return False: it has loops."""
        return False

    @property
    def description(self) -> str:
        """Return what a table calls it."""
        return self.knit.description

    @property
    def apex_distances(self) -> Mapping[SiteSet, float]:
        """Return the arc length from a site of each edge to its loop's apex [loop widths]."""
        return self.knit.apex_distances

    def loop_length(self, counts: Counts) -> float:
        """Return the yarn length of one loop of the knit [loop widths]."""
        return self.knit.loop_length(counts)

    def centreline(self, counts: Counts) -> Centreline:
        """Return the yarn with the sites of the knit: cast-on, rows, bound-off edge."""
        line, (below, above) = self.knit.centreline(counts), self._chains(counts)
        pieces = (*([below] if below else []), *line.pieces, *([above] if above else []))
        before = self._before(counts)
        sites = tuple(replace(site, arc_length=before + site.arc_length) for site in line.sites)
        return Centreline(pieces=pieces, sites=sites)

    def middle(self, counts: Counts) -> FloatArray:
        """Return the point (3,) midway between the knit's opposite edges [loop widths]."""
        return self.knit.middle(counts)

    def clasps(self, line: Centreline, counts: Counts) -> Mapping[str, Clasps]:  # noqa: ARG002 (the knit has its own)
        """Return the clasps between rows, and those of each edge.

        Of an edge of n loops (2 n - 1,): first its loops, which hold the chain's, then the chain's that hold the next;
        through the last of these the yarn's end is drawn, which is no clasp.
        """
        rows = self.knit.clasps(self.knit.centreline(counts), counts)["rows"]
        before, (below, above) = self._before(counts), self._chains(counts)
        found = {"rows": Clasps(heads=before + rows.heads, held=before + rows.held)}
        half_turns = np.pi * np.arange(-1.0, 2.0 * counts.loops)
        if above is not None:
            feet = before + arc_length_at(self.knit, counts.loops, counts.rows - 1, half_turns[::2])
            found["bound_off"] = _edge_clasps(above, before + self.knit.centreline(counts).length, feet)
        if below is not None:
            heads = before + arc_length_at(self.knit, counts.loops, 0, half_turns[1::2])
            found["cast_on"] = _edge_clasps(below, 0.0, heads)
        return found

    def chained(self, arc_lengths: FloatArray, counts: Counts) -> BoolArray:
        """Return which arc lengths (n,) are on the yarn of a chained edge [loop widths]."""
        first = self._before(counts)
        last = first + self.knit.centreline(counts).length
        on_edge: BoolArray = (arc_lengths < first) | (arc_lengths > last)
        return on_edge

    def check_held(self, counts: Counts) -> None:
        """Refuse rows that do not hold each other."""
        self.knit.check_held(counts)

    def clearance(self, line: Centreline, counts: Counts, *, loop_width: float) -> float:
        """Return the least distance between surfaces of strands [loop widths], or refuse strands that overlap."""
        inside = self.knit.clearance(self.knit.centreline(counts), counts, loop_width=loop_width)
        apart = closest_approach(line, largest_curvature=_sharpest(line)).distance - 2.0 * self.fibre_radius
        if inside > 0.0 and apart <= 0.0:
            found = f"strands of a bound edge {1e3 * loop_width * (apart + 2.0 * self.fibre_radius):.4g} mm apart"
            thinner = "a thinner yarn" if self.slack == 0.0 else "a thinner yarn or less slack"
            allowed = f"{thinner}: more than {2e3 * loop_width * self.fibre_radius:.4g} mm"
            raise GeometryError("specimen.edges", found, allowed)
        return min(inside, apart)

    def budgets(self, fibre_radius: float) -> Mapping[Axis, LoopBudget]:
        """Return the arc-length budget of the knit's loops."""
        return self.knit.budgets(fibre_radius)

    def leg(self, line: Centreline, counts: Counts, pin: Pin) -> float | None:
        """Return the arc length of the middle of a stitch's leg at +x [loop widths]."""
        leg = self.knit.leg(line, counts, pin)
        return None if leg is None else self._before(counts) + leg

    def clamp_faces(self, counts: Counts) -> Mapping[Axis, tuple[float, float]]:
        """Return where jaws end: those along the wale hold a chain with the row that it binds."""
        return self.knit.clamp_faces(counts)

    def plate_room(self, counts: Counts) -> PlateRoom | None:
        """Return None: it has no loops along the pile."""
        return self.knit.plate_room(counts)

    def _before(self, counts: Counts) -> float:
        """Return the length of the yarn before the first row [loop widths]."""
        below, _ = self._chains(counts)
        return 0.0 if below is None else below.length

    def _chains(self, counts: Counts) -> tuple[Chain | None, Chain | None]:
        """Return the chains below and above the knit."""
        knit, last = self.knit, counts.rows - 1
        shape = EdgeShape(
            loops=counts.loops,
            spacing=knit.row_spacing,
            height=knit.height,
            depth=knit.depth,
            front=knit.front,
            gap=knit.gap,
            first=0.5,
            start=-knit.height,
        )
        below = above = None
        if self.bottom:
            # Upside down the sinkers are heads, and the first row begins at the top of one.
            sinkers = shape._replace(loops=counts.loops - 1, first=1.0, start=knit.height)
            below = chain_along(
                loosened(sinkers, self.slack), words="cast-on", mirrored=False, upside_down=True, origin=(-0.5, 0.0)
            )
        if self.top:
            back = last % 2 == 0
            origin = (counts.loops - 0.5 if back else -0.5, last * knit.row_spacing)
            above = chain_along(
                loosened(shape, self.slack), words="bound-off", mirrored=back, upside_down=False, origin=origin
            )
        return below, above


def _edge_clasps(chain: Chain, before: float, ends: FloatArray) -> Clasps:
    """Return the clasps of an edge (2 n - 1,), whose loops end at arc lengths (n + 1,) in the order of growing x."""
    begins, first, heads, last = (before + chain.marks).T
    edge = np.stack([ends[:-1], ends[1:]], axis=-1)
    through = np.stack([begins[:-1], heads[:-1], begins[1:]], axis=-1)
    own = np.stack([first[:-2], last[:-2]], axis=-1)
    return Clasps(
        heads=np.concatenate([edge if _along(chain) else edge[::-1], own]),
        held=np.concatenate([through, through[1:]]),
    )


def _along(chain: Chain) -> bool:
    """Return whether a chain is made along +x."""
    first, last = chain.curve.position(chain.marks[[0, -1], 0])[:, 0]
    return bool(last > first)


def _sharpest(line: Centreline) -> float:
    """Return the largest curvature of a yarn [1/loop width]."""
    s = np.linspace(0.0, line.length, 1 + int(_SAMPLES * line.length))
    return float(np.linalg.norm(line.curvature(s), axis=-1).max())
