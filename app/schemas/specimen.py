"""Models of the specimen in a protocol file: knit, yarn, and what goes beyond elastic rods."""

from typing import Annotated, Final, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from app.schemas.base import BRANCH, Model
from app.schemas.units import allowed
from app.schemas.values import LAID_IN, Label, LaidIn, Length, Names, StitchValue, Strain, Stress, Switch
from app.schemas.yarns import MeasuredYarnModel, is_measured
from knitlab_core.knits import fabric_names
from knitlab_core.materials import MATERIALS
from rigs.axes import Axis
from rigs.protocol.catalogue import Grips, Hook
from rigs.protocol.specimen import MeshName, RestShape, Rupture, Shear

_LENGTH: Final = "a number of loop widths, or a length with its unit, such as 0.4 mm"
_STITCH = Field(description=_LENGTH)


def _rupture(value: object) -> object:
    """Return how a rupture is met: `on` stops the test."""
    if value is True or value is False:
        return "stop" if value else "off"
    return "stop" if value == "on" else value


RuptureSwitch = Annotated[Rupture, BeforeValidator(_rupture)]


class StitchModel(Model):
    """Values of a stitch."""

    curvature: StitchValue = Field(description="a pure number, such as 1.5")
    height: StitchValue = _STITCH
    depth: StitchValue = _STITCH
    row_spacing: StitchValue = _STITCH
    fibre_radius: StitchValue = _STITCH


class VolumetricStitchModel(Model):
    """Values of a volumetric stitch."""

    curvature: StitchValue = Field(description="a pure number, such as 1.5")
    wale_height: StitchValue = _STITCH
    pile_height: StitchValue = _STITCH
    depth: StitchValue = _STITCH
    row_spacing: StitchValue = _STITCH
    layer_spacing: StitchValue = _STITCH
    fibre_radius: StitchValue = _STITCH


class FilamentModel(Model):
    """Take a straight filament in the place of a knit."""

    filament: StitchValue = Field(description="the diameter of a straight filament as long as `loop`, such as 1 mm")


class CentrelineModel(Model):
    """Take a yarn of the user's own in the place of a knit."""

    centreline: str = Field(
        description="a CSV file of points beside the protocol, such as my-knit.csv, or its text of several lines"
    )
    unit: str | None = Field(default=None, description="the unit of its coordinates where its header has none: mm")
    fibre_radius: StitchValue = _STITCH


CENTRELINE: Final = f"{BRANCH}centreline"
FILAMENT: Final = f"{BRANCH}filament"
VOLUMETRIC: Final = f"{BRANCH}volumetric"
MEASURED: Final = f"{BRANCH}measured"


def _knit_branch(value: object) -> str:
    """Return the branch of the union that a knit belongs to: a name, or the values of one kind of fabric."""
    if not isinstance(value, dict):
        return f"{BRANCH}name"
    if "filament" in value:
        return FILAMENT
    if "centreline" in value:
        return CENTRELINE
    only_there = set(VolumetricStitchModel.model_fields) - set(StitchModel.model_fields)
    return VOLUMETRIC if only_there & set(value) else f"{BRANCH}values"


class YarnModel(Model):
    """Make the yarn of fibres."""

    fibres: int = Field(description="a whole number from 1 to 64")
    model: Literal["yarn", "bundle"] = Field(
        default="yarn", description="yarn, one rod for all fibres, or bundle, each fibre a rod of its own"
    )
    fibre_radius: StitchValue | None = Field(default=None, description=_LENGTH)
    winding_radius: StitchValue | None = Field(default=None, description=_LENGTH)
    twist: float = Field(default=0.0, description="a number of radians per loop width of yarn, such as 2")
    phase: float = Field(default=0.0, description="a number of radians")
    bonding: float | None = Field(default=None, description="a number from 0, loose fibres, to 1, glued ones")


def _yarn_branch(value: object) -> str:
    """Return the branch of the union that a yarn belongs to: by measurement, or made of fibres."""
    return MEASURED if is_measured(value) else f"{BRANCH}fibres"


class FusedModel(Model):
    """Fuse strands that were printed near each other."""

    gap: Length = Field(description="the gap below which strands are fused, such as 0.3 mm")
    patch_radius: Length = Field(description="the radius of a fused point, such as 0.1 mm")
    strength: Stress = Field(description="the tension at which it breaks, such as 20 MPa")
    shear_strength: Stress | None = Field(default=None, description="the shear at which it breaks, such as 12 MPa")
    locate: Strain = Field(default=0.01, description="how near to its strength it breaks, such as 1 %")


class EdgesModel(Model):
    """Chain edges of a planar knit."""

    top: Literal["open", "bound-off"] = Field(
        default="open", description="open or bound-off, a last row that is chained"
    )
    bottom: Literal["open", "cast-on"] = Field(
        default="open", description="open or cast-on, a chain below the first row"
    )
    slack: Strain = Field(
        default=0.0, description="the yarn of a stitch of the chain beyond that of a tight one, such as 10 %"
    )


class GripsModel(Model):
    """Hold the edges of each axis by hooks or by clamps."""

    C: Grips = Field(default="hooks", description="hooks or clamps, of the edges along the course")
    W: Grips = Field(default="hooks", description="hooks or clamps, of the edges along the wale")

    @property
    def by_axis(self) -> dict[Axis, Grips]:
        """Return the grips of each axis that is named."""
        named: dict[Axis, Grips] = {"C": self.C, "W": self.W}
        return {axis: grips for axis, grips in named.items() if axis in self.model_fields_set}


class SpecimenModel(Model):
    """The specimen on the rig."""

    knit: Annotated[
        Annotated[str, Names(fabric_names, "examples"), Tag(f"{BRANCH}name")]
        | Annotated[StitchModel, Tag(f"{BRANCH}values")]
        | Annotated[VolumetricStitchModel, Tag(VOLUMETRIC)]
        | Annotated[FilamentModel, Tag(FILAMENT)]
        | Annotated[CentrelineModel, Tag(CENTRELINE)],
        Discriminator(_knit_branch),
    ] = Field(description="the name of a knit, such as stockinette-default, or a mapping of stitch values")
    loops: list[int] = Field(
        min_length=2,
        max_length=3,
        description="[rows, loops in a row], such as [6, 6], and of a volumetric knit the layers, such as [6, 6, 6]",
    )
    loop: Length = Field(description=allowed("length"))
    material: Annotated[Label, Names(lambda: MATERIALS, "examples")] | None = Field(
        default=None, description="the name of a material, such as RGD8530-DM"
    )
    friction: float | None = Field(default=None, description="a coefficient of friction, such as 0.3")
    grips: Annotated[
        Annotated[Grips, Tag(f"{BRANCH}name")] | Annotated[GripsModel, Tag(f"{BRANCH}axes")],
        Discriminator(lambda value: f"{BRANCH}axes" if isinstance(value, dict | GripsModel) else f"{BRANCH}name"),
    ] = Field(
        default="hooks",
        description="hooks, clamps that hold the edge stitches as a whole, or a mapping such as {W: clamps, C: hooks}",
    )
    hook: Hook = Field(default="pin", description="pin or wire")
    pole_friction: float | None = Field(
        default=None, description="a coefficient of friction between hooks and their poles, such as 0.05"
    )
    mesh: MeshName | None = Field(default=None, description="draft, default or fine")
    nodes_per_loop: int | None = Field(default=None, description="a whole number, such as 48")
    rest_shape: RestShape = Field(default="as-printed", description="as-printed or straight")
    laid_in: LaidIn | None = Field(default=None, description=LAID_IN)
    edges: EdgesModel = Field(
        default=EdgesModel(),
        description="a mapping such as {top: bound-off, bottom: cast-on}; edges are open otherwise",
    )
    yarn: (
        Annotated[
            Annotated[YarnModel, Tag(f"{BRANCH}fibres")] | Annotated[MeasuredYarnModel, Tag(MEASURED)],
            Discriminator(_yarn_branch),
        ]
        | None
    ) = Field(
        default=None,
        description="a mapping that makes the yarn of fibres, such as {fibres: 3}, or one by measurement: "
        "{bending: 0.045 N mm^2, ...}",
    )
    fused: FusedModel | None = Field(
        default=None, description="a mapping such as {gap: 0.3 mm, patch_radius: 0.1 mm, strength: 20 MPa}"
    )
    viscoelastic: Switch = Field(default=False, description="on or off")
    yields: Switch = Field(default=False, alias="yield", description="on or off")
    rupture: RuptureSwitch = Field(default="off", description="off, stop or go on")
    periodic: Switch = Field(default=False, description="on, a cell of an endless fabric, or off")
    shear: Shear = Field(default="held", description="held, or free of shear stress: of a periodic cell")
