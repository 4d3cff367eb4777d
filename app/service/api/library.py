"""The examples that are shipped: protocols, each with the files that it names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.schemas.document import parse_text
from app.schemas.errors import nearest
from app.schemas.loading import texts_of
from app.schemas.models import SCHEMA
from app.service.api.problems import ProblemError

if TYPE_CHECKING:
    from collections.abc import Mapping

_PACKAGE: Final = Path(__file__).parents[2]
#: A wheel has them inside the package (`setup.py`); in the sources they are beside it.
_FOLDERS: Final = (_PACKAGE / "examples", _PACKAGE.parent / "examples")
#: By this file a folder is known to be that of the examples.
_ONE: Final = "biaxial_small.yaml"


@dataclass(frozen=True, slots=True, kw_only=True)
class Example:
    """An example.

    Attributes
    ----------
    path : str
        Its path among the examples, without its ending.
    group : str
        The folder that it is in; empty for none.
    title : str
        Its name, or that of its file, in words.
    purpose : str
        The first sentence of the comment that it begins with.
    rig : str
        The rig that it is for.
    """

    path: str
    group: str
    title: str
    purpose: str
    rig: str


def examples_folder() -> Path | None:
    """Return the folder of the examples; None where none were installed."""
    return next((folder for folder in _FOLDERS if (folder / _ONE).is_file()), None)


@cache
def examples() -> Mapping[str, Example]:
    """Return the examples by their paths: those of no folder first, each folder in alphabetical order."""
    folder = examples_folder()
    files = [] if folder is None else sorted(folder.rglob("*.yaml"), key=lambda path: (len(path.parts), str(path)))
    found = (_example(path.relative_to(folder).with_suffix("").as_posix(), path) for path in files if folder)
    return {one.path: one for one in found if one is not None}


def texts_of_example(path: str) -> tuple[str, str, dict[str, str]]:
    """Return the texts of an example, of its materials file (empty for none), and of its other files by name.

    Raises
    ------
    ProblemError
        If there is none of that path.
    """
    folder = examples_folder()
    if folder is None or path not in examples():
        raise ProblemError("unknown", f"example: found none of this path{nearest(path, examples())}")
    text, beside = texts_of(folder / f"{path}.yaml")
    files = {name: one for name, one in beside.items() if name.endswith(".csv")}
    return text, next((one for name, one in beside.items() if name not in files), ""), files


def _example(path: str, file: Path) -> Example | None:
    """Return the example of a file; None if the file is no protocol."""
    text = file.read_text(encoding="utf-8")
    data = parse_text(text, path).data
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        return None
    group, _, stem = path.rpartition("/")
    return Example(
        path=path,
        group=group,
        title=str(data.get("name", stem)).replace("_", " "),
        purpose=_purpose(text),
        rig=str(data.get("rig")),
    )


def _purpose(text: str) -> str:
    r"""Return the first sentence of the comment that a text begins with.

    Examples
    --------
    >>> _purpose("# A quick look: no noise.\n# More of\n# it. And\nschema: a")
    'A quick look: no noise.'
    """
    words: list[str] = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        for word in line.removeprefix("#").split():
            words.append(word)
            if word.endswith(".") and word not in {"Fig.", "al.,", "al.", "e.g."}:
                return " ".join(words)
    return " ".join(words)
