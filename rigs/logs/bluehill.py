"""Describe the log of Instron's Bluehill Universal, the dialect of the frame.

Documented, by scripts that laboratories publish with their data: the three headings, the line of units below them,
and the file's place, ``<sample>.is_tcyclic_Exports/<sample>_1.csv`` for the first specimen of a cyclic tensile test.

Assumed, for want of a file of the instrument itself: CRLF ends and no byte-order mark (it is a Windows program);
up to four decimals, without the zeros that end them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigs.logs.writer import Column, Dialect

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.instruments import Samples

BLUEHILL_UNIVERSAL = Dialect(
    name="bluehill-universal",
    columns=(
        Column(name="Time", channel="Time", form=".4f", unit="(s)", trimmed=True),
        Column(name="Displacement", channel="Displacement", scale=1e3, form=".4f", unit="(mm)", trimmed=True),
        Column(name="Force", channel="Force", form=".4f", unit="(N)", trimmed=True),
    ),
)

PLACE = "{sample}.is_tcyclic_Exports/{sample}_1.csv"
"""Where the instrument puts the file of a sample's first specimen."""


def bluehill_channels(samples: Samples) -> dict[str, Sequence[object]]:
    """Gather what Bluehill's columns show, in SI units.

    Parameters
    ----------
    samples : Samples
        The frame's log: crosshead and the load cell above.

    Returns
    -------
    dict of str to sequence, each of length n
        For `rigs.logs.writer.write_log`.
    """
    return {
        "Time": samples.time.tolist(),
        "Displacement": samples.measured["Displacement"].tolist(),
        "Force": samples.measured["Force"].tolist(),
    }
