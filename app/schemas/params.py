"""Put the values of `params` where `${param}` stands for one: whole values only, no templates."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from app.schemas.document import dotted
from app.schemas.errors import ProtocolError, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Data, Document, Place

_PARAM: Final = re.compile(r"\$\{\s*([A-Za-z_]\w*)\s*\}")
_NAME: Final = re.compile(r"[A-Za-z_]\w*")


def substitute(document: Document, chosen: Mapping[str, Data] | None = None) -> Data:
    """Return the data of a document with every `${param}` replaced, by values `chosen` for it where there are any.

    Raises
    ------
    ProtocolError
        For a parameter that is not defined, not used, not a plain value, or used inside a text.
    """
    if not isinstance(document.data, dict) or "params" not in document.data:
        params: dict[str, Data] = {}
    else:
        params = dict(_checked(document, document.data["params"]))
    for name in chosen or {}:
        if name not in params:
            known = ", ".join(params) or "none"
            expected = f"NAME=VALUE with a name under params: {known}{nearest(name, params)}"
            raise ProtocolError(document.path, document.spot(("params",)), "--set", repr(name), expected)
    params |= chosen or {}
    used: set[str] = set()
    data = _replaced(document, document.data, (), params, used)
    for name in params:
        if name not in used:
            place = ("params", name)
            raise ProtocolError(
                document.path, document.spot(place, key=True), dotted(place), "no use of it", f"a use as ${{{name}}}"
            )
    return data


def _checked(document: Document, params: Data) -> dict[str, Data]:
    """Return the parameters, each a name and a plain value."""
    if not isinstance(params, dict):
        raise _refusal(document, ("params",), shown(params), "a mapping of names to values")
    for name, value in params.items():
        place = ("params", name)
        if not _NAME.fullmatch(name):
            raise _refusal(document, place, repr(name), "a name of letters, digits and _")
        if value is None or isinstance(value, dict | list) or (isinstance(value, str) and "${" in value):
            raise _refusal(document, place, shown(value), "a number or a text without ${")
    return params


def _replaced(document: Document, data: Data, place: Place, params: dict[str, Data], used: set[str]) -> Data:
    """Return data with parameters replaced, and note which were used."""
    if isinstance(data, dict):
        return {
            name: value if (*place, name) == ("params",) else _replaced(document, value, (*place, name), params, used)
            for name, value in data.items()
        }
    if isinstance(data, list):
        return [_replaced(document, item, (*place, number), params, used) for number, item in enumerate(data)]
    if not isinstance(data, str) or "${" not in data:
        return data
    match = _PARAM.fullmatch(data)
    if match is None:
        raise _refusal(document, place, shown(data), "a whole value such as ${name}, nothing around it")
    name = match[1]
    if name not in params:
        known = ", ".join(params) or "none"
        raise _refusal(document, place, shown(data), f"a name under params: {known}{nearest(name, params)}")
    used.add(name)
    return params[name]


def _refusal(document: Document, place: Place, found: str, expected: str) -> ProtocolError:
    """Return an error at a value."""
    return ProtocolError(document.path, document.spot(place), dotted(place), found, expected)
