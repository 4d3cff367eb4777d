"""The results table of Instron's Bluehill 3 with the raw data below it.

Documented, by readers that laboratories publish: the line ``Results Table 1``; headings, units and one line of values
for each specimen, the first field its number, without a heading of its own; further down two lines of headings of the
raw data, the first beginning with ``Time``, and numbers in quotes.

Assumed: which results a method calculates (largest load and extension, and the stress and strain at that load);
one blank line between table and raw data; the raw block as in ``bluehill3-quoted``; the file's place.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.instruments.samples import parts_of
from rigs.logs import bluehill3_quoted
from rigs.logs.dialect import Dialect, Fact
from rigs.logs.logged import Log

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged

DIALECT: Final = Dialect(
    name="bluehill3-results",
    preamble=(
        ("Results Table 1",),
        (
            "",
            "Maximum Load",
            "Extension at Maximum Load",
            "Tensile strain at Maximum Load",
            "Tensile stress at Maximum Load",
        ),
        ("", "(N)", "(mm)", "(%)", "(MPa)"),
        (
            "1",
            Fact(fact="Load", unit="N", form=",.5f", quoted=True),
            Fact(fact="Extension", unit="mm", form=",.5f", quoted=True),
            Fact(fact="Strain", unit="%", form=",.4f", quoted=True),
            Fact(fact="Stress", unit="MPa", form=",.4f", quoted=True),
        ),
        (),
    ),
    columns=bluehill3_quoted.COLUMNS,
)


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather the raw data, and the sample of the largest load."""
    table = test.samples["uniaxial-frame"]
    most, largest = -inf, table.part(0, 1)
    for samples in parts_of(table):
        at = int(np.argmax(samples.measured["Force"]))
        if samples.measured["Force"][at] > most:
            most, largest = float(samples.measured["Force"][at]), samples.part(at, at + 1)
    values = {name: one for name, (one,) in bluehill3_quoted.shown(test, largest).items() if name != "Time"}
    return bluehill3_quoted.gather(test)[0], values


LOG: Final = Log(
    dialect=DIALECT,
    machines=("uniaxial-frame",),
    place="{sample}.is_tens_Exports/{sample}_1.csv",
    gather=gather,
    pins=bluehill3_quoted.PINS,
    about="the frame's results table and raw data, as Instron's Bluehill 3",
)
