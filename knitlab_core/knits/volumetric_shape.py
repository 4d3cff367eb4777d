"""Shape of a volumetric stitch: a loop that holds the next row and one that holds the next layer."""

from __future__ import annotations

from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import GeometryError
from knitlab_core.knits.loop_shape import LARGEST, check_number
from knitlab_core.knits.stitch import Stitch

if TYPE_CHECKING:
    from collections.abc import Mapping

_LARGEST: Final[Mapping[str, float]] = MappingProxyType(
    {**LARGEST, "wale_height": 2.0 * LARGEST["height"], "pile_height": 2.0 * LARGEST["height"], "layer_spacing": 10.0}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumetricShape:
    """Shape of one stitch of two loops, and the distances of rows and layers.

    Parameters
    ----------
    curvature : float
        ``a``: how far a loop bulges over its neck [1].
    wale_height : float
        ``H_w``: whole extent of the wale loop along the wale [loop widths].
    pile_height : float
        ``H_p``: whole extent of the pile loop along the pile [loop widths].
    depth : float
        ``d``: half of a loop's extent out of its own plane [loop widths].
    row_spacing : float
        ``w``: wale distance of neighbouring rows [loop widths].
    layer_spacing : float
        ``w_p``: pile distance of neighbouring layers [loop widths].
    fibre_radius : float
        ``r``: radius of the fibre [loop widths].

    Raises
    ------
    SpecificationError
        If a number is not finite, not positive or too large.
    GeometryError
        If a loop is no higher than the spacing that it must reach over: it would hold nothing.

    Notes
    -----
    Cline et al., "Entanglement-driven responses through multiscale 3D-printed knits", describe an extra loop per
    stitch that holds the layer above but give no formula; this construction is knitlab's own.
    """

    curvature: float
    wale_height: float
    pile_height: float
    depth: float
    row_spacing: float
    layer_spacing: float
    fibre_radius: float

    def __post_init__(self) -> None:
        for field in fields(self):
            check_number(field.name, getattr(self, field.name), most=_LARGEST[field.name])
        for spacing, height in (("row_spacing", "wale_height"), ("layer_spacing", "pile_height")):
            found, limit = getattr(self, spacing), getattr(self, height)
            if found >= limit:
                allowed = f"less than stitch.{height}, which is {limit!r}: a loop must reach over the spacing"
                raise GeometryError(f"stitch.{spacing}", found, allowed)

    @property
    def wale_loop(self) -> Stitch:
        """Return the planar stitch (h = H_w/2) that the wale loop is one loop of."""
        return self._planar(self.wale_height, self.row_spacing)

    @property
    def pile_loop(self) -> Stitch:
        """Return the planar stitch (h = H_p/2, rows w_p apart) that the pile loop is, turned into x-z."""
        return self._planar(self.pile_height, self.layer_spacing)

    def _planar(self, whole_height: float, spacing: float) -> Stitch:
        return Stitch(
            curvature=self.curvature,
            height=0.5 * whole_height,
            depth=self.depth,
            row_spacing=spacing,
            fibre_radius=self.fibre_radius,
        )
