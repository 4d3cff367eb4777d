"""A comparison of tests as Python and notebooks see it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from app.interactive.markup import folded, head_html, table_html
from app.interactive.results import frame_of, place_of
from app.interactive.sweeps import Sweep
from app.records.reader import RunReader
from app.runs.publishing import RunResult
from app.views.overlay import Overlay, overlay_figure
from app.views.overlay import compare as laid_over

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from typing import TypeAlias

    from app.views.plotting import Picture
    from rigs.analysis.alignment import Alignment
    from rigs.readers.mapping import FileMapping

    Test: TypeAlias = Path | str | RunResult | RunReader | Sweep


@dataclass(frozen=True, kw_only=True)
class Comparison(Overlay):
    """Tests laid over each other, with their scores; in a notebook it shows itself.

    The attributes of `Overlay` are the scores as a `Table`, the tests, what is compared over what, and the file of the
    figure where one was asked for.
    """

    @classmethod
    def of(cls, result: Overlay) -> Self:
        """Return a comparison with its table and plot at hand."""
        return cls(**{one.name: getattr(result, one.name) for one in fields(Overlay)})

    @cached_property
    def table(self) -> Any:  # noqa: ANN401 (pandas is optional, and ships no types)
        """Scores of every test: NRMSE, secants, loops."""
        return frame_of(self.scores)

    def plot(self) -> Picture:
        """Return the tests in one figure, a panel an axis."""
        from app.views.plotting import Picture  # noqa: PLC0415 (matplotlib, when a plot is wanted)

        return Picture(overlay_figure(self.groups, self.scores, self.quantity))

    def __repr__(self) -> str:
        """Return what is compared over what, and the tests."""
        across, along = self.quantity
        names = ", ".join(dict.fromkeys(group.name for group in self.groups))
        return f"Comparison({along} over {across}: {names})"

    def _repr_html_(self) -> str:
        """Return plot and scores, for a notebook."""
        across, along = self.quantity
        head = head_html("comparison", f"{along} over {across}, {len(self.groups)} curves")
        return f"{head}{self.plot().html()}{folded('Scores', table_html(self.scores))}"


def compare(
    sources: Test | Sequence[Test],
    out: Path | str | None = None,
    *,
    mapping: Path | FileMapping | None = None,
    alignment: Alignment | None = None,
    axis: str | None = None,
    leave_out: Collection[int] = (),
    repeats: bool = False,
) -> Comparison:
    """Lay runs and measured files over each other, and score them.

    Repeats in a file are drawn as a band about their mean. Others are scored against the first measured file, or
    without one the first run.

    Parameters
    ----------
    sources : Path, str, Run, RunReader, Sweep, or a list of them
        Run folders, files of instruments, YAML files that list them, results of `run` and `sweep`.
    out : Path, str or None
        File of the figure; None for none.
    mapping : Path, FileMapping or None
        What the measured files do not say themselves.
    alignment : Alignment or None
        Which cycle, and how tests are put on each other; None for the first cycle as it is.
    axis : str or None
        Compare this axis alone; a file that names no axis is of this one. None for all.
    leave_out : collection of int
        Repeats of the files that are left out, counted from 1.
    repeats : bool
        Whether the measured files are repeats of one test, one after the other.

    Raises
    ------
    FileNotFoundError, FormatError
        If one of them is not there, or cannot be read.
    SpecificationError
        If nothing is left to compare, a test lacks the cycle, or the axes of files and runs do not fit.
    """
    return Comparison.of(
        laid_over(
            places_of(sources),
            out,
            mapping=mapping,
            alignment=alignment,
            axis=axis,
            leave_out=leave_out,
            repeats=repeats,
        )
    )


def places_of(sources: Test | Sequence[Test]) -> list[Path | str]:
    """Return where tests are; of a sweep the folders of its points."""
    found: list[Path | str] = []
    for one in [sources] if isinstance(sources, str | Path | RunResult | RunReader | Sweep) else sources:
        found += [point.folder for point in one.points] if isinstance(one, Sweep) else [place_of(one)]
    return found
