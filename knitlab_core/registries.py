"""Names of parts that can be registered from outside knitlab: fabrics, rigs, machines, dialects of logs."""

import re
from typing import Final, TypeVar

from knitlab_core.errors import SpecificationError

_PartT = TypeVar("_PartT")
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,63}")


def register_part(kind: str, parts: dict[str, _PartT], name: str, part: _PartT) -> None:
    """Give a part a name among those of its kind; the same part may be registered again.

    Raises
    ------
    SpecificationError
        If the name is none, or another part has it already.
    """
    if not _NAME.fullmatch(name):
        raise SpecificationError(kind, name, "a letter, then up to 63 letters, digits, _, . and -")
    if parts.get(name, part) != part:
        raise SpecificationError(kind, name, f"a name that no other {kind} has")
    parts[name] = part
