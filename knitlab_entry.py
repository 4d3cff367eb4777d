"""The command `knitlab`, and the check that Python finds knitlab's own packages; it imports none of them at its top.

Packages with common names (`app`, `rigs`) may stand before ours on Python's search path, such as a folder `app` beside
a script. Imported in place of ours they fail far from the cause, so they are looked up, not imported, first.
"""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from importlib.machinery import ModuleSpec

PACKAGES: Final = ("app", "rigs", "knitlab_core")
INVALID_INPUT: Final = 2
"""Exit code, as of `app.cli.exit_codes.USAGE`, which cannot be imported before the check."""


def require_own(packages: tuple[str, ...] = PACKAGES) -> None:
    """Raise if Python would import another package in place of one of knitlab's.

    Raises
    ------
    ImportError
        With the path of the one that it would import.
    """
    for name in packages:
        found = _path_of(name)
        # Paths are compared after links are followed: some installers link every file into a folder.
        if found is not None and found.resolve() != Path(__file__).with_name(name).joinpath("__init__.py").resolve():
            shown = found.parent if found.name == "__init__.py" else found
            raise ImportError(
                f"module {name} at {shown} hides knitlab's; rename it or take its folder off Python's search path",
                name=name,
                path=str(shown),
            )


def main() -> None:
    """Run the command line; where another package hides one of knitlab's, print one line and leave."""
    try:
        require_own(("knitlab", *PACKAGES))
    except ImportError as error:
        sys.stderr.write(f"{error}\n")
        sys.exit(INVALID_INPUT)
    from app.cli.main import main as command  # noqa: PLC0415 (after the check)

    command()


def _path_of(name: str) -> Path | None:
    """Return the file of a package or module as Python would import it, or a folder without ``__init__.py``."""
    loaded = sys.modules.get(name)
    spec: ModuleSpec | None = getattr(loaded, "__spec__", None) if loaded is not None else find_spec(name)
    if spec is None:
        return None
    folders = list(spec.submodule_search_locations or ())
    if spec.has_location and spec.origin is not None:
        return Path(spec.origin)
    return Path(folders[0]) if folders else None
