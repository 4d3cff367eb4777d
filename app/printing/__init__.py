"""Surface of a knit for a 3D printer: meshes, checks, files, layers.

printers  what a printer can resolve
surface   one closed tube along a polyline
fibres    the tubes of a specimen, as fine as the printer
gap       how far the surfaces stay from each other
checks    found and allowed, one row each
files     STL and 3MF
slices    sections, layer by layer
sheets    ... as pictures
job       all of it, for the command line
show      the outcome as a table or plain data

Lengths are in mm, as in the files; specimens come in SI.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

from knitlab_core.errors import SpecificationError

_PACKAGES: Final = ("trimesh", "lxml", "networkx")


def require_extra() -> None:
    """Raise unless the packages of the extra ``printing`` are installed.

    Raises
    ------
    SpecificationError
        Naming what is missing and how to get it.
    """
    missing = [name for name in _PACKAGES if find_spec(name) is None]
    if missing:
        found = f"an installation without {', '.join(missing)}"
        raise SpecificationError("printing", found, "one with the extra: pip install 'knitlab[printing]'")
