"""Calibration: parameters of a protocol fitted to measured tests, by least squares over runs that are kept."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from app.records.table_files import write_table
from app.runs.runner import quiet
from app.runs.sweeps import MOST_JOBS
from app.schemas import load
from app.schemas.sampling import number_and_unit
from app.studies.fit_runs import MOST_STEPS, FitRuns
from app.studies.fit_tables import curve_table, estimate_table
from app.studies.misfit import Misfit
from app.views.calibrations import calibration_plot
from app.views.overlay import groups_of
from knitlab_core.errors import SpecificationError
from rigs.analysis.alignment import Alignment
from rigs.analysis.estimation import Bounded, estimates, without_roughness

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from app.runs.publishing import Progress
    from app.schemas import Source
    from app.schemas.document import Data
    from rigs.analysis.comparison import Across, Along
    from rigs.analysis.estimation import Estimates
    from rigs.analysis.residuals import Residuals
    from rigs.axes import FloatArray
    from rigs.readers.mapping import FileMapping

MOST_PARAMETERS: Final = 12
CONVERGED: Final = 1e-4
"""Step, in the width of the bounds, and gain, in the sum of squares, below which the search ends [1]."""

RANGE: Final = 2.0
"""Ratio of a parameter's bounds to its value in the protocol, where none are given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationResult:
    """What a calibration gives.

    Attributes
    ----------
    estimates : Estimates
        Parameters with intervals, correlations and what the data do not tell.
    first, last : float
        Root mean square difference of the curves, in their ranges, with the protocol's values and with the best [1].
    residuals : Mapping
        Differences of every measured test with the best values, by its name and axis.
    quantity : (Across, Along)
        What was compared over what.
    runs, reused : int
        Runs that were needed, and how many of them had been done before.
    notes : tuple of str
        What else a user must know: bounds that were hit, what was not covered, a search that did not end.
    files : tuple of Path
        `calibration.csv`, `fit.csv` and `fit.png`.
    """

    estimates: Estimates
    first: float
    last: float
    residuals: Mapping[tuple[str, str], list[Residuals]]
    quantity: tuple[Across, Along]
    runs: int
    reused: int
    notes: tuple[str, ...]
    files: tuple[Path, ...]


def calibrate(
    protocol: Source,
    measured: Sequence[Path | str],
    fit: Sequence[str],
    out: Path | str = Path("runs/calibration"),
    progress: Progress = quiet,
    *,
    jobs: int = 1,
    chosen: Mapping[str, Data] | None = None,
    mapping: Path | FileMapping | None = None,
    alignment: Alignment | None = None,
    axis: str | None = None,
    leave_out: Collection[int] = (),
) -> CalibrationResult:
    """Fit parameters of a protocol to measured files or runs.

    Runs are kept in `out` and used again, so that an interrupted calibration goes on where it was.

    Parameters
    ----------
    protocol : Path, str or Mapping
        The protocol: its file, its text, or data, with the parameters under `params`.
    measured : sequence of Path or str
        Files of instruments, and runs; each test in them counts alike.
    fit : sequence of str
        ``NAME`` or ``NAME=LOW:HIGH``, such as ``E=0.5 GPa:2 GPa``; without bounds half to twice the protocol's value.
    out : Path or str
        Folder of the runs, tables and the figure.
    progress : callable, optional
        Told the share done [1] and what is being done.
    jobs : int
        Processes that run at once.
    chosen : Mapping, optional
        Values of other parameters in the place of the protocol's.
    mapping, alignment, axis, leave_out
        As in `app.views.overlay.compare`.

    Raises
    ------
    SpecificationError
        For a name that is no parameter, bounds that are none, or tests that cannot be compared.
    KeyboardInterrupt
        If a run was interrupted.
    """
    if not 1 <= jobs <= MOST_JOBS:
        raise SpecificationError("--jobs", jobs, f"a whole number from 1 to {MOST_JOBS}")
    out, how = Path(out), Alignment() if alignment is None else alignment
    parameters = bounded(protocol, fit, chosen or {})
    groups = groups_of(measured, mapping, how, axis, leave_out)
    with FitRuns(
        protocol=protocol,
        folder=out / "runs",
        chosen=chosen or {},
        jobs=jobs,
        parameters=parameters,
        progress=progress,
        most=MOST_STEPS * (1 + len(parameters)),
    ) as runs:
        misfit = Misfit(runs=runs, groups=groups, how=how)
        z, steps_left = _search(misfit, parameters)
        jacobian = misfit.central(z)
        parts = misfit.parts(z)
        series = [one.scaled for each in parts.values() for one in each]
        found = estimates(parameters, z, jacobian, series)
        notes = [*_bound_notes(found), *misfit.uncovered(z)]
        if not steps_left:
            notes.append(f"the search did not end within {MOST_STEPS} steps; the same command with other bounds may")
        quantity = misfit.quantities(runs.at([z])[0])
        first = _rms(misfit(np.array([one.coordinate(one.start) for one in parameters])))
        files = (
            write_table(estimate_table(found), out / "calibration.csv"),
            write_table(curve_table(parts, *quantity), out / "fit.csv"),
            calibration_plot(parts, quantity, out / "fit.png"),
        )
        return CalibrationResult(
            estimates=found,
            first=first,
            last=_rms(np.concatenate(series)),
            residuals=parts,
            quantity=quantity,
            runs=len(runs.done),
            reused=runs.reused,
            notes=tuple(notes),
            files=files,
        )


def bounded(protocol: Source, fit: Sequence[str], chosen: Mapping[str, Data]) -> list[Bounded]:
    """Return the parameters that words such as ``E=0.5 GPa:2 GPa`` name, with bounds and first values.

    Raises
    ------
    SpecificationError
        For a name that is no parameter or no number, or bounds that are none.
    """
    data = load(protocol, chosen).one_test().document.data
    params = data.get("params", {}) if isinstance(data, dict) else {}
    params = {**params, **chosen} if isinstance(params, dict) else {}
    if not 1 <= len(fit) <= MOST_PARAMETERS:
        raise SpecificationError("--fit", f"{len(fit)} parameters", f"1 to {MOST_PARAMETERS}")
    found: dict[str, Bounded] = {}
    for word in fit:
        one = _bounded(word, params)
        if one.name in found:
            raise SpecificationError("--fit", f"{one.name} twice", "each parameter once")
        found[one.name] = one
    return list(found.values())


def _bounded(word: str, params: Mapping[str, Data]) -> Bounded:
    """Return one parameter."""
    name, sign, ends = word.partition("=")
    name = name.strip()
    if name not in params:
        raise SpecificationError("--fit", name, f"a name under params: {', '.join(params) or 'none'}")
    start = number_and_unit(params[name])
    if start is None:
        raise SpecificationError(
            "--fit", f"{name}: {params[name]}", "a parameter that is a number, with or without unit"
        )
    value, unit = start
    if not sign:
        if value <= 0.0:
            raise SpecificationError("--fit", word, f"bounds, {name}=LOW:HIGH, of a parameter that is not above 0")
        return Bounded(name=name, low=value / RANGE, high=value * RANGE, start=value, unit=unit)
    pair = [number_and_unit(end) for end in ends.split(":")]
    low, high = (*pair, None)[:2] if len(pair) == 2 else (None, None)
    if low is None or high is None or not low[0] < high[0]:
        raise SpecificationError(
            "--fit", word, f"{name}=LOW:HIGH, such as {name}={value / 2:g}{unit}:{value * 2:g}{unit}"
        )
    if {low[1], high[1]} - {unit} - ({""} if low[1] == "" else set()):
        raise SpecificationError("--fit", word, f"bounds in the unit of the protocol's value: {unit or 'none'}")
    if not low[0] <= value <= high[0]:
        value = (low[0] * high[0]) ** 0.5 if low[0] > 0.0 else 0.5 * (low[0] + high[0])
    return Bounded(name=name, low=low[0], high=high[0], start=float(f"{value:.8g}"), unit=unit)


def _search(misfit: Misfit, parameters: Sequence[Bounded]) -> tuple[FloatArray, bool]:
    """Return the coordinates with the least sum of squares, and whether the search ended by itself.

    Trust-region reflective search (Branch, Coleman and Li, SIAM J. Sci. Comput. 21 (1999) 1), finite differences of
    `STEP`, and no step along directions that only roughness tells.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 (takes long to import)

    start = np.array([one.coordinate(one.start) for one in parameters])
    if not np.isfinite(misfit(start)).all():
        expected = "first values with which a cycle can be run, with three equilibria or more in each branch"
        raise SpecificationError(load(misfit.runs.protocol).document.path, misfit.runs.said(start), expected)
    found = least_squares(
        misfit,
        start,
        jac=lambda z: without_roughness(misfit.forward(z)),
        bounds=(0.0, 1.0),
        method="trf",
        xtol=CONVERGED,
        ftol=CONVERGED,
        gtol=1e-12,
        max_nfev=MOST_STEPS,
    )
    return np.asarray(found.x), found.status > 0


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _bound_notes(found: Estimates) -> list[str]:
    """Return what is to be said of estimates at a bound."""
    return [
        f"{one.parameter.name} is at its {one.at_bound} bound, {one.used:.4g}{' ' * bool(one.parameter.unit)}"
        f"{one.parameter.unit}: the best value may be beyond"
        for one in found.each
        if one.at_bound and np.isfinite(one.value)
    ]
