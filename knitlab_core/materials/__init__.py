"""Materials of yarns, and yarns as they were measured, each number with its source."""

from knitlab_core.materials.catalogue import DEFAULT_FRICTION, MATERIALS, Substance, material_named
from knitlab_core.materials.solids import FIRST_POINT, CurvePoint, Material, RelaxationTerm, YieldElement
from knitlab_core.materials.values import Value
from knitlab_core.materials.yarns import MeasuredYarn

__all__ = [
    "DEFAULT_FRICTION",
    "FIRST_POINT",
    "MATERIALS",
    "CurvePoint",
    "Material",
    "MeasuredYarn",
    "RelaxationTerm",
    "Substance",
    "Value",
    "YieldElement",
    "material_named",
]
