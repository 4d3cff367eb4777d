"""Substitution of `params` for ``${param}``: whole values only, no templates."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from app.schemas.document import dotted
from app.schemas.errors import Faults, ProtocolError, Spot, nearest, shown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.schemas.document import Data, Document, Place

_PARAM: Final = re.compile(r"\$\{\s*([^\W\d]\w*)\s*\}")
_NAME: Final = re.compile(r"[^\W\d]\w*")


def substitute(document: Document, chosen: Mapping[str, Data], faults: Faults) -> tuple[Data, set[Spot]]:
    """Return the data of a document with every `${param}` replaced, by values `chosen` for it where there are any.

    Parameters
    ----------
    document : Document
        The protocol's text.
    chosen : Mapping
        Values for some of its parameters, in the place of its own.
    faults : Faults
        Takes what is wrong: a parameter that is not defined, not used, not a plain value, or used inside a text.

    Returns
    -------
    data : Data
        A parameter with mistakes is replaced by its text.
    unknown : set of Spot
        Where that is.

    Raises
    ------
    ProtocolError
        For a value chosen for what is no parameter.
    """
    given = document.data.get("params", {}) if isinstance(document.data, dict) else {}
    names = list(given) if isinstance(given, dict) else []
    params = _checked(document, given, faults)
    for name in chosen:
        if name not in names:
            known = ", ".join(names) or "none"
            expected = f"NAME=VALUE with a name under params: {known}{nearest(name, names)}"
            raise ProtocolError(document.path, document.spot(("params",)), "--set", repr(name), expected)
    work = _Replacing(document=document, params={**params, **chosen}, names=names, faults=faults)
    data = work.whole(document.data, ())
    for name in params:
        # A use that is misspelt leaves its parameter without one.
        if name not in work.used and not work.unknown:
            faults.found.append(_refusal(document, ("params", name), "no use of it", f"a use as ${{{name}}}", key=True))
    return data, work.unknown


def _checked(document: Document, params: Data, faults: Faults) -> dict[str, Data]:
    """Return the parameters that have a valid name and a plain value."""
    if not isinstance(params, dict):
        faults.found.append(_refusal(document, ("params",), shown(params), "a mapping of names to values"))
        return {}
    good: dict[str, Data] = {}
    for name, value in params.items():
        place = ("params", name)
        if not _NAME.fullmatch(name):
            faults.found.append(_refusal(document, place, repr(name), "a name of letters, digits and _"))
        elif value is None or isinstance(value, dict | list) or (isinstance(value, str) and "${" in value):
            faults.found.append(_refusal(document, place, shown(value), "a number or a text without ${"))
        else:
            good[name] = value
    return good


@dataclass(frozen=True, slots=True, kw_only=True)
class _Replacing:
    """Substitution of parameters in data, with a record of those used and of errors."""

    document: Document
    params: Mapping[str, Data]
    names: Sequence[str]
    faults: Faults
    used: set[str] = field(default_factory=set)
    unknown: set[Spot] = field(default_factory=set)

    def whole(self, data: Data, place: Place) -> Data:
        """Return data with parameters replaced."""
        if isinstance(data, dict):
            return {
                name: value if (*place, name) == ("params",) else self.whole(value, (*place, name))
                for name, value in data.items()
            }
        if isinstance(data, list):
            return [self.whole(item, (*place, number)) for number, item in enumerate(data)]
        return self.one(data, place) if isinstance(data, str) and "${" in data else data

    def one(self, text: str, place: Place) -> Data:
        """Return the value of the parameter that a text names."""
        match = _PARAM.fullmatch(text)
        if match is not None and match[1] in self.params:
            self.used.add(match[1])
            return self.params[match[1]]
        self.unknown.add(self.document.spot(place))
        if match is None:
            expected = "a whole value such as ${name}, nothing around it"
        elif match[1] in self.names:
            # Its own value has an error already.
            return text
        else:
            expected = f"a name under params: {', '.join(self.names) or 'none'}{nearest(match[1], self.names)}"
        self.faults.found.append(_refusal(self.document, place, shown(text), expected))
        return text


def _refusal(document: Document, place: Place, found: str, expected: str, *, key: bool = False) -> ProtocolError:
    """Return an error at a value, or at its key."""
    return ProtocolError(document.path, document.spot(place, key=key), dotted(place), found, expected)
