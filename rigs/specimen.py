"""Say what hangs on the hooks, and make it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from knitlab_core.knits import (
    NAMED_STITCHES,
    NAMED_VOLUMETRIC_STITCHES,
    Specimen,
    Stitch,
    VolumetricStitch,
    planar_specimen,
    volumetric_specimen,
)
from knitlab_core.materials import DEFAULT_FRICTION, material_named
from rigs.bounds import require
from rigs.fixtures import COORDINATE, SITES
from rigs.record import SpecimenSize

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.knits import SiteSet
    from rigs.record import FloatArray
    from rigs.steps import Axis

MAX_STITCHES: Final = 10_000

NAMED_KNITS: Final[Mapping[str, Stitch | VolumetricStitch]] = {**NAMED_STITCHES, **NAMED_VOLUMETRIC_STITCHES}
"""Knits that have a name, planar and volumetric."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecimenSpec:
    """Name the knit on the rig.

    Parameters
    ----------
    knit : str, Stitch or VolumetricStitch
        A named set of stitch values, or the values themselves [loop widths].
    rows, loops : int
        Rows, and loops (of a volumetric knit: stitches of two loops) in a row [1].
    layers : int
        Layers along the pile [1]; a planar knit has one.
    loop_width : float
        Width of one loop, l [m].
    material : str
        Name in the catalogue of materials.
    friction : float
        Coulomb coefficient between strands [1].
    nodes_per_loop : int
        Nodes of the yarn in one loop [1].
    rest_shape : 'as-printed'
        Shape the yarn is at rest in; 'straight' joins it with machine-knitted cotton.
    """

    knit: str | Stitch | VolumetricStitch
    rows: int
    loops: int
    loop_width: float
    material: str
    layers: int = 1
    friction: float = DEFAULT_FRICTION.value
    nodes_per_loop: int = 48
    rest_shape: Literal["as-printed"] = "as-printed"

    def __post_init__(self) -> None:
        if isinstance(self.knit, str):
            names = ", ".join(NAMED_KNITS)
            require(self.knit in NAMED_KNITS, "knit", self.knit, f"one of {names}, or a mapping of stitch values")
        for name, count in (("rows", self.rows), ("loops", self.loops), ("layers", self.layers)):
            require(1 <= count <= 200, name, count, "a whole number from 1 to 200")
        planar = isinstance(self.stitch, Stitch)
        require(self.layers == 1 or not planar, "layers", self.layers, "1: a planar knit has one layer")
        count = self.rows * self.loops * self.layers
        require(count <= MAX_STITCHES, "loops", f"{count} stitches", f"{MAX_STITCHES} stitches or fewer")
        width = self.loop_width
        require(1e-6 <= width <= 1.0, "loop_width", f"{width:g} m", "a length from 1 um to 1 m")
        material_named(self.material, "material")
        require(0.0 <= self.friction <= 2.0, "friction", self.friction, "a coefficient from 0 to 2")
        require(
            8 <= self.nodes_per_loop <= 1000, "nodes_per_loop", self.nodes_per_loop, "a whole number from 8 to 1000"
        )

    @property
    def stitch(self) -> Stitch | VolumetricStitch:
        """Return the stitch, by name or by value."""
        return NAMED_KNITS[self.knit] if isinstance(self.knit, str) else self.knit

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes across which the knit has faces with boundary sites."""
        return ("C", "W") if isinstance(self.stitch, Stitch) else ("C", "W", "P")


def make_specimen(spec: SpecimenSpec) -> Specimen:
    """Make a specimen as it was printed.

    Raises
    ------
    GeometryError
        If it cannot exist: strands overlap, or rows or layers do not hold each other.
    """
    rows, loops, width, nodes = spec.rows, spec.loops, spec.loop_width, spec.nodes_per_loop
    stitch = spec.stitch
    if isinstance(stitch, Stitch):
        return planar_specimen(stitch, rows=rows, loops=loops, loop_width=width, nodes_per_loop=nodes)
    return volumetric_specimen(
        stitch, rows=rows, loops=loops, layers=spec.layers, loop_width=width, nodes_per_loop=nodes
    )


def gauge_lengths(specimen: Specimen) -> dict[Axis, float]:
    """Return the initial hook-to-hook distance of each axis: between the means of opposite boundary sites [m].

    A site is a place on the printed yarn. The node that stands for it lies beside the yarn, the further the coarser
    the mesh.
    """
    at: dict[SiteSet, FloatArray] = {}
    for name, nodes in specimen.sites.items():
        places = specimen.centreline.position(specimen.arc_lengths[nodes] / specimen.loop_width)
        at[name] = specimen.loop_width * places.mean(axis=0)
    return {
        axis: float(at[far][COORDINATE[axis]] - at[near][COORDINATE[axis]])
        for axis, (near, far) in SITES.items()
        if near in at
    }


def size_of(specimen: Specimen, *, thickness: float) -> SpecimenSize:
    """Return the extents of a specimen; a planar one has the thickness that is agreed [m]."""
    lengths = gauge_lengths(specimen)
    return SpecimenSize(
        extents={"P": thickness, **lengths},
        fibre_radius=specimen.radius,
        convention="specimen" if "P" in lengths else "unit",
    )
