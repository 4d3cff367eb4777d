"""Runs of a study: each set of values in a folder of its own, kept and used again."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from typing import TYPE_CHECKING, Final, Protocol

from app.records.folder import RECORD
from app.runs.sweeps import is_done
from app.runs.use_cases import resume_run, run_protocol
from app.schemas import load
from app.schemas.sweep import label_of
from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from types import TracebackType
    from typing import Self

    from app.runs.publishing import Progress
    from app.schemas import Source
    from app.schemas.document import Data
    from app.schemas.sweep import Scalar
    from rigs.axes import FloatArray

MOST_STEPS: Final = 40
"""Steps of the search of a calibration."""


class Parameter(Protocol):
    """A parameter between bounds or among words, by its coordinate from 0 to 1."""

    @property
    def name(self) -> str:
        """Return its name."""

    @property
    def unit(self) -> str:
        """Return the unit that its values are written with; empty of a plain number or a word."""

    def value(self, z: float) -> Scalar:
        """Return the value at a coordinate."""


@dataclass(slots=True, kw_only=True)
class FitRuns:
    """Runs of the protocol with values of its parameters, each in a folder of its own.

    Attributes
    ----------
    protocol : Path, str or Mapping
        The protocol.
    folder : Path
        Where the runs are.
    chosen : Mapping
        Values of other parameters.
    jobs : int
        Processes at once.
    parameters : sequence of Parameter
        The parameters that vary.
    progress : callable
        Told of every run.
    most : int
        Runs there may be, of which progress is a share.
    done : dict
        Folder of each run by its label, None where its values cannot be run, and why.
    reused : int
        How many had been done before.
    """

    protocol: Source
    folder: Path
    chosen: Mapping[str, Data]
    jobs: int
    parameters: Sequence[Parameter]
    progress: Progress
    most: int
    done: dict[str, tuple[Path | None, str]] = field(default_factory=dict)
    reused: int = 0
    _pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        """Start the processes, where there are to be several."""
        if self.jobs > 1:
            self._pool = ProcessPoolExecutor(max_workers=self.jobs, mp_context=get_context("spawn"))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the processes."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)

    def values(self, z: FloatArray) -> dict[str, Scalar]:
        """Return the values at some coordinates, as a protocol writes them."""
        found: dict[str, Scalar] = {}
        for one, place in zip(self.parameters, z, strict=True):
            value = one.value(float(place))
            found[one.name] = f"{value:.8g} {one.unit}" if one.unit else value
        return found

    def said(self, z: FloatArray) -> str:
        """Return values in words, and what is wrong with them."""
        values = self.values(z)
        words = ", ".join(f"{name} = {value}" for name, value in values.items())
        why = self.done.get(label_of(values), (None, ""))[1]
        return f"{words}{': ' * bool(why)}{why}"

    def at(self, places: Sequence[FloatArray]) -> list[Path | None]:
        """Return the folders of the runs at some coordinates, done before or now; None of what cannot be run."""
        points = {label_of(values): values for values in map(self.values, places)}
        todo = {label: values for label, values in points.items() if label not in self.done}
        for label, values in list(todo.items()):
            if self._is_done(label, values):
                self.reused += 1
                self.done[label] = self.folder / label, ""
                del todo[label]
        tasks = [(self.protocol, self.folder / label, {**self.chosen, **values}) for label, values in todo.items()]
        ends = map(run_one, tasks) if self._pool is None else self._pool.map(run_one, tasks)
        for label, (end, message) in zip(todo, ends, strict=True):
            if end == "abort":
                raise KeyboardInterrupt
            self.done[label] = (self.folder / label if end else None), message
            self.progress(min(len(self.done) / self.most, 1.0), f"run {len(self.done)}: {label}")
        return [self.done[label_of(self.values(place))][0] for place in places]

    def _is_done(self, label: str, values: Mapping[str, Data]) -> bool:
        """Return whether the run of some values was done before."""
        if not (self.folder / label / RECORD).exists():
            return False
        return is_done(self.folder / label, load(self.protocol, {**self.chosen, **values}))


def run_one(task: tuple[Source, Path, Mapping[str, Data]]) -> tuple[str, str]:
    """Run one point in its folder or resume it; return its end and message, no end where it cannot be run."""
    protocol, folder, values = task
    try:
        if (folder / RECORD).exists():
            result = resume_run(folder, draw=None)
        else:
            result = run_protocol(protocol, folder, exact=True, chosen=values, draw=None)
    except KnitlabError as error:
        return "", str(error)
    return result.outcome, result.message
