"""Fabrics that have a name: the names that a protocol may have in the place of a knit's numbers.

To add a stitch, write its file beside this one and add its names to `_FABRICS`. A fabric from outside knitlab is added
by `register`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError
from knitlab_core.knits.garter import NAMED_GARTERS
from knitlab_core.knits.rib import NAMED_RIBS
from knitlab_core.knits.seed import NAMED_SEEDS
from knitlab_core.knits.stitch import NAMED_STITCHES
from knitlab_core.knits.volumetric_stitch import NAMED_VOLUMETRIC_STITCHES
from knitlab_core.registries import register_part

if TYPE_CHECKING:
    from knitlab_core.knits.fabric import Fabric

_FABRICS: Final[dict[str, Fabric]] = {
    **NAMED_STITCHES,
    **NAMED_VOLUMETRIC_STITCHES,
    **NAMED_RIBS,
    **NAMED_GARTERS,
    **NAMED_SEEDS,
}


def fabric_names() -> tuple[str, ...]:
    """Return the names of all fabrics, in the order in which they were added."""
    return tuple(_FABRICS)


def fabric_named(name: str) -> Fabric:
    """Return a fabric by its name.

    Raises
    ------
    SpecificationError
        If none has it.
    """
    if name not in _FABRICS:
        raise SpecificationError("knit", name, f"one of {', '.join(_FABRICS)}, or a mapping of stitch values")
    return _FABRICS[name]


def register(name: str, fabric: Fabric) -> None:
    """Give a fabric a name for as long as this process lives; protocols may use it from then on.

    Parameters
    ----------
    name : str
        A letter, then up to 63 letters, digits, ``_``, ``.`` and ``-``.
    fabric : Fabric
        A frozen dataclass that keeps what `Fabric` promises.

    Raises
    ------
    SpecificationError
        If the name is none, or another fabric has it already.
    """
    register_part("fabric", _FABRICS, name, fabric)
