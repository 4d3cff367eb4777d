"""A sweep as Python and notebooks see it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from app.interactive.markup import folded, head_html, table_html
from app.interactive.results import Run, frame_of
from app.runs.sweep_tables import sweep_table
from app.runs.sweeps import SweepResult, run_sweep
from app.views.drawing import draw_here
from app.views.progress_bar import bar_for
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from app.runs.publishing import Progress
    from app.schemas import Source
    from app.schemas.sweep import Scalar
    from app.views.drawing import Draw
    from app.views.plotting import Picture


@dataclass(frozen=True, kw_only=True)
class Sweep(SweepResult):
    """A sweep that has ended, with its runs, its table and its plots; in a notebook it shows itself.

    ``sweep["mu=0.3"]`` is the `Run` of a point, by its label. The attributes of `SweepResult` are its points and files.
    """

    @classmethod
    def of(cls, result: SweepResult) -> Self:
        """Return what a sweep came to, with its runs at hand."""
        return cls(**{one.name: getattr(result, one.name) for one in fields(SweepResult)})

    @cached_property
    def runs(self) -> tuple[Run, ...]:
        """The runs of the points, in order."""
        return tuple(Run.at(one.folder) for one in self.points)

    @cached_property
    def table(self) -> Any:  # noqa: ANN401 (pandas is optional, and ships no types)
        """A row for every point: values, outcome, and every figure."""
        return frame_of(sweep_table(self.points))

    def plot(self, words: str | None = None) -> Picture:
        """Return stress over strain of all points, or figures over the values.

        Parameters
        ----------
        words : str, optional
            Words of figures, such as ``"secant_peak_C"``: over one parameter as curves, over two as a map, over three
            to eight as main effects.

        Raises
        ------
        SpecificationError
            If no figure has these words, or too many do.
        """
        from app.views.plotting import Picture  # noqa: PLC0415 (matplotlib, when a plot is wanted)
        from app.views.sweep_curves import sweep_figure  # noqa: PLC0415
        from app.views.sweep_plots import figure_over  # noqa: PLC0415

        if words is not None:
            return Picture(figure_over([(one.point.values, one.figures) for one in self.points], words))
        pairs = zip(self.points, self.runs, strict=True)
        return Picture(sweep_figure([(one.point, run.record) for one, run in pairs]))

    def __getitem__(self, label: str) -> Run:
        """Return the run of a point by its label."""
        for one, run in zip(self.points, self.runs, strict=True):
            if one.point.label == label:
                return run
        raise SpecificationError("sweep", label, f"one of {', '.join(one.point.label for one in self.points)}")

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def __repr__(self) -> str:
        """Return how many points it has, how they ended, and its folder."""
        ends = ", ".join(sorted({one.outcome for one in self.points}))
        return f"Sweep(points={len(self)}, outcomes={ends!r}, folder={str(self.folder)!r})"

    def _repr_html_(self) -> str:
        """Return plot and table, for a notebook."""
        new = sum(not one.skipped for one in self.points)
        head = head_html(self.folder.name, f"{len(self)} points, {new} of them run now")
        plot = self.plot().html() if any(len(run.record.trace) > 1 for run in self.runs) else ""
        return f"{head}{plot}{folded('Table', table_html(sweep_table(self.points)))}"


def sweep(
    source: Source | Sequence[Source],
    out: Path | str | None = None,
    progress: Progress | None = None,
    *,
    values: Mapping[str, Sequence[Scalar]] | None = None,
    jobs: int = 1,
    figures: Sequence[str] = (),
    draw: Draw | None = draw_here,
) -> Sweep:
    """Run all points of a sweep, each into a folder of its own; those that were done before are not run again.

    Parameters
    ----------
    source : Path, str, Mapping, Protocol, Loaded, or a list of them
        A protocol with `sweep` or `sample`: its file, its text, or data; or protocols of any kind in a list.
    out : Path, str or None
        Folder of the sweep; None for one under ``runs/``.
    progress : callable, optional
        Told the share done [1] and what is being done; by default a bar, in a terminal or a notebook.
    values : Mapping, optional
        Values of the protocol's parameters in the place of its own `sweep`; every combination is a point.
    jobs : int
        Processes that run at once.
    figures : sequence of str
        Words of figures to plot into files.
    draw : callable or None
        Begins to draw plot and knit of a point; None for no pictures.

    Returns
    -------
    Sweep
        Every point, those done before too; after an interrupt those that were begun.

    Raises
    ------
    ProtocolError
        For whatever is wrong with the protocol, in one line.
    SpecificationError
        If a point's folder holds another test.
    """
    with bar_for(wanted=progress is None) as bar:
        told = progress or bar.show
        return Sweep.of(run_sweep(source, out, told, jobs=jobs, figures=figures, values=values, draw=draw))
