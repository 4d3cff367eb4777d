"""Tables of figures of a run or a measured file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from app.extensions import load_extensions
from app.records.measurements import cycled, measurements_of, zeroings_of
from app.records.reader import read_run
from app.schemas.measured import load_mapping, mapping_beside
from knitlab_core.errors import SpecificationError
from rigs.analysis.choices import Choices
from rigs.analysis.curve_tables import curves_table, fits_table, holds_table, poisson_table, repeatability_table
from rigs.analysis.figures import results_table
from rigs.analysis.run_tables import bonds_table, contacts_table, energy_table, hooks_table, shapes_table
from rigs.axes import SITES
from rigs.protocol.made_specimen import make_specimen
from rigs.readers.measured import read_measured

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from app.records.reader import RunReader
    from rigs.analysis.table import Table
    from rigs.axes import Axis
    from rigs.measurement import Measurement
    from rigs.readers.mapping import FileMapping

DEFAULT: Final = Choices()

OF_CURVES: Final[Mapping[str, Callable[[Sequence[Measurement], Sequence[Measurement], Choices], Table]]] = {
    "results": results_table,
    "curves": lambda whole, _, __: curves_table(whole),
    "fits": lambda _, parts, choices: fits_table(parts, choices),
    "repeatability": lambda _, parts, __: repeatability_table(parts),
    "holds": lambda whole, _, __: holds_table(whole),
    "poisson": lambda whole, _, __: poisson_table(whole),
}
"""Tables that every test along an axis has, by name."""

OF_RUNS: Final[Mapping[str, Callable[[RunReader], Table]]] = {
    "energy": lambda run: energy_table(run.trace, run.size),
    "contacts": lambda run: contacts_table(run.trace, run.size),
    "hooks": lambda run: hooks_table(run.trace, run.size, hooks_of(run)),
    "bonds": lambda run: bonds_table(run.trace, run.size),
    "shapes": lambda run: shapes_table(run.frames(), run.strands),
}
"""Tables that a run has besides, by name."""


def analyse_run(run: RunReader, table: str = "results", choices: Choices = DEFAULT) -> Table:
    """Return a table of the figures of a run, from its equilibria.

    Parameters
    ----------
    run : RunReader
        The run.
    table : str
        One of `OF_CURVES` or `OF_RUNS`.
    choices : Choices
        Windows of moduli and fits.

    Raises
    ------
    SpecificationError
        If there is no such table, or the run has fewer than two rows.
    """
    if table not in OF_CURVES and table not in OF_RUNS:
        raise SpecificationError("--table", table, f"one of {', '.join((*OF_CURVES, *OF_RUNS))}")
    if len(run.trace) < 2:
        raise SpecificationError("run.equilibria", len(run.trace), "two rows or more to analyse")
    if table in OF_RUNS:
        return OF_RUNS[table](run)
    whole = measurements_of(run)
    name = whole[0].name
    parts = cycled(run.trace, run.size, zeroings_of(run), run.test)
    return OF_CURVES[table](whole, [_named(part, name) for part in parts], choices)


def analyse_file(tests: Sequence[Measurement], table: str = "results", choices: Choices = DEFAULT) -> Table:
    """Return a table of the figures of a measured file, along its axes and repeat by repeat.

    Raises
    ------
    SpecificationError
        If there is no such table of a measured file.
    """
    if table not in OF_CURVES:
        expected = f"one of {', '.join(OF_CURVES)}; others are of runs alone"
        raise SpecificationError("--table", table, expected)
    return OF_CURVES[table](tests, tests, choices)


def analyse(
    place: Path | str, table: str = "results", *, mapping: Path | FileMapping | None = None, choices: Choices = DEFAULT
) -> Table:
    """Return a table of the figures of a run or of a measured file.

    Parameters
    ----------
    place : Path or str
        Run folder or its ``run.h5``, or a file of an instrument.
    table : str
        One of `OF_CURVES`, or of `OF_RUNS` for runs.
    mapping : Path, FileMapping or None
        What a measured file does not say itself; a path of a YAML file.
    choices : Choices
        Windows of moduli and fits.

    Raises
    ------
    FileNotFoundError, FormatError
        If there is no run or measured file.
    SpecificationError
        If there is no such table, or nothing to analyse.
    """
    path = Path(place)
    if is_run(path):
        return analyse_run(read_run(path), table, choices)
    return analyse_file(read_file(path, mapping), table, choices)


def is_run(path: Path) -> bool:
    """Return whether a path is that of a run: a folder, or a file of HDF5."""
    return path.is_dir() or path.suffix in {".h5", ".vtkhdf"}


def read_file(path: Path | str, mapping: Path | FileMapping | None = None) -> list[Measurement]:
    """Read a measured file, with what it does not say from a mapping; see `rigs.readers.measured.read_measured`.

    A mapping of the file's name beside it, ``fabric.yaml`` of ``fabric.csv``, is used by itself; what another says goes
    before what that says.
    """
    load_extensions()
    known = load_mapping(mapping) if isinstance(mapping, Path) else mapping
    beside = mapping_beside(Path(path))
    return read_measured(Path(path), beside if known is None else known.over(beside))


def hooks_of(run: RunReader) -> dict[Axis, int]:
    """Return the hooks on a side of each axis of a run."""
    sites = make_specimen(run.test.specimen).sites
    # Each hook holds the fibres of a bundle one by one.
    return {axis: len(sites[far]) // len(run.strands) for axis, (_, far) in SITES.items() if far in sites}


def _named(part: Measurement, name: str) -> Measurement:
    return replace(part, name=f"{name}, {part.name}" if part.name else name)
