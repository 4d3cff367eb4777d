"""Table of figures: columns of one length, each with its unit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

Cell: TypeAlias = "str | int | float"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """Tidy table: one row an observation, one column a quantity, SI units.

    Attributes
    ----------
    name : str
        What it is called.
    columns : Mapping
        Values of each column, (n,): texts, whole numbers or numbers, ``nan`` where there is none.
    units : Mapping
        Unit of columns of numbers that have one.
    """

    name: str
    columns: Mapping[str, Sequence[Cell]]
    units: Mapping[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(next(iter(self.columns.values()), ()))

    def headings(self) -> list[str]:
        """Return the columns' names with their units, ``strain [1]``."""
        return [f"{name} [{self.units[name]}]" if name in self.units else name for name in self.columns]

    def rows(self) -> Iterator[tuple[Cell, ...]]:
        """Yield the rows."""
        return zip(*self.columns.values(), strict=True)

    def dataframe(self) -> Any:  # noqa: ANN401 (pandas is optional, and ships no types)
        """Return the table as a pandas ``DataFrame`` under the names of `headings`.

        Raises
        ------
        SpecificationError
            If pandas is not installed.
        """
        try:
            import pandas as pd  # noqa: PLC0415 (optional)
        except ImportError as error:
            raise SpecificationError("pandas", "not installed", "pip install 'knitlab[tables]'") from error
        return pd.DataFrame(dict(zip(self.headings(), self.columns.values(), strict=True)))


def table_of(name: str, rows: Iterable[Mapping[str, Cell]], units: Mapping[str, str], *texts: str) -> Table:
    """Return a table of rows that all have the same names.

    Parameters
    ----------
    name : str
        Name of the table.
    rows : iterable of mapping of str to value
        The rows.
    units : mapping of str to str
        Unit of columns of numbers.
    *texts : str
        Columns of texts or whole numbers that come first; named so that a table without rows has its columns too.
    """
    every = list(rows)
    names = list(every[0]) if every else [*texts, *units]
    columns: dict[str, Sequence[Cell]] = {}
    for column in names:
        values = [row[column] for row in every]
        columns[column] = np.array(values, dtype=np.float64).tolist() if column in units else values
    return Table(name=name, columns=columns, units=dict(units))
