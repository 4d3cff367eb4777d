"""Request bodies: a protocol as YAML or JSON, alone or in an envelope with its name, materials and files."""

from __future__ import annotations

import asyncio
import json
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, NoReturn

from app.schemas import loads
from app.schemas.document import MAX_DEPTH, text_of
from app.schemas.errors import shown
from app.schemas.files_beside import is_plain
from app.service.api.documents import MOST_FILES
from app.service.api.problems import ProblemError, beyond, refused
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from fastapi import Request

    from app.schemas import Loaded

PATH: Final = "protocol"
"""Name in place of the file that a protocol came from."""

PATIENCE: Final = 30.0
"""Time a body may take to arrive [s]."""

LONGEST_NAME: Final = 200
"""Length of the name of such a file [characters]."""

_KINDS: Final[dict[str, Literal["json", "yaml"]]] = {
    "application/json": "json",
    "application/yaml": "yaml",
    "application/x-yaml": "yaml",
    "text/yaml": "yaml",
}
_ENVELOPE: Final = {"protocol", "name", "materials", "files"}


class Raw(NamedTuple):
    """A body as received: its text, and its language."""

    text: str
    kind: Literal["json", "yaml"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Submission:
    """A protocol as it was sent.

    Attributes
    ----------
    text : str
        The protocol's YAML; JSON is YAML too.
    name : str
        Name of a protocol that gives itself none.
    materials : str
        The YAML of the file that it names under `materials`; empty for none.
    files : Mapping
        Texts of the centreline and the tables that it names, by their names.
    lined : bool
        Whether lines and columns of the text are the user's own.
    """

    text: str
    name: str = "test"
    materials: str = ""
    files: Mapping[str, str] = field(default_factory=dict)
    lined: bool = True

    @property
    def size(self) -> int:
        """Return the length of its texts [characters]."""
        return len(self.text) + len(self.materials) + sum(map(len, self.files.values()))

    def load(self) -> Loaded:
        """Return the protocol.

        Raises
        ------
        ProblemError
            For whatever is wrong with it.
        """
        try:
            return loads(self.text, PATH, name=self.name, materials=self.materials, files=self.files)
        except SpecificationError as error:
            raise refused(error, lined=self.lined, path=PATH) from error


async def read_raw(request: Request, bound: int) -> Raw:
    """Return the body of a request, up to its bound [bytes].

    Raises
    ------
    ProblemError
        If it is too large, too slow, not text, or neither JSON nor YAML.
    """
    said = require_kind(request, _KINDS)
    content = await read_bytes(request, bound)
    try:
        return Raw(content.decode("utf-8-sig"), _KINDS[said])
    except UnicodeDecodeError as error:
        raise ProblemError("malformed", f"found byte 0x{content[error.start]:02x}, allowed text in UTF-8") from error


def require_kind(request: Request, kinds: Collection[str]) -> str:
    """Return the media type of a body; refuse one that is not among some kinds.

    Raises
    ------
    ProblemError
        Naming the kinds.
    """
    said = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if said not in kinds:
        raise ProblemError("media-type", f"content-type: found {said or 'nothing'}, allowed {', '.join(kinds)}")
    return said


async def read_bytes(request: Request, bound: int) -> bytes:
    """Return the body of a request, up to its bound [bytes].

    Raises
    ------
    ProblemError
        If it is too large or too slow.
    """
    length = request.headers.get("content-length", "")
    if length.isascii() and length.isdigit() and int(length[:20]) > bound:
        raise beyond("bytes", length[:20], bound, kind="too-large")
    content = bytearray()
    try:
        async with asyncio.timeout(PATIENCE):
            async for chunk in request.stream():
                if len(content) + len(chunk) > bound:
                    raise beyond("bytes", "more", bound, kind="too-large")
                content += chunk
    except TimeoutError as error:
        raise ProblemError("too-slow", f"allowed {PATIENCE:g} s for the whole body") from error
    return bytes(content)


def parse_json(text: str) -> Any:  # noqa: ANN401 (whatever JSON holds)
    """Return the data of a JSON text: unique keys, finite numbers, valid characters, bounded depth.

    Raises
    ------
    ProblemError
        For anything else.
    """
    try:
        data = json.loads(text, object_pairs_hook=_each_once, parse_constant=_no_constant)
        _check_depth(data, 0)
        json.dumps(data, ensure_ascii=False, allow_nan=False).encode()
    except RecursionError as error:
        raise _too_deep() from error
    except UnicodeEncodeError as error:
        raise ProblemError("malformed", "found half a character, allowed whole ones") from error
    except ValueError as error:
        raise ProblemError("malformed", f"found text that is not JSON ({error}), allowed JSON") from error
    return data


def submission(raw: Raw, name: str) -> Submission:
    """Return the protocol in a body.

    JSON holds the protocol itself, or `{protocol, name, materials, files}` with the protocol and the files that it
    names as texts, or the protocol as an object.

    Raises
    ------
    ProblemError
        If it is not JSON, or neither of both forms.
    """
    if raw.kind == "yaml":
        return Submission(text=raw.text, name=name)
    return submitted(parse_json(raw.text), name)


def submitted(data: Any, name: str) -> Submission:  # noqa: ANN401 (whatever JSON holds)
    """Return the protocol in JSON data, alone or in an envelope."""
    if not (isinstance(data, dict) and "protocol" in data):
        return Submission(text=written(data), name=name, lined=False)
    for key, value in data.items():
        if key not in _ENVELOPE:
            raise _wrong(key, "an unknown field", ", ".join(sorted(_ENVELOPE)))
        if not isinstance(value, dict if key == "files" else str) and not (
            key == "protocol" and isinstance(value, dict)
        ):
            raise _wrong(key, "a value of another kind", "texts by name" if key == "files" else "a text")
    protocol = data["protocol"]
    lined = isinstance(protocol, str)
    return Submission(
        text=protocol if lined else written(protocol),
        name=data.get("name", name),
        materials=data.get("materials", ""),
        files=_files(data.get("files", {})),
        lined=lined,
    )


def written(data: object) -> str:
    """Return data as text that both JSON and YAML read the same way."""
    return json.dumps(data, ensure_ascii=False, indent=1) + "\n"


def _files(sent: Mapping[str, Any]) -> dict[str, str]:
    """Return the files of an envelope; their names are looked up in it alone, never on a disk."""
    if len(sent) > MOST_FILES:
        raise beyond("files", len(sent), MOST_FILES, pointer="/files")
    texts: dict[str, str] = {}
    for name, text in sent.items():
        path = PurePosixPath(name)
        if not is_plain(name) or not name.isprintable() or len(name) > LONGEST_NAME or path.suffix != ".csv":
            allowed = f"a name such as my-knit.csv, of {LONGEST_NAME} characters at most; materials go under materials"
            raise _wrong("files", shown(name[:LONGEST_NAME]), allowed)
        if not isinstance(text, str) or str(path) in texts:
            again = "the same file twice" if isinstance(text, str) else "a value of another kind"
            raise _wrong("files", f"{again}, {shown(name)}", "a text")
        texts[str(path)] = text
    return texts


def field_of_file(path: str) -> str:
    """Return the pointer to the field of an envelope that holds a file which the protocol names."""
    name = path.replace("~", "~0").replace("/", "~1")
    return f"/files/{name}" if path.endswith(".csv") else "/materials"


def as_yaml(text: str) -> str:
    """Return a protocol's text as people write it: JSON as YAML, any other text as it is."""
    if not text.lstrip().startswith("{"):
        return text
    try:
        return text_of(parse_json(text), compact=True)
    except (ProblemError, SpecificationError):
        # YAML too may begin with a brace.
        return text


def _wrong(key: str, found: str, allowed: str) -> ProblemError:
    """Return the error of one field of an envelope."""
    detail = f"{key}: found {found}, allowed {allowed}"
    pointer = "/" + key.replace("~", "~0").replace("/", "~1")
    return ProblemError("invalid-request", detail, errors=[{"detail": detail, "pointer": pointer}])


def _each_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Return a mapping of pairs; refuse a key that occurs twice."""
    data = dict(pairs)
    if len(data) < len(pairs):
        raise ValueError("the same key twice")
    return data


def _no_constant(name: str) -> NoReturn:
    """Refuse NaN and infinities, which are not JSON."""
    raise ValueError(name)


def _check_depth(data: object, depth: int) -> None:
    """Refuse data that is nested too deeply."""
    if depth > MAX_DEPTH:
        raise _too_deep()
    if isinstance(data, dict | list):
        for inner in data.values() if isinstance(data, dict) else data:
            _check_depth(inner, depth + 1)


def _too_deep() -> ProblemError:
    """Return the error of data that is nested too deeply."""
    return beyond("levels of nesting", "more", MAX_DEPTH)
