"""Reader of the machines' data files."""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass, replace
from functools import cache
from types import NoneType
from typing import TYPE_CHECKING, get_args, get_origin, get_type_hints

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import MarkedYAMLError

from knitlab_core.errors import FormatError, SpecificationError
from rigs.machines.catalogue import machine_named
from rigs.machines.machine import MachineData, pinned

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable
    from pathlib import Path

    from rigs.protocol.catalogue import MachineName
    from rigs.protocol.protocol import Protocol


def machines_of(protocol: Protocol) -> dict[MachineName, MachineData]:
    """Return the numbers of every machine of a protocol's rig, with the load cell of the protocol.

    Raises
    ------
    SpecificationError
        If no machine has that load cell.
    """
    names = {drive.machine: None for drive in protocol.drives.values()}
    machines = {name: _with_extensometer(read_machine(name), protocol) for name in names}
    wanted = protocol.load_cell
    if wanted is None:
        return {name: replace(data, other_cells=()) for name, data in machines.items()}
    fitted = {name: data.fitted(wanted) for name, data in machines.items() if data.other_cells}
    if not any(fitted.values()):
        allowed = [f"{cell.limit.value:g} N" for name in fitted for cell in machines[name].cells]
        has = f"one of {', '.join(allowed)}" if allowed else f"none: {protocol.rig} has load cells of its own"
        raise SpecificationError("load_cell", f"{wanted:g} N", has)
    return {name: fitted.get(name) or replace(data, other_cells=()) for name, data in machines.items()}


def _with_extensometer(data: MachineData, protocol: Protocol) -> MachineData:
    """Return a machine without its extensometer where a protocol has it read no pins."""
    if not pinned(protocol)[data.rig]:
        return replace(data, extensometer=None)
    if data.extensometer is None:
        raise SpecificationError("extensometer", "on", f"off: {data.rig} has no extensometer")
    return data


def read_machine(machine: MachineName, path: Path | None = None) -> MachineData:
    """Read the numbers of a machine.

    Parameters
    ----------
    machine : MachineName
        The machine.
    path : Path or None
        A file in the form of ``rigs/data/biaxial_hook.yaml``; None for the machine's own.

    Returns
    -------
    MachineData
        Every number with its source.

    Raises
    ------
    FormatError
        If the file is not YAML, a field is missing or unknown, or a value is of another type.
    SpecificationError
        If no machine has the name.
    """
    return _own_numbers(machine) if path is None else _numbers_in(path, machine)


@cache
def _own_numbers(machine: MachineName) -> MachineData:
    """Read the machine's own file, cached for the service."""
    return _numbers_in(machine_named(machine).numbers, machine)


def _numbers_in(source: Traversable, machine: MachineName) -> MachineData:
    """Read the numbers of a machine in a file."""
    built = read_numbers(MachineData, source)
    if not isinstance(built, MachineData) or built.rig != machine:
        raise FormatError(source.name, 1, f"the numbers of {machine}")
    return built


def read_numbers(kind: type, source: Traversable) -> object:
    """Return the dataclass of a kind that a file fills, field by field.

    Raises
    ------
    FormatError
        If the file is not YAML, a field is missing or unknown, or a value is of another type.
    """
    try:
        tree = YAML(typ="rt").load(source.read_text(encoding="utf-8"))
    except MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise FormatError(source.name, line, f"YAML ({error.problem})") from error
    return _build(kind, tree, source.name, 1)


def _build(kind: type, found: object, name: str, line: int) -> object:
    if is_dataclass(kind):
        return _build_dataclass(kind, found, name, line)
    if get_origin(kind) is tuple and isinstance(found, CommentedSeq):
        (part, _) = get_args(kind)
        return tuple(_build(part, one, name, found.lc.item(number)[0] + 1) for number, one in enumerate(found))
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
    missing = {field.name for field in fields(kind) if field.default is MISSING} - set(found)
    if missing:
        raise FormatError(name, line, f"also {', '.join(sorted(missing))}")
    values = {key: _build(_given(hints[key]), value, name, found.lc.key(key)[0] + 1) for key, value in found.items()}
    return kind(**values)


def _given(hint: type) -> type:
    """Return the type of a field that is there: of one that may be left out, without the None."""
    if get_origin(hint) is tuple:
        return hint
    return next((part for part in get_args(hint) if part is not NoneType), hint)
