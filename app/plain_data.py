"""Plain data, as JSON holds it, to dataclasses."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from collections.abc import Mapping

_DataT = TypeVar("_DataT")


def from_data(kind: type[_DataT], data: Mapping[str, Any], **given: object) -> _DataT:
    """Return a dataclass with the fields that data has; those of a newer version are ignored.

    Parameters
    ----------
    kind : type
        The dataclass.
    data : Mapping
        Its fields by name.
    **given : object
        Fields that come from elsewhere, in the place of the data's own.
    """
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type] # a TypeVar cannot be bound to dataclasses
    return kind(**{name: data[name] for name in names if name in data} | given)
