"""Design: parameters of a protocol with which its test comes to what is wanted, proved by a last test."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from app.records.table_files import write_table
from app.runs.runner import quiet
from app.runs.sweeps import MOST_JOBS
from app.schemas import load
from app.schemas.designs import load_design
from app.schemas.sampling import unit_design
from app.studies.design_space import space_of
from app.studies.design_tables import outcome_of, trial_table
from app.studies.design_target import target_of
from app.studies.fit_runs import FitRuns
from app.studies.printability import print_checks, printer_of, refusal
from app.studies.search import best_of, search, surrogate_of
from app.studies.surrogate import require_extra
from app.views.designs import design_plot
from app.views.overlay import run_groups
from knitlab_core.errors import SpecificationError
from rigs.analysis.alignment import Alignment

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.printing.checks import Check
    from app.runs.publishing import Progress
    from app.schemas.designs import DesignFile
    from app.schemas.sweep import Scalar
    from app.studies.design_space import Space
    from app.studies.design_tables import Outcome
    from app.studies.design_target import Target
    from app.studies.search import Trial
    from rigs.analysis.table import Table
    from rigs.axes import FloatArray
    from rigs.machines.printer import PrinterData

PROPOSALS: Final = 2
"""Tests of a round."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """What a design gives.

    Attributes
    ----------
    values : Mapping
        Values of the free parameters, as a protocol writes them.
    outcome : Outcome
        Target, what the surrogate expected, and what the last test reached.
    checks : sequence of Check
        What a printer needs, found and allowed; empty where it was not asked.
    trials : sequence of Trial
        Every test of the search.
    folder : Path
        Run of the last test.
    runs, reused : int
        Tests that were needed, and how many of them had been done before.
    notes : tuple of str
        What else a user must know.
    table : Table
        Every test: values, what it came to, what was expected.
    files : tuple of Path
        `design.csv` and `design.png`.
    """

    values: Mapping[str, Scalar]
    outcome: Outcome
    checks: Sequence[Check]
    trials: Sequence[Trial]
    folder: Path
    runs: int
    reused: int
    notes: tuple[str, ...]
    table: Table
    files: tuple[Path, ...]


def design(
    source: Path | str, out: Path | str = Path("runs/design"), progress: Progress = quiet, *, jobs: int = 1
) -> Design:
    """Look for parameters with which a test comes to what a design file wants.

    Tests that fill the ranges make a surrogate, which proposes further ones until one is near enough; its values,
    rounded to four digits, are tested last. Runs are kept in `out` and used again.

    Parameters
    ----------
    source : Path or str
        Design file, of schema ``knitlab/design@1``.
    out : Path or str
        Folder of the runs, table and figure.
    progress : callable, optional
        Told the share done [1] and what is being done.
    jobs : int
        Processes that run at once.

    Raises
    ------
    ProtocolError, SpecificationError, FormatError
        For a mistake in the file or its protocol, or if too few tests can be carried out.
    KeyboardInterrupt
        If a run was interrupted.
    """
    require_extra()
    if not 1 <= jobs <= MOST_JOBS:
        raise SpecificationError("--jobs", jobs, f"a whole number from 1 to {MOST_JOBS}")
    file, out = load_design(source), Path(out)
    space, target, printer = space_of(file), target_of(file.target), printer_of(file.printer)
    _require_names(file)
    first = space.snapped(np.array(unit_design(file.method, file.points, len(space.parameters), file.seed)))
    most = file.points + PROPOSALS * file.rounds
    with FitRuns(
        protocol=file.protocol,
        folder=out / "runs",
        chosen={},
        jobs=jobs,
        parameters=space.parameters,
        progress=progress,
        most=most,
    ) as runs:
        refused: dict[str, str] = {}
        allowed = _Allowed(runs=runs, printer=printer, refused=refused)
        kept = [z for z in first if allowed(z)]
        if not kept:
            why = next(iter(refused.values()))
            raise SpecificationError("design", f"no point that can be made: {why}", "ranges in which some can")
        trials = search(
            lambda places: [None if one is None else target.features(one) for one in runs.at(places)],
            target.goal,
            kept,
            within=file.within,
            rounds=file.rounds,
            encode=space.encoded,
            snap=space.snapped,
            allowed=allowed,
        )
    return _proved(file, out, space, target, printer, trials, runs, refused, progress)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Allowed:
    """Whether coordinates may be tested: the knit can be made and printed. What is refused is kept with its reason."""

    runs: FitRuns
    printer: PrinterData | None
    refused: dict[str, str]

    def __call__(self, z: FloatArray) -> bool:
        values = self.runs.values(z)
        try:
            why = refusal(load(self.runs.protocol, values).one_test(), self.printer)
        except SpecificationError as error:
            why = str(error)
        if why:
            self.refused[str(values)] = why
        return not why


def _require_names(file: DesignFile) -> None:
    """Raise unless all parameters are names under the protocol's params."""
    data = load(file.protocol).one_test().document.data
    params = data.get("params", {}) if isinstance(data, dict) else {}
    known = list(params) if isinstance(params, dict) else []
    for name in (*(one.name for one in file.ranges), *file.choices, *file.proof):
        if name not in known:
            raise SpecificationError(f"{file.path}: {name}", "no parameter", f"a name under params: {', '.join(known)}")


def _proved(
    file: DesignFile,
    out: Path,
    space: Space,
    target: Target,
    printer: PrinterData | None,
    trials: Sequence[Trial],
    runs: FitRuns,
    refused: Mapping[str, str],
    progress: Progress,
) -> Design:
    """Test the best values, rounded, and return all that is to be said."""
    best = best_of(trials)
    z = space.rounded(best.z)
    progress(1.0, "the last test")
    with FitRuns(
        protocol=file.protocol,
        folder=out / "proof",
        chosen=file.proof,
        jobs=1,
        parameters=space.parameters,
        progress=quiet,
        most=1,
    ) as proof:
        (folder,) = proof.at([z])
        if folder is None:
            raise SpecificationError("design", proof.said(z), "values with which the last test can be carried out")
    features = target.features(folder)
    # The last test must not tell the surrogate what it is to come to.
    expected = surrogate_of(trials, space.encoded, but=best.z, widened=True)
    outcome = outcome_of(target, expected, space.encoded(z[None]), features, file.within)
    values = runs.values(z)
    loaded = load(file.protocol, {**file.proof, **values}).one_test()
    table = trial_table(trials, runs, target)
    files = (
        write_table(table, out / "design.csv"),
        design_plot(
            [one.distance for one in trials],
            sum(one.round == 0 for one in trials),
            file.within,
            target.drawn(),
            _curve(folder, target),
            out / "design.png",
        ),
    )
    return Design(
        values=values,
        outcome=outcome,
        checks=[] if printer is None else print_checks(loaded, printer, out),
        trials=trials,
        folder=folder,
        runs=len(runs.done) + len(proof.done),
        reused=runs.reused + proof.reused,
        notes=tuple(_notes(trials, refused, outcome)),
        table=table,
        files=files,
    )


def _curve(folder: Path, target: Target) -> tuple[FloatArray, FloatArray]:
    """Return strain and stress of the cycle of a run that counts."""
    groups = run_groups(folder, Alignment(cycle=target.wanted.cycle))
    test = next(one for one in groups if one.axis == target.wanted.axis).tests[0].test
    return test.strain, test.stress


def _notes(trials: Sequence[Trial], refused: Mapping[str, str], outcome: Outcome) -> list[str]:
    """Return what a user must know besides."""
    notes = []
    if refused:
        first = next(iter(refused.values()))
        notes.append(f"{len(refused)} points were left out, for they cannot be made, the first of them: {first}")
    lost = sum(one.features is None for one in trials)
    if lost:
        notes.append(f"{lost} tests did not come to what is looked for, and count for nothing")
    if not outcome.met:
        notes.append(
            f"the last test is {100.0 * outcome.distance:.3g} % off, more than the {100.0 * outcome.within:g} %"
        )
    return notes
