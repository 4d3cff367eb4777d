"""The log of Instron's Bluehill Universal, the default of the frame.

Documented, by scripts that laboratories publish with their data: the three headings, the line of units below them,
and the file's place, ``<sample>.is_tcyclic_Exports/<sample>_1.csv`` for the first specimen of a cyclic tensile test.

Assumed, for want of a file of the instrument itself: CRLF ends and no byte-order mark (it is a Windows program);
up to four decimals, without the zeros that end them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.instruments.samples import parts_of
from rigs.logs.dialect import Column, Dialect
from rigs.logs.logged import Log, pin_channels

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged

PINS: Final = Column(name="Extensometer {axis}", channel="", below="({unit})", unit="mm", form=".4f", trimmed=True)

DIALECT: Final = Dialect(
    name="bluehill-universal",
    columns=(
        Column(name="Time", channel="Time", below="({unit})", unit="s", form=".4f", trimmed=True),
        Column(name="Displacement", channel="Displacement", below="({unit})", unit="mm", form=".4f", trimmed=True),
        Column(name="Force", channel="Force", below="({unit})", unit="N", form=".4f", trimmed=True),
    ),
)


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather crosshead and load cell of the frame, in SI units."""
    parts = (
        {
            "Time": samples.time.tolist(),
            "Displacement": samples.measured["Displacement"].tolist(),
            "Force": samples.measured["Force"].tolist(),
            **pin_channels(samples),
        }
        for samples in parts_of(test.samples["uniaxial-frame"])
    )
    return parts, {}


LOG: Final = Log(
    dialect=DIALECT,
    machines=("uniaxial-frame",),
    place="{sample}.is_tcyclic_Exports/{sample}_1.csv",
    gather=gather,
    pins=PINS,
    about="the frame's, as Instron's Bluehill Universal",
)
