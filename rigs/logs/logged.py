"""Data of a test that logs show, and the description of a log file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime
from itertools import chain
from typing import TYPE_CHECKING, Literal, TypeAlias

from knitlab_core.errors import SpecificationError
from rigs.axes import AXES
from rigs.instruments.channels import EXTENSOMETER

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rigs.axes import Axis
    from rigs.instruments.samples import Samples, Table
    from rigs.instruments.zeros import Zeroing
    from rigs.logs.dialect import Channels, Column, Dialect
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
    pins : Column or None
        Form of the columns that an extensometer's channels have, after all others and only where there is one: its
        name is followed by the axis. None for a log that shows none.
    axis_columns : callable or None
        Gives the columns of an axis that its machine drives, which come after the dialect's; None for a log whose
        columns are the same whatever is driven.
    """

    dialect: Dialect
    machines: tuple[str, ...]
    place: str
    gather: Callable[[Logged], tuple[Iterable[Channels], Facts]]
    about: str
    kind: Literal["text", "sheet"] = "text"
    pins: Column | None = None
    axis_columns: Callable[[Axis], tuple[Column, ...]] | None = None

    def shown(self, test: Logged) -> Dialect:
        """Return its bytes for a test: the dialect, with the columns of each axis and pair of pins."""
        dialect, further = self.dialect, []
        for machine in self.machines:
            before = f"{machine}." if len(self.machines) > 1 else ""
            samples = test.samples[machine].part(0, 1)
            dialect = self.of_axes(axes_of(samples))
            if self.pins is not None:
                further += list(_pin_columns(self.pins, before, pin_names(samples)))
        return replace(dialect, columns=(*dialect.columns, *further))

    def of_axes(self, axes: Iterable[Axis]) -> Dialect:
        """Return its bytes for some axes of its machine, without columns of pins."""
        if self.axis_columns is None:
            return self.dialect
        further = chain.from_iterable(map(self.axis_columns, axes))
        return replace(self.dialect, columns=(*self.dialect.columns, *further))


def _pin_columns(form: Column, before: str, names: Iterable[str]) -> Iterator[Column]:
    """Yield the column of each of the extensometer's channels of a machine."""
    for name in names:
        heading = form.name.replace("{axis}", name.removeprefix(EXTENSOMETER))
        yield replace(form, name=f"{before}{heading}", channel=f"{before}{name}")


def pin_names(samples: Samples) -> list[str]:
    """Return the names of the extensometer's channels of a machine, the axis last; none without one."""
    return [name for name in samples.measured if name.startswith(EXTENSOMETER)]


def pin_channels(samples: Samples) -> dict[str, list[float]]:
    """Return the distances of the extensometer's pins, by the channel's name [m]; none without one."""
    return {name: samples.measured[name].tolist() for name in pin_names(samples)}


def axes_of(samples: Samples) -> list[Axis]:
    """Return the axes that a machine drives."""
    return [axis for axis in AXES if f"force_{axis}" in samples.reads.values()]


def axis_of(samples: Samples) -> Axis:
    """Return the axis along which a machine that pulls one axis pulls."""
    return axes_of(samples)[0]
