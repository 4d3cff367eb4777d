"""Numbers and dates as written in a country, and dialects in its form.

Assumed: where the comma marks decimals the semicolon stands between fields, as spreadsheets of that country read it,
thousands are not marked, and headings stay English. The files are UTF-8 without a byte-order mark.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from knitlab_core.errors import SpecificationError
from rigs.logs.dialect import EN, Locale

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.logs.dialect import Dialect

LOCALES: Final[Mapping[str, Locale]] = {
    "en": EN,
    "de": Locale(name="de", delimiter=";", decimal=",", thousands="", day="%d.%m.%Y"),
    "fr": Locale(name="fr", delimiter=";", decimal=",", thousands="", day="%d/%m/%Y"),
}


def localised(dialect: Dialect, name: str) -> Dialect:
    """Return a dialect as a machine of another country writes it.

    Raises
    ------
    SpecificationError
        If the locale is unknown, or the dialect is the same everywhere.
    """
    if name not in LOCALES:
        raise SpecificationError("locale", name, f"one of {', '.join(LOCALES)}")
    locale = LOCALES[name]
    if locale == dialect.locale:
        return dialect
    if dialect.delimiter != dialect.locale.delimiter:
        raise SpecificationError("locale", name, f"{dialect.locale.name} for {dialect.name}, the same everywhere")
    return replace(dialect, delimiter=locale.delimiter, locale=locale)
