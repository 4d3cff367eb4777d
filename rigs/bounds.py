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


def require_frequency(name: str, value: float | None) -> None:
    """Raise unless a rate of a log [Hz] is one."""
    found = "" if value is None else f"{value:g} Hz"
    require(value is None or 0.0 < value <= 1e4, name, found, "a frequency above 0 and up to 10 kHz")


def require_count(name: str, value: int | None) -> None:
    """Raise unless a number of cycles is one."""
    require(value is None or 1 <= value <= 10_000, name, value, "a whole number from 1 to 10000")
