"""The raw data of a tensile test in Instron's Bluehill 3, with strain and stress, every number in quotes.

Documented, by the files that the package pymechtest is tested with: the fact lines ``Specimen number (included)`` and
``Specimen ID``, the latter in quotes; one blank line; two lines of headings; five decimals, of strain and stress four;
every number in quotes, thousands marked inside them; the file's name. The folder ``<sample>.is_tens_RawData`` is that
of scripts that laboratories publish.

pymechtest finds the columns by "stress" and "strain" in their names; it is told the rows of the identity
(``id_row=1``) and, blank lines not counted, of the headings (``header=2``).

Assumed: CRLF ends and no byte-order mark; no other fact lines; strain is the crosshead's travel over the gauge length,
stress the load over width and unit thickness: those of the specimen as printed, or where a zero took them, as the
record says.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.instruments.samples import parts_of
from rigs.instruments.zeros import size_in_time
from rigs.logs.dialect import Column, Dialect, Fact
from rigs.logs.logged import Log, axis_of, pin_channels

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.instruments.samples import Samples
    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged

PINS: Final = Column(name="Extensometer {axis}", channel="", below="({unit})", unit="mm", form=",.5f", quoted=True)

COLUMNS: Final = (
    Column(name="Time", channel="Time", below="({unit})", unit="s", form=",.5f", quoted=True),
    Column(name="Extension", channel="Extension", below="({unit})", unit="mm", form=",.5f", quoted=True),
    Column(name="Load", channel="Load", below="({unit})", unit="N", form=",.5f", quoted=True),
    Column(name="Tensile strain (Strain 1)", channel="Strain", below="({unit})", unit="%", form=",.4f", quoted=True),
    Column(name="Tensile stress", channel="Stress", below="({unit})", unit="MPa", form=",.4f", quoted=True),
)

DIALECT: Final = Dialect(
    name="bluehill3-quoted",
    preamble=(("Specimen number (included)", "1"), ("Specimen ID", Fact(fact="label", quoted=True)), ()),
    columns=COLUMNS,
)


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather crosshead and load cell of the frame, and strain and stress of the specimen, in SI units."""
    return (shown(test, samples) for samples in parts_of(test.samples["uniaxial-frame"])), {"label": test.sample}


def shown(test: Logged, samples: Samples) -> dict[str, list[float]]:
    """Return what the columns show of a part of the samples, in SI units."""
    axis = axis_of(samples)
    travel, load = samples.measured["Displacement"], samples.measured["Force"]
    size = size_in_time(samples.true_time, test.size, test.zeroings)
    return {
        "Time": samples.time.tolist(),
        "Extension": travel.tolist(),
        "Load": load.tolist(),
        "Strain": (travel / size.gauge(axis)).tolist(),
        "Stress": (load / size.section(axis)).tolist(),
        **pin_channels(samples),
    }


LOG: Final = Log(
    dialect=DIALECT,
    machines=("uniaxial-frame",),
    place="{sample}.is_tens_RawData/Specimen_RawData_1.csv",
    gather=gather,
    pins=PINS,
    about="the frame's with strain and stress, as Instron's Bluehill 3",
)
