"""A run as Python and notebooks see it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from app.interactive.markup import folded, head_html, rows_html
from app.records.analysis import analyse_run
from app.records.export import export_run
from app.records.export_shapes import export_shapes
from app.records.reader import RunReader, read_run
from app.records.results import figures_of
from app.runs.publishing import RunResult, result_of

if TYPE_CHECKING:
    from pathlib import Path

    from app.interactive.scene import Scene
    from app.views.plotting import Picture
    from rigs.analysis.table import Table


@dataclass(frozen=True, kw_only=True)
class Run(RunResult):
    """A run that has ended, with its tables, plots and pictures; in a notebook it shows itself.

    Tables are pandas' where that is installed (``pip install 'knitlab[tables]'``), else mappings of headings, with
    units, to NumPy arrays.
    """

    @classmethod
    def of(cls, result: RunResult) -> Self:
        """Return what a run came to, with its record at hand."""
        return cls(**{one.name: getattr(result, one.name) for one in fields(RunResult)})

    @classmethod
    def at(cls, folder: Path | str) -> Self:
        """Return a run that was done before, by its folder.

        Raises
        ------
        FileNotFoundError, FormatError
            If there is no run, or it is damaged.
        """
        record = read_run(folder)
        return cls.of(result_of(record.outcome, figures_of(record), record))

    @cached_property
    def record(self) -> RunReader:
        """The record of the run, ``run.h5``: equilibria, samples of the instruments, shapes."""
        return read_run(self.folder)

    @cached_property
    def table(self) -> Any:  # noqa: ANN401 (pandas is optional, and ships no types)
        """Every equilibrium along every driven axis: time, travel, force, strain, stress."""
        return frame_of(analyse_run(self.record, "curves"))

    @cached_property
    def cycles(self) -> Any:  # noqa: ANN401 (as above)
        """Figures of every cycle: maximum force, moduli, hysteresis."""
        return frame_of(analyse_run(self.record, "results"))

    def analyse(self, table: str) -> Any:  # noqa: ANN401 (as above)
        """Return any table of `knitlab analyse`, such as ``"energy"`` or ``"contacts"``."""
        return frame_of(analyse_run(self.record, table))

    def plot(self) -> Picture:
        """Return stress over strain, and force and strain over time."""
        from app.views.plots import stress_strain_figure  # noqa: PLC0415 (matplotlib, when a plot is wanted)
        from app.views.plotting import Picture  # noqa: PLC0415

        return Picture(stress_strain_figure(self.record))

    def knit(self, at: float | None = None) -> Scene:
        """Return the knit as a picture that can be turned, coloured by the strain of its yarn.

        Parameters
        ----------
        at : float, optional
            Strain of the specimen [1]; the stored shape nearest to it on the way up is shown. By default the largest.

        Raises
        ------
        SpecificationError
            If plotly is not installed, or no shape is stored.
        """
        from app.interactive.scene import scene_of  # noqa: PLC0415 (when a picture is wanted)

        return scene_of(self.record, at)

    def to_csv(
        self, dialect: str | None = None, *, locale: str = "en", units: str | None = None, out: Path | None = None
    ) -> tuple[Path, ...]:
        """Write the log as an instrument would, in its own or a chosen dialect; return the files."""
        return export_run(self.folder, dialect=dialect, locale=locale, units=units, out=out)

    def to_vtkhdf(self, out: Path | None = None, *, link: bool = False) -> Path:
        """Write the shapes as ``NAME.vtkhdf``, which `pyvista.read` and ParaView open by its name; return the file.

        A copy of the record, or with `link` another name of the same file. `out` is another folder than the run's.
        """
        return export_shapes(self.folder, "link" if link else "copy", out)

    def __repr__(self) -> str:
        """Return outcome, folder and number of equilibria."""
        return f"Run(outcome={self.outcome!r}, folder={str(self.folder)!r}, equilibria={len(self.record.trace)})"

    def _repr_html_(self) -> str:
        """Return the outcome, the figures and the plot, for a notebook."""
        said = f"{self.outcome}{': ' + self.message if self.message else ''}"
        head = head_html(self.folder.name, f"{len(self.record.trace)} equilibria; ended by {said}")
        plot = self.plot().html() if len(self.record.trace) > 1 else ""
        return f"{head}{plot}{folded('Figures', rows_html(self.figures))}"


def frame_of(table: Table) -> Any:  # noqa: ANN401 (as above)
    """Return a table as pandas' ``DataFrame``; without pandas as a mapping of headings to arrays."""
    if find_spec("pandas") is not None:
        return table.dataframe()
    return {name: np.asarray(column) for name, column in zip(table.headings(), table.columns.values(), strict=True)}


def place_of(source: Path | str | RunResult | RunReader) -> Path | str:
    """Return where a test is: a run by its folder or record, a file as it is named."""
    if isinstance(source, RunResult):
        return source.folder
    return source.path if isinstance(source, RunReader) else source
