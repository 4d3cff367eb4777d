"""Read the rigs' data files; no other place parses them."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, get_type_hints

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap
from ruamel.yaml.error import MarkedYAMLError

from knitlab_core.errors import FormatError, SpecificationError
from knitlab_core.knits.stitch import is_positive
from rigs.biaxial_data import BiaxialData
from rigs.printer_data import PrinterData

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable


def read_biaxial_data(path: Path | None = None) -> BiaxialData:
    """Read the numbers of the biaxial stage.

    Parameters
    ----------
    path : Path or None
        A file in the form of ``rigs/data/biaxial_hook.yaml``; None for that file itself.

    Returns
    -------
    BiaxialData
        Every number with its source.

    Raises
    ------
    FormatError
        If the file is not YAML, a field is missing or unknown, or a value is of another type.
    """
    source: Traversable = path or files("rigs") / "data" / "biaxial_hook.yaml"
    built = _read(BiaxialData, source)
    if not isinstance(built, BiaxialData):
        raise FormatError(source.name, 1, "the numbers of a biaxial stage")
    return built


def printer_names() -> tuple[str, ...]:
    """Return the names of the printers that come with the package."""
    return tuple(sorted(_stem(entry) for entry in _printers().iterdir() if entry.name.endswith(".yaml")))


def read_printer_data(printer: str) -> PrinterData:
    """Read the numbers of a printer.

    Parameters
    ----------
    printer : str
        A name of `printer_names`, or the path of a file in the form of ``rigs/data/printers/j35.yaml``.

    Returns
    -------
    PrinterData
        Every number with its source.

    Raises
    ------
    SpecificationError
        If there is no such printer, or one of its numbers is not above 0.
    FormatError
        If the file is not YAML, a field is missing or unknown, or a value is of another type.
    """
    names = printer_names()
    if printer in names:
        source: Traversable = _printers() / f"{printer}.yaml"
    elif printer.endswith((".yaml", ".yml")) and Path(printer).is_file():
        source = Path(printer)
    else:
        raise SpecificationError("printer", printer, f"{', '.join(names)}, or the path of a .yaml file")
    built = _read(PrinterData, source)
    if not isinstance(built, PrinterData):
        raise FormatError(source.name, 1, "the numbers of a printer")
    for name in ("layer_height", "resolution", "smallest_feature", "clearance"):
        value = getattr(built, name).value
        if not is_positive(value):
            raise SpecificationError(f"{source.name}: {name}", value, "a length above 0 m")
    return built


def _printers() -> Traversable:
    return files("rigs") / "data" / "printers"


def _stem(entry: Traversable) -> str:
    return entry.name.removesuffix(".yaml")


def _read(kind: type, source: Traversable) -> object:
    """Return the dataclass a file describes."""
    try:
        tree = YAML(typ="rt").load(source.read_text(encoding="utf-8"))
    except MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise FormatError(source.name, line, f"YAML ({error.problem})") from error
    return _build(kind, tree, source.name, 1)


def _build(kind: type, found: object, name: str, line: int) -> object:
    if is_dataclass(kind):
        return _build_dataclass(kind, found, name, line)
    if kind is float and isinstance(found, int | float) and not isinstance(found, bool):
        return float(found)
    if kind in (str, bool) and isinstance(found, kind):
        return found
    raise FormatError(name, line, f"a {kind.__name__}, found {found!r}")


def _build_dataclass(kind: type, found: object, name: str, line: int) -> object:
    if not isinstance(found, CommentedMap):
        raise FormatError(name, line, f"the fields of {kind.__name__}, found {found!r}")
    hints = get_type_hints(kind)
    allowed = {field.name for field in fields(kind)}
    for key in found:
        if key not in allowed:
            where = found.lc.key(key)[0] + 1
            raise FormatError(name, where, f"one of {', '.join(sorted(allowed))}; found {key!r}")
    missing = allowed - set(found)
    if missing:
        raise FormatError(name, line, f"also {', '.join(sorted(missing))}")
    values = {key: _build(hints[key], value, name, found.lc.key(key)[0] + 1) for key, value in found.items()}
    return kind(**values)
