"""Bounds of the values of a protocol, checked when its parts are made."""

from __future__ import annotations

import unicodedata
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError, raise_all

if TYPE_CHECKING:
    from collections.abc import Callable

LONGEST_LABEL: Final = 64
"""Characters that a name or a tag may have; in UTF-8 each takes up to four bytes."""

LABEL: Final = (
    f"up to {LONGEST_LABEL} letters of any script, digits, blanks, brackets and signs but / \\ , ; \" ' = + and @, "
    "the first a letter, a digit or a bracket"
)

#: Separators of the fields of a log or a path, and signs that make a cell a formula.
_FORBIDDEN: Final = frozenset("/\\,;\"'=+@")
#: Unicode categories of what is not printed, ends a line, or is no character; signs that turn the text around them.
_UNPRINTED: Final = frozenset({"Cc", "Cs", "Zl", "Zp"})
_TURNS: Final = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\ufeff\ufffe\uffff")


def require(allowed: bool, name: str, found: object, expected: str) -> None:  # noqa: FBT001 (reads as "require that")
    """Raise `SpecificationError` unless the condition holds."""
    if not allowed:
        raise SpecificationError(name, found, expected)


def require_all(*checks: Callable[[], None]) -> None:
    """Make every check; raise the error of the first that fails, with those of others as its `more`."""
    faults = []
    for check in checks:
        try:
            check()
        except SpecificationError as error:
            faults.append(error)
    raise_all(faults)


def require_label(name: str, label: str | None) -> None:
    """Raise unless `label` may name a test or a step, and be in any log as it is."""
    require(label is None or is_label(label), name, label, LABEL)


def require_frequency(name: str, value: float | None) -> None:
    """Raise unless a rate of a log [Hz] is one."""
    found = "" if value is None else f"{value:g} Hz"
    require(value is None or 0.0 < value <= 1e4, name, found, "a frequency above 0 and up to 10 kHz")


def require_count(name: str, value: int | None) -> None:
    """Raise unless a number of cycles is one."""
    require(value is None or 1 <= value <= 10_000, name, value, "a whole number from 1 to 10000")


def is_label(text: str) -> bool:
    """Return whether a text may name a test or a step.

    Examples
    --------
    >>> [is_label(text) for text in ("Prüfling (2)", "a/b", "=1+1", " ")]
    [True, False, False, False]
    """
    whole = 0 < len(text) <= LONGEST_LABEL and text == text.strip()
    return whole and all(map(may_stand, text)) and may_begin(text[0])


def as_label(text: str, otherwise: str = "test") -> str:
    """Return a text as a label: what may not be in one becomes ``_``, or is left out where one begins.

    Examples
    --------
    >>> as_label("Prüfling (2)"), as_label("=C+W, second "), as_label("...")
    ('Prüfling (2)', 'C_W_ second', 'test')
    """
    plain = "".join(sign if may_stand(sign) else "_" for sign in text).strip()
    first = next((number for number, sign in enumerate(plain) if may_begin(sign)), len(plain))
    return plain[first:][:LONGEST_LABEL].strip() or otherwise


def may_stand(sign: str) -> bool:
    """Return whether a sign may be in a label; wide forms are refused with the sign they are a form of."""
    plain = set(unicodedata.normalize("NFKC", sign))
    return unicodedata.category(sign) not in _UNPRINTED and sign not in _TURNS and not plain & _FORBIDDEN


def may_begin(sign: str) -> bool:
    """Return whether a sign may be the first of a label: a letter, a digit or an opening bracket."""
    return unicodedata.category(sign)[0] in "LN" or unicodedata.category(sign) == "Ps"
