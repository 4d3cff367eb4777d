"""File that lists tests: runs and measured files, by their paths from where it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from app.schemas.document import parse_text, read_text
from app.schemas.errors import ProtocolError, nearest, shown

if TYPE_CHECKING:
    from pathlib import Path

    from app.schemas.document import Data, Document, Place

SCHEMA: Final = "knitlab/tests@1"
SUFFIXES: Final = {".yaml", ".yml"}
_FIELDS: Final = ("schema", "tests")
_LIST: Final = "a list of run folders and measured files, such as [runs/a, fabric.csv]"


def listed(path: Path) -> list[Path]:
    """Return the tests that a YAML file of schema ``knitlab/tests@1`` lists; any other path as it is.

    Raises
    ------
    ProtocolError
        For whatever is wrong with the file, in one line with file, line and column.
    """
    if path.suffix.lower() not in SUFFIXES or path.is_dir():
        return [path]
    document = parse_text(read_text(path, "list"), str(path), "list")
    data = document.data if isinstance(document.data, dict) else {}
    if data.get("schema") != SCHEMA:
        raise _refusal(document, ("schema",), data.get("schema"), SCHEMA)
    for name in data:
        if name not in _FIELDS:
            spot, allowed = document.spot((name,), key=True), ", ".join(_FIELDS)
            raise ProtocolError(document.path, spot, name, "an unknown field", f"{allowed}{nearest(name, _FIELDS)}")
    tests = data.get("tests")
    if not isinstance(tests, list) or not tests:
        raise _refusal(document, ("tests",), tests, _LIST)
    found = []
    for number, one in enumerate(tests):
        if not isinstance(one, str) or not (path.parent / one).exists():
            raise _refusal(document, ("tests", number), one, "a run folder or a measured file that is there")
        found.append(path.parent / one)
    return found


def _refusal(document: Document, place: Place, found: Data, expected: str) -> ProtocolError:
    """Return an error at a value."""
    name = ".".join(map(str, place))
    said = "nothing" if found is None else shown(found)
    return ProtocolError(document.path, document.spot(place), name, said, expected)
