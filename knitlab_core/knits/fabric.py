"""Protocol of a fabric: the members that specimens, fixtures and estimates use of any knit.

Lengths are in loop widths throughout, arc lengths are counted from the start of the yarn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping
    from dataclasses import Field

    from knitlab_core.arrays import FloatArray
    from knitlab_core.axes import Axis
    from knitlab_core.knits.centreline import Centreline, SiteSet


class Counts(NamedTuple):
    """Repeats of a fabric."""

    rows: int
    """Along the wale."""
    loops: int
    """In a row; stitches of two loops in a volumetric knit."""
    layers: int = 1
    """Along the pile."""


class Clasps(NamedTuple):
    """Stretches of the yarn that are held loops, and the heads that hold them [loop widths]."""

    heads: FloatArray
    """(..., 2) arc lengths of the two feet of each holding loop."""
    held: FloatArray
    """(..., 3) arc lengths of the apex of each held loop, between those of its neighbours along the row."""


class LoopBudget(NamedTuple):
    """Reach of the yarn of one loop."""

    locking: float
    """Equibiaxial strain at which the loop has used up its yarn (estimate) [1]."""
    share: float
    """Yarn spent along the loop's height over that spent along the course: twice the row spacing [1]."""
    fibre_radius: float
    """Radius of the yarn where strands cross [loop widths]."""
    error: float
    """By how much the locking strain may be off, rms [1]."""


class Pin(NamedTuple):
    """Stitch that a pin is in, counted from 0."""

    row: int
    """Along the wale."""
    loop: int
    """In the row, along the course."""
    layer: int = 0
    """Along the pile."""


class PlateRoom(NamedTuple):
    """Room for two load plates to be printed around [loop widths]."""

    height: float
    """From the feet of the bottom layer to the heads of the top one."""
    reach: float
    """How far plates reach over feet and heads unless told otherwise."""


class Fabric(Protocol):
    """Members that a specimen needs of a fabric; a frozen dataclass, equal where its numbers are."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __hash__(self) -> int:
        """Return the same number for equal fabrics."""

    @property
    def fibre_radius(self) -> float:
        """Return the radius of a yarn of one fibre [loop widths]."""

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes across which it has faces with boundary sites; layers repeat along ``P`` alone."""

    @property
    def straight(self) -> bool:
        """Return whether it is one straight strand without loops: clamps hold its ends, its strain is the fabric's."""

    @property
    def description(self) -> str:
        """Return what a table calls it where it has no name."""

    @property
    def apex_distances(self) -> Mapping[SiteSet, float]:
        """Return the arc length from a site of each edge to its loop's apex; empty where wires hold no loops."""

    def loop_length(self, counts: Counts) -> float:
        """Return the mean yarn length of one loop, turn-arounds left out: what a mesh divides [loop widths]."""

    def centreline(self, counts: Counts) -> Centreline:
        """Return the yarn with its named sites.

        Raises
        ------
        SpecificationError
            For counts that it cannot have.
        """

    def middle(self, counts: Counts) -> FloatArray:
        """Return the point (3,) midway between opposite faces, which becomes the origin [loop widths]."""

    def clasps(self, line: Centreline, counts: Counts) -> Mapping[str, Clasps]:
        """Return who holds whom on a centreline, by what is joined: ``rows`` or ``layers``; empty where unknown."""

    def check_held(self, counts: Counts) -> None:
        """Refuse a fabric whose loops do not hold each other.

        Raises
        ------
        GeometryError
            Naming what is not held.
        """

    def clearance(self, line: Centreline, counts: Counts, *, loop_width: float) -> float:
        """Return the least distance between surfaces of a yarn of one fibre [loop widths].

        Raises
        ------
        GeometryError
            Naming two places where strands overlap, or a bend tighter than the fibre; ``loop_width`` is for its mm.
        """

    def budgets(self, fibre_radius: float) -> Mapping[Axis, LoopBudget]:
        """Return the arc-length budget of its loops by the axis across the course along which they reach.

        Parameters
        ----------
        fibre_radius : float
            Radius of the yarn where strands cross: of a yarn of fibres another than its own [loop widths].
        """

    def leg(self, line: Centreline, counts: Counts, pin: Pin) -> float | None:
        """Return the arc length of the middle of a stitch's leg at +x [loop widths]; None where no stitch is known."""

    def clamp_faces(self, counts: Counts) -> Mapping[Axis, tuple[float, float]]:
        """Return where jaws end that hold the outermost stitches of the two edges along each axis [loop widths].

        They are coordinates of the centreline, between these stitches and the next; empty where clamps cannot hold.
        """

    def plate_room(self, counts: Counts) -> PlateRoom | None:
        """Return the room of load plates across ``P``; None where they would hold no loops."""
