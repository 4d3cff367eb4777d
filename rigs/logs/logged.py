"""Data of a test that logs show, and the description of a log file."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Literal, TypeAlias

from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rigs.axes import Axis
    from rigs.instruments.samples import Samples, Table
    from rigs.instruments.zeros import Zeroing
    from rigs.logs.dialect import Channels, Dialect
    from rigs.record import SpecimenSize

Facts: TypeAlias = "Mapping[str, object]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Logged:
    """Data of a test that its logs show.

    Attributes
    ----------
    sample : str
        Name of the sample.
    size : SpecimenSize
        Turns travel into strain and force into stress.
    samples : Mapping
        What each machine logged.
    facts : Mapping
        What the test was made with: when it began (``started``), numbers of the machine (``rig.…``).
    zeroings : tuple of Zeroing
        When channels were zeroed, and the gauge lengths from then on.
    """

    sample: str
    size: SpecimenSize
    samples: Mapping[str, Table]
    facts: Mapping[str, object]
    zeroings: tuple[Zeroing, ...] = ()

    def start(self) -> datetime:
        """Return when the test began, on the clock of the laboratory."""
        return datetime.fromisoformat(str(self._fact("started")))

    def number(self, name: str) -> float:
        """Return a number of the machine [SI unit], ``rig.carriage.compliance``."""
        return float(str(self._fact(name)))

    def _fact(self, name: str) -> object:
        if name not in self.facts:
            raise SpecificationError(f"run.{name}", "nothing", "a record that says it")
        return self.facts[name]


@dataclass(frozen=True, slots=True, kw_only=True)
class Log:
    """Log file of an instrument.

    Attributes
    ----------
    dialect : Dialect
        Its bytes.
    machines : tuple of str
        The machines whose samples it shows.
    place : str
        Path below the folder of the run, for a sample's name.
    gather : callable
        Gives the channels, in SI units, part by part, and the facts that the dialect shows of a test.
    about : str
        What it is, in a few words.
    kind : {'text', 'sheet'}
        Whether the file is text or a workbook.
    """

    dialect: Dialect
    machines: tuple[str, ...]
    place: str
    gather: Callable[[Logged], tuple[Iterable[Channels], Facts]]
    about: str
    kind: Literal["text", "sheet"] = "text"


def axis_of(samples: Samples) -> Axis:
    """Return the axis along which a machine that pulls one axis pulls."""
    return next(axis for axis in ("C", "W", "P") if any(read.endswith(f"_{axis}") for read in samples.reads.values()))
