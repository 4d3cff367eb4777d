"""Refuse a value out of its bounds where it is said."""

from __future__ import annotations

import re

from knitlab_core.errors import SpecificationError

_LABEL = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,63}(?<! )")


def require(allowed: bool, name: str, found: object, expected: str) -> None:  # noqa: FBT001 (reads as "require that")
    """Raise `SpecificationError` unless the condition holds."""
    if not allowed:
        raise SpecificationError(name, found, expected)


def require_label(name: str, label: str | None) -> None:
    """Raise unless `label` may name files and columns."""
    fine = label is None or _LABEL.fullmatch(label) is not None
    require(fine, name, label, "up to 64 letters, digits, spaces, '.', '_' and '-', the first a letter or digit")
