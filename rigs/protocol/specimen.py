"""Specimen of a test, as a protocol describes it; `made_specimen` has what is made of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import Counts, Fabric, Stitch, Yarn, fabric_named, has_cells
from knitlab_core.knits.cell_rows import LEANING
from knitlab_core.materials import DEFAULT_FRICTION, Material, MeasuredYarn, material_named
from rigs.protocol.bounds import require, require_all
from rigs.protocol.edges import OPEN, Edges, require_chainable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from knitlab_core.contact.bond_law import BondLaw
    from knitlab_core.materials import Substance
    from rigs.axes import Axis

MAX_STITCHES: Final = 10_000

MeshName: TypeAlias = Literal["draft", "default", "fine"]

MESHES: Final[Mapping[MeshName, int]] = {"draft": 32, "default": 48, "fine": 96}
"""Nodes per loop that have a name."""

MESH_ERRORS: Final[Mapping[int, float]] = {32: 0.03, 48: 0.01, 96: 0.003}
"""Largest error of peak forces of printed knits at 40 % strain by nodes per loop [1] (decision 0018)."""

Shear: TypeAlias = Literal["held", "free"]
RestShape: TypeAlias = Literal["as-printed", "straight"]
Rupture: TypeAlias = Literal["off", "stop", "go on"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecimenSpec:
    """Specimen on the rig.

    Parameters
    ----------
    knit : str or Fabric
        A fabric by its name, or the fabric itself [loop widths]; of a straight filament the loop width is the length.
    rows, loops : int
        Rows, and loops (of a volumetric knit: stitches of two loops) in a row [1].
    layers : int
        Layers along the pile [1]; a planar knit has one.
    loop_width : float
        Width of one loop, l [m].
    material : str, Material or MeasuredYarn
        Name in the catalogue of materials, a material of one's own, or the yarn itself by measurement.
    friction : float
        Coulomb coefficient between strands [1].
    nodes_per_loop : int
        Nodes of the yarn in one loop [1].
    rest_shape : {'as-printed', 'straight'}
        Shape the yarn is at rest in; a straight one is bent into the knit before the test.
    yarn : Yarn or None
        The fibres of the yarn [loop widths]; None is one of the stitch's own radius.
    fused : BondLaw or None
        Which strands were printed so near that they are fused, and what their bonds bear; None for none.
    viscoelastic : bool
        Whether the yarn relaxes as its material says; contacts stay elastic.
    yields : bool
        Whether the yarn yields as its material's curve says; contacts stay elastic.
    rupture : {'off', 'stop', 'go on'}
        Whether fibres break at their material's breaking strain, and whether the test ends with the first.
    periodic : bool
        Whether it is a cell of an endless fabric: its rows go on without ends and it has no edges.
    shear : {'held', 'free'}
        Whether a periodic cell stays upright or leans until it carries no shear stress.
    laid_in : float or None
        Contact radius of a straight yarn as it is laid in [m], from which it grows to its own as it relaxes; None for
        its own.
    relaxed : bool
        Whether its loops are laid in as those of a periodic cell of its yarn by measurement are at rest.
    edges : Edges
        Which of its edges are chained.
    """

    knit: str | Fabric
    rows: int
    loops: int
    loop_width: float
    material: str | Substance
    layers: int = 1
    friction: float = DEFAULT_FRICTION.value
    nodes_per_loop: int = MESHES["default"]
    rest_shape: RestShape = "as-printed"
    yarn: Yarn | None = None
    fused: BondLaw | None = None
    viscoelastic: bool = False
    yields: bool = False
    rupture: Rupture = "off"
    periodic: bool = False
    shear: Shear = "held"
    laid_in: float | None = None
    relaxed: bool = False
    edges: Edges = OPEN

    def __post_init__(self) -> None:
        require_all(
            self._require_knit,
            self._require_material,
            self._require_numbers,
            self._require_cell,
            self._require_laid_in,
            self._require_relaxed,
            self._require_edges,
        )

    def _require_knit(self) -> None:
        """Raise unless the knit is known, and has as many loops as such a knit can have."""
        fabric = self.fabric
        for name, count in (("rows", self.rows), ("loops", self.loops), ("layers", self.layers)):
            require(1 <= count <= 200, name, count, "a whole number from 1 to 200")
        require(self.layers == 1 or "P" in fabric.axes, "layers", self.layers, "1: a planar knit has one layer")
        if fabric.straight:
            require(self.rows == self.loops == 1, "loops", [self.rows, self.loops], "[1, 1]: a filament is no knit")
            plain = self.yarn is None and self.fused is None
            require(plain, "yarn", "a yarn of fibres, or fused points", "neither in a filament")
        count = self.rows * self.loops * self.layers
        require(count <= MAX_STITCHES, "loops", f"{count} stitches", f"{MAX_STITCHES} stitches or fewer")

    def _require_cell(self) -> None:
        """Raise if a periodic cell is asked for what only a specimen with edges has."""
        if not self.periodic:
            require(self.shear == "held", "shear", self.shear, "held: only a periodic cell is sheared (periodic: on)")
            return
        fabric = self.fabric
        layers = "P" in fabric.axes
        bundle = self.yarn is not None and self.yarn.model == "bundle" and self.yarn.fibres > 1
        require_all(
            lambda: require(has_cells(fabric), "periodic", "on", "off: this knit is not made of rows that repeat"),
            lambda: require(not layers or self.layers % 2 == 0, "layers", self.layers, LEANING),
            lambda: require(not bundle, "yarn.model", "bundle", "yarn in a periodic cell: one rod for all fibres"),
            lambda: require(self.fused is None, "fused", "fused points", "none in a periodic cell"),
            lambda: require(self.rupture == "off", "rupture", self.rupture, "off in a periodic cell"),
        )

    def _require_laid_in(self) -> None:
        """Raise unless a contact radius as laid in is one that a yarn can grow from as it relaxes."""
        # A yarn by measurement is refused with the rest that was not measured of it.
        if self.laid_in is None or self.measured is not None:
            return
        radius, found = self.fabric.fibre_radius * self.loop_width, f"{1e3 * self.laid_in:g} mm"
        allowed = f"a radius above 0 and up to the fibre's, {1e3 * radius:.4g} mm"
        relaxes = "none of a yarn at rest as printed: it does not relax (rest_shape: straight does)"
        plain = self.yarn is None and not self.periodic and not self.fabric.straight
        require_all(
            lambda: require(0.0 < self.laid_in <= radius, "laid_in", found, allowed),  # type: ignore[operator]
            lambda: require(self.rest_shape == "straight", "laid_in", found, relaxes),
            lambda: require(plain, "laid_in", found, "none of a yarn of fibres, a periodic cell or a filament"),
        )

    def _require_relaxed(self) -> None:
        """Raise unless the loops of a specimen can be those of a relaxed cell."""
        if not self.relaxed:
            return
        drawn = type(self.fabric) is Stitch
        straight = "a yarn that is straight at rest (rest_shape: straight): it is bent into its loops"
        require_all(
            lambda: require(
                self.measured is not None, "laid_in", "relaxed", "a radius: only a yarn by measurement is relaxed so"
            ),
            lambda: require(self.rest_shape == "straight", "laid_in", "relaxed", straight),
            lambda: require(
                not self.periodic, "laid_in", "relaxed", "nothing in a periodic cell, which is relaxed itself"
            ),
            lambda: require(drawn, "laid_in", "relaxed", "none of this knit: plain stockinette is relaxed so"),
        )

    def _require_edges(self) -> None:
        """Raise unless the edges that shall be chained are those of a knit that can have such."""
        if self.edges != OPEN:
            require_chainable(self.edges, self.fabric, self.loops, self.yarn, periodic=self.periodic)

    def _require_material(self) -> None:
        """Raise unless the material is known, with the numbers of all that it is asked to do."""
        material = self.substance
        if isinstance(material, MeasuredYarn):
            self._require_measured(material)
            return
        lacks = f"off: nothing is known of the {{}} of {material.name}"
        relaxes, breaks = len(material.relaxation) > 0, material.breaking_strain is not None
        plastic = len(material.yield_curve) > 0
        bending = "off in a yarn that is straight at rest: it is bent into the knit as if it were elastic"
        straight = self.rest_shape == "straight" and self.fused is not None
        fusing = "none in a yarn that is straight at rest: points fuse in print"
        require_all(
            lambda: require(not self.viscoelastic or relaxes, "viscoelastic", "on", lacks.format("relaxation")),
            lambda: require(self.rupture == "off" or breaks, "rupture", self.rupture, lacks.format("breaking strain")),
            lambda: require(not self.yields or plastic, "yield", "on", lacks.format("yield curve")),
            lambda: require(not (self.yields and self.rest_shape == "straight"), "yield", "on", bending),
            lambda: require(not straight, "fused", "fused points", fusing),
        )

    def _require_measured(self, yarn: MeasuredYarn) -> None:
        """Raise unless a yarn by measurement is asked for no more than was measured, and fits the fabric."""
        off, none = (f"{word}: {yarn.name} is a yarn by measurement, " for word in ("off", "none"))
        bears = "and what its fibres bear is not known: they are not straight along it"
        twice = 2.0 * yarn.radius.value
        laid = "" if self.laid_in is None else f"{1e3 * self.laid_in:g} mm"
        wide = f"{1e3 * yarn.radius.value:.4g} mm in loops {1e3 * self.loop_width:.4g} mm wide"
        diameter = 2.0 * self.fabric.fibre_radius * self.loop_width
        same = not self.fabric.straight or abs(diameter - twice) <= 1e-6 * twice
        measured = f"{1e3 * twice:.6g} mm, twice the radius of {yarn.name}"
        require_all(
            lambda: require(not self.viscoelastic, "viscoelastic", "on", f"{off}of which no relaxation is known"),
            lambda: require(not self.yields, "yield", "on", f"{off}of which no yield curve is known"),
            lambda: require(self.rupture == "off", "rupture", self.rupture, off + bears),
            lambda: require(self.fused is None, "fused", "fused points", f"{none}and points fuse in print"),
            lambda: require(self.yarn is None, "yarn", "fibres", f"{none}whose fibres are in its numbers"),
            lambda: require(
                self.laid_in is None,
                "laid_in",
                laid,
                f"{none}and its radius as laid in is not chosen, but relaxed may be",
            ),
            # A loop without a width is refused where all specimens' are.
            lambda: require(not 0.0 < self.loop_width < twice, "yarn.radius", wide, "half of that width at most"),
            lambda: require(same, "knit.filament", f"{1e3 * diameter:.4g} mm", measured),
        )

    def _require_numbers(self) -> None:
        """Raise unless loop width, friction and mesh are in their range."""
        width, nodes = self.loop_width, self.nodes_per_loop
        require_all(
            lambda: require(1e-6 <= width <= 1.0, "loop_width", f"{width:g} m", "a length from 1 um to 1 m"),
            lambda: require(0.0 <= self.friction <= 2.0, "friction", self.friction, "a coefficient from 0 to 2"),
            lambda: require(8 <= nodes <= 1000, "nodes_per_loop", nodes, "a whole number from 8 to 1000"),
        )

    @property
    def fabric(self) -> Fabric:
        """Return the fabric, by name or by value."""
        return fabric_named(self.knit) if isinstance(self.knit, str) else self.knit

    @property
    def counts(self) -> Counts:
        """Return how often the fabric repeats in it."""
        return Counts(self.rows, self.loops, self.layers)

    @property
    def substance(self) -> Substance:
        """Return the material, or the yarn by measurement, by name or by value."""
        return material_named(self.material, "material") if isinstance(self.material, str) else self.material

    @property
    def solid(self) -> Material:
        """Return the solid material.

        Raises
        ------
        SpecificationError
            For a yarn by measurement.
        """
        material = self.substance
        if isinstance(material, MeasuredYarn):
            raise SpecificationError("material", f"{material.name}, a yarn by measurement", "a solid material")
        return material

    @property
    def measured(self) -> MeasuredYarn | None:
        """Return the yarn by measurement; None for one of a solid material."""
        return self.substance if isinstance(self.substance, MeasuredYarn) else None

    @property
    def grows_to(self) -> float | None:
        """Return the contact radius to which the yarn of a cell grows as it is relaxed [m]; None where it does not."""
        measured = self.measured
        return (
            measured.radius.value if measured is not None and self.periodic and self.rest_shape == "straight" else None
        )

    @property
    def laid(self) -> Yarn | None:
        """Return the yarn that the knit is made of [loop widths]; None for a fibre of the fabric's own radius."""
        measured = self.measured
        if measured is None or self.fabric.straight or self.grows_to is not None:
            return self.yarn
        return Yarn(fibre_radius=measured.radius.value / self.loop_width)

    @property
    def breaks_at(self) -> float | None:
        """Return the strain at its surface at which a fibre breaks [1]; None where rupture is off."""
        material = self.substance
        limit = material.breaking_strain if isinstance(material, Material) else None
        return None if self.rupture == "off" or limit is None else limit.value

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes across which the knit has faces with boundary sites."""
        return self.fabric.axes
