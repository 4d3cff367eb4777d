"""Dataclasses of numbers and arrays as HDF5 groups: written field by field, and read by their type.

A record is a dataclass or a NamedTuple; its fields are numbers, arrays, tuples of whole numbers or such records. What
is None is left out.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from types import NoneType
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_type_hints

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    import h5py

R = TypeVar("R")


def store(group: h5py.Group, record: object) -> None:
    """Write every field of a dataclass into a group."""
    for name in _names(type(record)):
        value = getattr(record, name)
        if _names(type(value)):
            store(group.create_group(name), value)
        elif value is not None:
            group[name] = value


def fetch(group: h5py.Group, kind: type[R]) -> R:
    """Read a dataclass of a given type from a group.

    Raises
    ------
    KeyError
        If the group lacks a field that the type must have.
    """
    hints: dict[str, Any] = get_type_hints(kind)
    return kind(**{name: _fetched(group, name, hints[name]) for name in _names(kind)})


def _fetched(group: h5py.Group, name: str, hint: Any) -> object:  # noqa: ANN401 (a hint may be any type form)
    choices = [choice for choice in get_args(hint) if choice is not NoneType]
    if NoneType in get_args(hint):
        if name not in group:
            return None
        hint = choices[0]
    if isinstance(hint, type) and _names(hint):
        return fetch(group[name], hint)
    value = group[name][()]
    return value if isinstance(value, np.ndarray) else value.item()


def _names(kind: type) -> Sequence[str]:
    """Return the names of a dataclass's fields; none for another object."""
    if is_dataclass(kind):
        return tuple(field.name for field in fields(kind))
    return getattr(kind, "_fields", ())
