"""What the yarn of a specimen is made of: a material by its name, or a yarn by measurement; and its friction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.schemas.locate import at
from app.schemas.yarns import MeasuredYarnModel, to_inline_yarn
from knitlab_core.errors import SpecificationError
from knitlab_core.materials import DEFAULT_FRICTION, MATERIALS, MeasuredYarn, material_named

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Document
    from app.schemas.specimen import SpecimenModel
    from knitlab_core.materials import Substance


def substance_of(model: SpecimenModel, known: Mapping[str, Substance], document: Document) -> Substance:
    """Return the material that is named, or the yarn by measurement that is given in its place.

    Raises
    ------
    ProtocolError
        For an unknown name, neither or both, or numbers that no yarn can have.
    """
    with at(document, ("specimen",)):
        if isinstance(model.yarn, MeasuredYarnModel):
            if model.material is not None:
                found, allowed = f"{model.material} beside a yarn by measurement", "one of the two"
                raise SpecificationError("material", found, allowed)
            if model.yarn.friction is not None and model.friction is not None:
                found, allowed = f"{model.friction:g} here and {model.yarn.friction:g} in yarn", "one of the two"
                raise SpecificationError("friction", found, allowed)
            return to_inline_yarn(model.yarn)
        if model.material is None:
            raise SpecificationError("material", None, "the name of a material, or a yarn by measurement under yarn")
        return material_named(model.material, "material", known=known)


def by_name(substance: Substance) -> str | Substance:
    """Return the name of a material of the catalogue, any other itself."""
    return substance.name if MATERIALS.get(substance.name) is substance else substance


def friction_of(model: SpecimenModel, substance: Substance | None) -> float:
    """Return the coefficient of friction: the specimen's, else the yarn's own, else what is usual."""
    if model.friction is not None:
        return model.friction
    own = substance.friction if isinstance(substance, MeasuredYarn) else None
    return DEFAULT_FRICTION.value if own is None else own.value
