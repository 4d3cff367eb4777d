"""A calibration as Python and notebooks see it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from app.interactive.comparisons import places_of
from app.interactive.markup import folded, head_html, notes_html, table_html
from app.interactive.results import frame_of
from app.studies.calibration import CalibrationResult
from app.studies.calibration import calibrate as fitted
from app.studies.fit_tables import curve_table, estimate_table
from app.views.calibrations import calibration_figure
from app.views.progress_bar import bar_for

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from app.interactive.comparisons import Test
    from app.runs.publishing import Progress
    from app.schemas import Source
    from app.schemas.document import Data
    from app.schemas.sweep import Scalar
    from app.views.plotting import Picture
    from rigs.analysis.alignment import Alignment
    from rigs.readers.mapping import FileMapping


@dataclass(frozen=True, kw_only=True)
class Calibration(CalibrationResult):
    """A calibration that has ended, with its tables and its plot; in a notebook it shows itself.

    The attributes of `CalibrationResult` are the estimates, residuals, counts of runs, notes and files.
    """

    @classmethod
    def of(cls, result: CalibrationResult) -> Self:
        """Return what a calibration came to, with its tables at hand."""
        return cls(**{one.name: getattr(result, one.name) for one in fields(CalibrationResult)})

    @cached_property
    def table(self) -> Any:  # noqa: ANN401 (pandas is optional, and ships no types)
        """A row for each parameter: estimate, 95 % interval, bounds, correlations; ``nan`` of what is not told."""
        return frame_of(estimate_table(self.estimates))

    @cached_property
    def curves(self) -> Any:  # noqa: ANN401 (as above)
        """Measured and fitted curves, and their residuals in the range of the cycle."""
        return frame_of(curve_table(self.residuals, *self.quantity))

    def plot(self) -> Picture:
        """Return measured and fitted curves, and the residuals below."""
        from app.views.plotting import Picture  # noqa: PLC0415 (matplotlib, when a plot is wanted)

        return Picture(calibration_figure(self.residuals, self.quantity))

    def __repr__(self) -> str:
        """Return the estimates and how near the curves come."""
        values = ", ".join(f"{one.parameter.name}={one.value:.4g}" for one in self.estimates.each)
        return f"Calibration({values}, rms={self.last:.3g}, runs={self.runs})"

    def _repr_html_(self) -> str:
        """Return estimates, what a user must know, and the plot, for a notebook."""
        words = f"curves {100.0 * self.first:.3g} % apart at first, {100.0 * self.last:.3g} % now; {self.runs} runs"
        estimates = estimate_table(self.estimates)
        notes = notes_html([*self.estimates.unseen, *self.notes])
        curves = folded("Curves", table_html(curve_table(self.residuals, *self.quantity)))
        return f"{head_html('calibration', words)}{table_html(estimates)}{notes}{self.plot().html()}{curves}"


def calibrate(
    protocol: Source,
    measured: Test | Sequence[Test],
    fit: Sequence[str] | Mapping[str, tuple[Scalar, Scalar] | None],
    out: Path | str = Path("runs/calibration"),
    progress: Progress | None = None,
    *,
    jobs: int = 1,
    chosen: Mapping[str, Data] | None = None,
    mapping: Path | FileMapping | None = None,
    alignment: Alignment | None = None,
    axis: str | None = None,
    leave_out: Collection[int] = (),
) -> Calibration:
    """Fit parameters of a protocol to measured files or runs.

    Runs are kept in `out` and used again, so that an interrupted calibration goes on where it was.

    Parameters
    ----------
    protocol : Path, str or Mapping
        The protocol: its file, its text, or data, with the parameters under `params`.
    measured : Path, str, Run, RunReader, Sweep, or a list of them
        Files of instruments, and runs; each test in them counts alike.
    fit : sequence of str, or Mapping
        ``["E=0.5 GPa:2 GPa", "mu"]`` or ``{"E": ("0.5 GPa", "2 GPa"), "mu": None}``: names under `params` with bounds;
        without bounds half to twice the protocol's value.
    out : Path or str
        Folder of the runs, tables and the figure.
    progress : callable, optional
        Told the share done [1] and what is being done; by default a bar, in a terminal or a notebook.
    jobs : int
        Processes that run at once.
    chosen : Mapping, optional
        Values of other parameters in the place of the protocol's.
    mapping, alignment, axis, leave_out
        As `compare` has them.

    Raises
    ------
    ProtocolError
        For whatever is wrong with the protocol, in one line.
    SpecificationError
        For a name that is no parameter, bounds that are none, or tests that cannot be compared.
    KeyboardInterrupt
        If a run was interrupted.
    """
    with bar_for(wanted=progress is None) as bar:
        found = fitted(
            protocol,
            places_of(measured),
            _words(fit),
            out,
            progress or bar.show,
            jobs=jobs,
            chosen=chosen,
            mapping=mapping,
            alignment=alignment,
            axis=axis,
            leave_out=leave_out,
        )
    return Calibration.of(found)


def _words(fit: Sequence[str] | Mapping[str, tuple[Scalar, Scalar] | None]) -> Sequence[str]:
    """Return parameters with their bounds as the command line has them."""
    if not isinstance(fit, Mapping):
        return fit
    return [name if ends is None else f"{name}={ends[0]}:{ends[1]}" for name, ends in fit.items()]
