"""YAML as plain data, with the line and column of each value.

Only what a protocol needs: mappings, lists, text, numbers, true, false and null. No tags, one document,
bounded size, depth and number of values (aliases counted each time they are used).
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)

from app.schemas.errors import ProtocolError, Spot
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from ruamel.yaml.events import Event

Data: TypeAlias = "dict[str, Data] | list[Data] | str | int | float | bool | None"
Place: TypeAlias = "tuple[str | int, ...]"

MAX_BYTES: Final = 1_000_000
MAX_DEPTH: Final = 24
MAX_VALUES: Final = 20_000

LABELS: Final = frozenset({"name", "tag", "material", "source", "note"})
"""Keys whose values are texts even where they look like numbers: `name: 007` is the name 007."""

_INTEGER: Final = re.compile(r"[-+]?\d{1,20}")
_FLOAT: Final = re.compile(r"[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?")
_NOTHING: Final = {"", "~", "null", "Null", "NULL"}
_TRUTH: Final = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}


@dataclass(frozen=True, slots=True, kw_only=True)
class Document:
    """Data of a YAML text, with the line and column of its keys and values."""

    path: str
    text: str
    data: Data
    keys: Mapping[Place, Spot]
    values: Mapping[Place, Spot]

    def spot(self, place: Place, *, key: bool = False) -> Spot:
        """Return line and column of a value (or its key); of a missing one, those of its nearest parent."""
        if key and place in self.keys:
            return self.keys[place]
        while place and place not in self.values:
            place = place[:-1]
        return self.values.get(place, Spot(line=1, column=1))


def read_text(path: Path, kind: str = "protocol", *, form: str = "a YAML file", most: int = MAX_BYTES) -> str:
    """Return the text of a file of `most` bytes; `kind` and `form` name in errors what it should hold.

    Raises
    ------
    ProtocolError
        If it cannot be opened, is too large or is not UTF-8.
    """
    top = Spot(line=1, column=1)
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise ProtocolError(str(path), top, kind, reason, f"{form} that can be read") from error
    if len(content) > most:
        raise ProtocolError(str(path), top, kind, "more", f"{most} bytes or fewer")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8-sig")
        line = before.count("\n") + 1
        spot = Spot(line=line, column=len(before) - (before.rfind("\n") + 1) + 1)
        raise ProtocolError(str(path), spot, kind, f"byte 0x{content[error.start]:02x}", "text in UTF-8") from error


def parse_text(text: str, path: str, kind: str = "protocol") -> Document:
    """Return the one document of a YAML text; `kind` names in errors what it should hold.

    Raises
    ------
    ProtocolError
        For anything that is not YAML, or beyond the bounds of this module.
    """
    try:
        return _Reader(text, path, kind).document()
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        spot = Spot(line=1, column=1) if mark is None else Spot.at(mark)
        found = f"text that is not YAML ({error.problem})"
        raise ProtocolError(path, spot, kind, found, "YAML") from error
    except (YAMLError, ValueError) as error:
        # The message about a forbidden character has several lines; the first one is enough.
        found = f"text that is not YAML ({str(error).partition(chr(10))[0]})"
        raise ProtocolError(path, Spot(line=1, column=1), kind, found, "YAML") from error


def text_of(data: Mapping[str, Any], *, compact: bool = False) -> str:
    """Return data as the text of a YAML file; the numbers of NumPy are numbers, and tuples are lists.

    A compact one has what holds no other list or mapping on one line, as people write it.

    Raises
    ------
    SpecificationError
        If something in it has no place in a YAML file.
    """
    text = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None if compact else False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]  # a flag that ships as None
    yaml.dump(_plain(data, ()), text)
    return text.getvalue()


def _plain(data: Any, place: Place) -> Any:  # noqa: ANN401 (whatever a user gives)
    """Return data in Python's own types."""
    if hasattr(data, "tolist"):
        data = data.tolist()
    match data:
        case None | bool() | int() | float() | str():
            return data
        case Mapping():
            return {str(key): _plain(value, (*place, str(key))) for key, value in data.items()}
        case list() | tuple():
            return [_plain(value, (*place, number)) for number, value in enumerate(data)]
    raise SpecificationError(
        dotted(place) or "protocol", f"something of type {type(data).__name__}", "texts, numbers, lists and mappings"
    )


class _Reader:
    """Builder of data from the events of ruamel's parser, one document at a time."""

    def __init__(self, text: str, path: str, kind: str) -> None:
        self.text, self.path, self.kind = text, path, kind
        self.keys: dict[Place, Spot] = {}
        self.values: dict[Place, Spot] = {}
        self.anchors: dict[str, tuple[Data, int]] = {}
        self.count = 0
        self.events: Iterator[Event] = iter(YAML(typ="safe", pure=True).parse(text))

    def document(self) -> Document:
        """Return the document the text holds."""
        data: Data = None
        documents = 0
        for event in self.events:
            if isinstance(event, DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise self.refuse(event, (), "a second document", "one document in the file")
                data = self.value(next(self.events), ())
            elif isinstance(event, StreamEndEvent):
                break
        return Document(path=self.path, text=self.text, data=data, keys=self.keys, values=self.values)

    def refuse(self, event: Event, place: Place, found: str, expected: str) -> ProtocolError:
        """Return an error at a parser event."""
        return ProtocolError(self.path, Spot.at(event.start_mark), dotted(place) or self.kind, found, expected)

    def value(self, event: Any, place: Place) -> Data:  # noqa: ANN401 (events share no typed attributes)
        """Return the value an event begins, and note its spot."""
        self.values[place] = Spot.at(event.start_mark)
        if isinstance(event, ScalarEvent) and not event.value and place in self.keys:
            # The parser gives a missing value the place of the next token.
            self.values[place] = self.keys[place]
        if len(place) > MAX_DEPTH:
            raise self.refuse(event, place[:1], "deeper nesting", f"{MAX_DEPTH} levels or fewer")
        before = self.count
        self.add(1, event, place)
        if isinstance(event, AliasEvent):
            if event.anchor not in self.anchors:
                raise self.refuse(event, place, f"*{event.anchor}", "an alias to an anchor that is complete")
            data, size = self.anchors[event.anchor]
            self.add(size, event, place)
            return data
        if event.ctag is not None:
            raise self.refuse(event, place, f"tag {event.tag}", "plain values without tags")
        data = self.content(event, place)
        if event.anchor is not None:
            self.anchors[event.anchor] = (data, self.count - before)
        return data

    def add(self, size: int, event: Event, place: Place) -> None:
        """Count values; refuse a file that expands to too many."""
        self.count += size
        if self.count > MAX_VALUES:
            raise self.refuse(event, place[:1], "more", f"{MAX_VALUES} values or fewer, aliases counted out")

    def content(self, event: Any, place: Place) -> Data:  # noqa: ANN401 (as above)
        """Return the data of a mapping, a list or a scalar."""
        if isinstance(event, MappingStartEvent):
            return self.mapping(place)
        if isinstance(event, SequenceStartEvent):
            items: list[Data] = []
            while not isinstance(item := next(self.events), SequenceEndEvent):
                items.append(self.value(item, (*place, len(items))))
            return items
        if not event.implicit[0] or (_is_label(place) and event.value not in _NOTHING):
            return str(event.value)
        return scalar(event.value)

    def mapping(self, place: Place) -> dict[str, Data]:
        """Return a mapping; its keys are text, each once."""
        data: dict[str, Data] = {}
        while not isinstance(event := next(self.events), MappingEndEvent):
            if not isinstance(event, ScalarEvent) or event.ctag is not None or event.anchor is not None:
                raise self.refuse(event, place, "a key that is not plain text", "plain text")
            name = str(event.value)
            inner = (*place, name)
            if name in data:
                raise self.refuse(event, inner, "the same key again", "each key once")
            self.keys[inner] = Spot.at(event.start_mark)
            data[name] = self.value(next(self.events), inner)
        return data


def scalar(text: str) -> Data:
    """Return the value of a plain scalar, by YAML 1.2's core rules.

    Examples
    --------
    >>> scalar("8 mm"), scalar("6"), scalar("0.4"), scalar("off"), scalar("~")
    ('8 mm', 6, 0.4, 'off', None)
    """
    if text in _NOTHING:
        return None
    if text in _TRUTH:
        return _TRUTH[text]
    if _INTEGER.fullmatch(text):
        return int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    return text


def _is_label(place: Place) -> bool:
    """Return whether the value at a place is always a text, even if it looks like a number, such as a name."""
    return bool(place) and place[-1] in LABELS and place[0] not in {"params", "sample", "sweep"}


def dotted(place: Place) -> str:
    """Return a place as errors write it.

    Examples
    --------
    >>> dotted(("steps", 3, "ramp", "rate"))
    'steps[3].ramp.rate'
    """
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    return text.removeprefix(".")
