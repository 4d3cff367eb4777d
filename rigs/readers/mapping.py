"""What a measured file does not say by itself, given once beside it."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from math import nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigs.readers.headings import Heading


@dataclass(frozen=True, slots=True, kw_only=True)
class FileMapping:
    """What a file holds, and of which specimen.

    Attributes
    ----------
    headings : Mapping
        Meaning of columns, by their heading or number.
    delimiter, decimal : str or None
        What stands between fields and before decimals; None to tell it from the file.
    axis : str
        Axis of columns that name none.
    gauge_length : float
        Distance of the hooks at no strain [m]; ``nan`` for the file's own: its gauge length, or the first distance.
    width, thickness : float
        Width of the specimen and its thickness [m]: force over both is stress. The thickness is 1 mm by convention.
    """

    headings: Mapping[str, Heading] = field(default_factory=dict)
    delimiter: str | None = None
    decimal: str | None = None
    axis: str = ""
    gauge_length: float = nan
    width: float = nan
    thickness: float = 1e-3

    def over(self, other: FileMapping) -> FileMapping:
        """Return another mapping with what this one says in place of what that says."""
        plain = FileMapping()
        # nan is not equal to itself, so that texts are compared.
        said = {one.name: getattr(self, one.name) for one in fields(self)}
        return replace(
            other, **{name: value for name, value in said.items() if str(value) != str(getattr(plain, name))}
        )
