"""Say what hangs on the hooks, and make it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from knitlab_core.knits import NAMED_STITCHES, Specimen, Stitch, planar_specimen
from knitlab_core.materials import DEFAULT_FRICTION, material_named
from rigs.bounds import require
from rigs.record import SpecimenSize

if TYPE_CHECKING:
    from knitlab_core.knits import SiteSet
    from rigs.record import FloatArray
    from rigs.steps import Axis

MAX_STITCHES: Final = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecimenSpec:
    """Name the knit on the rig.

    Parameters
    ----------
    knit : str or Stitch
        A named set of stitch values, or the values themselves [loop widths].
    rows, loops : int
        Rows, and loops in a row [1].
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

    knit: str | Stitch
    rows: int
    loops: int
    loop_width: float
    material: str
    friction: float = DEFAULT_FRICTION.value
    nodes_per_loop: int = 48
    rest_shape: Literal["as-printed"] = "as-printed"

    def __post_init__(self) -> None:
        if isinstance(self.knit, str):
            names = ", ".join(NAMED_STITCHES)
            require(self.knit in NAMED_STITCHES, "knit", self.knit, f"one of {names}, or a mapping of stitch values")
        for name, count in (("rows", self.rows), ("loops", self.loops)):
            require(1 <= count <= 200, name, count, "a whole number from 1 to 200")
        count = self.rows * self.loops
        require(count <= MAX_STITCHES, "loops", [self.rows, self.loops], f"{MAX_STITCHES} stitches or fewer")
        width = self.loop_width
        require(1e-6 <= width <= 1.0, "loop_width", f"{width:g} m", "a length from 1 um to 1 m")
        material_named(self.material, "material")
        require(0.0 <= self.friction <= 2.0, "friction", self.friction, "a coefficient from 0 to 2")
        require(
            8 <= self.nodes_per_loop <= 1000, "nodes_per_loop", self.nodes_per_loop, "a whole number from 8 to 1000"
        )

    @property
    def layers(self) -> int:
        """Return how many layers lie on each other along the pile: one."""
        return 1

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes across which the knit has faces with boundary sites."""
        return ("C", "W")

    @property
    def stitch(self) -> Stitch:
        """Return the stitch, by name or by value."""
        return NAMED_STITCHES[self.knit] if isinstance(self.knit, str) else self.knit


def make_specimen(spec: SpecimenSpec) -> Specimen:
    """Make a specimen as it was printed.

    Raises
    ------
    GeometryError
        If it cannot exist: strands overlap, or rows do not hold each other.
    """
    return planar_specimen(
        spec.stitch,
        rows=spec.rows,
        loops=spec.loops,
        loop_width=spec.loop_width,
        nodes_per_loop=spec.nodes_per_loop,
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
        "C": float(at["course+"][0] - at["course-"][0]),
        "W": float(at["wale+"][1] - at["wale-"][1]),
    }


def size_of(specimen: Specimen, *, thickness: float) -> SpecimenSize:
    """Return the extents of a specimen; a planar one has the thickness that is agreed [m]."""
    lengths = gauge_lengths(specimen)
    return SpecimenSize(
        extents={"P": thickness, **lengths},
        fibre_radius=specimen.radius,
        convention="specimen" if "P" in lengths else "unit",
    )
