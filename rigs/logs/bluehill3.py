"""The cyclic raw data of Instron's Bluehill 3.

Documented, by files and readers that laboratories publish: the folder ``<sample>.is_tcyclic_RawData`` with
``Specimen_RawData_1.csv`` for the first specimen; lines of test facts, the label in quotes; exactly one blank line,
by which readers find the headings among the first hundred lines; two lines of headings; five decimals; the segment
identities 22476 outward and 22412 on the return; a total cycle count that starts at 0 and rises about 1 % of a
stroke after the turnaround; no footer. A line ``Dimension : Length``, a number and ``mm`` gives the gauge length.

Assumed: CRLF ends and no byte-order mark (it is a Windows program); the date of the laboratory's clock as
day/month/year with twelve hours; a specimen at rest keeps the segment of the stroke before; the gauge length is named
where a zero of the test took one, with that of the specimen as printed and the extension from there to the zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.instruments.samples import parts_of
from rigs.instruments.zeros import gauge_lengths_taken
from rigs.logs.dialect import Column, Dialect, Fact
from rigs.logs.logged import Log, axis_of, pin_channels
from rigs.logs.strokes import OUTWARD, counts, rises, segments

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.instruments.samples import Table
    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged

PINS: Final = Column(name="Extensometer {axis}", channel="", below="({unit})", unit="mm", form=".5f")

DIALECT: Final = Dialect(
    name="bluehill3",
    preamble=(
        ("Text Inputs : Specimen label", Fact(fact="label", quoted=True)),
        ("General : Start Date", Fact(fact="started")),
        ("Dimension : Length", Fact(fact="gauge length", unit="mm", form=".5f"), "mm"),
        ("Number Inputs : Length as printed", Fact(fact="printed length", unit="mm", form=".5f"), "mm"),
        ("Number Inputs : Extension from printed to zero", Fact(fact="zero", unit="mm", form=".5f"), "mm"),
        (),
    ),
    columns=(
        Column(name="Time", channel="Time", below="({unit})", unit="sec", form=".5f"),
        Column(name="Extension", channel="Extension", below="({unit})", unit="mm", form=".5f"),
        Column(name="Load", channel="Load", below="({unit})", unit="N", form=".5f"),
        Column(name="Segment ID", channel="Segment", below="", form=".0f"),
        Column(name="Total Cycle Count", channel="Count", below="", form=".0f"),
    ),
)


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather crosshead, load cell, segments and cycles of the frame, in SI units."""
    table = test.samples["uniaxial-frame"]
    return _numbered(table), {"label": test.sample, "started": test.start(), **_lengths(test, table)}


def _lengths(test: Logged, table: Table) -> Facts:
    """Return the gauge length that was taken last, with both zeros of the test [m]; None for each if none was."""
    taken, axis = gauge_lengths_taken(test.size, test.zeroings), axis_of(table.part(0, 1))
    if not taken:
        return dict.fromkeys(("gauge length", "printed length", "zero"))
    return {
        "gauge length": taken[-1].gauges[axis],
        "printed length": test.size.gauge(axis),
        "zero": taken[-1].travel[axis],
    }


def _numbered(table: Table) -> Iterator[Channels]:
    """Yield the channels part by part, with the numbers of segments and cycles."""
    found = rises(table, "Displacement")
    first, segment = 0, OUTWARD
    for samples in parts_of(table):
        numbers = segments(samples.phase, segment)
        yield {
            "Time": samples.time.tolist(),
            "Extension": samples.measured["Displacement"].tolist(),
            "Load": samples.measured["Force"].tolist(),
            "Segment": numbers,
            "Count": counts(found, first, first + len(samples)),
            **pin_channels(samples),
        }
        first, segment = first + len(samples), numbers[-1]


LOG: Final = Log(
    dialect=DIALECT,
    machines=("uniaxial-frame",),
    place="{sample}.is_tcyclic_RawData/Specimen_RawData_1.csv",
    gather=gather,
    pins=PINS,
    about="the frame's cycles, as Instron's Bluehill 3",
)
