"""Files that a protocol names: found beside it on a disk, or sent along with its text."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol

from app.schemas.document import MAX_BYTES, read_text
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping


class NamedText(NamedTuple):
    """Text of a file that a protocol names."""

    path: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FileKind:
    """A kind of file that a protocol may name.

    Attributes
    ----------
    field : str
        Field that names it, for errors.
    suffixes : tuple of str
        How its name may end.
    form : str
        What it is, for errors.
    example : str
        A name that it may have.
    alone : str
        What is allowed in a text that no files came with.
    most : int
        Its size at most [bytes].
    """

    field: str
    suffixes: tuple[str, ...]
    form: str
    example: str
    alone: str
    most: int = MAX_BYTES

    @property
    def allowed(self) -> str:
        """Return what is allowed as its name."""
        return f"{self.form} in the protocol's folder or below it, such as {self.example}"


MATERIALS: Final = FileKind(
    field="materials",
    suffixes=(".yaml", ".yml"),
    form="a YAML file",
    example="my-resins.yaml",
    alone="materials by name: a text without a file has none beside it",
)
CENTRELINE: Final = FileKind(
    field="centreline",
    suffixes=(".csv",),
    form="a CSV file",
    example="my-knit.csv",
    alone="CSV text: a text without a file has none beside it",
)
TABLE: Final = FileKind(
    field="table",
    suffixes=(".csv",),
    form="a CSV file",
    example="my_wave.csv",
    alone="points: a text without a file has no table beside it",
    most=200_000,
)


class FilesBeside(Protocol):
    """The files that a protocol may name."""

    def read(self, name: str, kind: FileKind, /) -> NamedText:
        """Return the text of a file, by a path from the protocol's folder downwards, with forward slashes.

        Raises
        ------
        ProtocolError
            If it cannot be read, is too large or is not text.
        SpecificationError
            If no file of that kind can have the name, or there is none.
        """


@dataclass(frozen=True, slots=True)
class FolderFiles:
    """Files in the folder of a protocol's file, or below it."""

    protocol: Path

    def read(self, name: str, kind: FileKind) -> NamedText:
        """Return the text of a file."""
        path = file_beside(self.protocol, name, kind)
        return NamedText(str(path), read_text(path, kind.field, form=kind.form, most=kind.most))


@dataclass(frozen=True, slots=True)
class SentFiles:
    """Texts that came with that of a protocol; nothing on a disk is looked at.

    Attributes
    ----------
    materials : str
        The materials file, whatever name the protocol has for it; empty for none.
    texts : Mapping
        Other files by their names.
    """

    materials: str = ""
    texts: Mapping[str, str] = field(default_factory=dict)

    def read(self, name: str, kind: FileKind) -> NamedText:
        """Return the text of a file."""
        if kind is MATERIALS and self.materials:
            return NamedText(name, self.materials)
        if not self.texts:
            raise SpecificationError(kind.field, name, kind.alone)
        path = PurePosixPath(name)
        text = self.texts.get(str(path)) if path.suffix in kind.suffixes else None
        if text is None:
            ready = [one for one in self.texts if PurePosixPath(one).suffix in kind.suffixes]
            allowed = f"a file that came with the protocol: {', '.join(ready)}" if ready else kind.alone
            raise SpecificationError(kind.field, name, allowed)
        if len(text.encode()) > kind.most:
            raise SpecificationError(kind.field, f"{name} of more", f"{kind.most} bytes or fewer")
        return NamedText(str(path), text)


@dataclass(frozen=True, slots=True)
class RecordedFiles:
    """Files beside a protocol, and the texts of those that were read, by the names that the protocol has for them."""

    files: FilesBeside
    texts: dict[str, str] = field(default_factory=dict)

    def read(self, name: str, kind: FileKind) -> NamedText:
        """Return the text of a file, and keep it."""
        found = self.files.read(name, kind)
        self.texts[name] = found.text
        return found


def file_beside(protocol: Path, name: str, kind: FileKind) -> Path:
    """Return the file that a protocol means by a name.

    Parameters
    ----------
    protocol : Path
        The protocol's file.
    name : str
        A path from the protocol's folder downwards, with forward slashes.
    kind : FileKind
        What it must be.

    Raises
    ------
    SpecificationError
        For an absolute path, one that leads out of the folder, also by a link, or one with another ending.

    Examples
    --------
    >>> file_beside(Path("tests/p.yaml"), "own/resins.yaml", MATERIALS).as_posix()
    'tests/own/resins.yaml'
    """
    if not is_plain(name) or PurePosixPath(name).suffix not in kind.suffixes:
        raise SpecificationError(kind.field, name, kind.allowed)
    folder = protocol.parent
    path = folder / PurePosixPath(name)
    if not path.resolve().is_relative_to(folder.resolve()):
        raise SpecificationError(kind.field, name, kind.allowed)
    return path


def is_plain(name: str) -> bool:
    """Return whether a name leads from a folder downwards, on every system.

    Examples
    --------
    >>> [is_plain(name) for name in ("own/knit.csv", "../knit.csv", "/knit.csv", "c:knit.csv")]
    [True, False, False, False]
    """
    path = PurePosixPath(name)
    return bool(path.name) and not path.is_absolute() and ".." not in path.parts and not any(c in name for c in "\\:\0")
