"""The merged log of the triaxial rig: stage and frame in one table, on the frame's clock.

It is knitlab's own, no instrument writes it. Every sample of the frame is a line. The stage's samples are put on the
frame's clock by the offset and skew of its own that the record holds, and joined by straight lines, forces not across a
jump of the specimen; before its first and after its last sample it stands still. Columns bear the instrument's name;
``biaxial-hook.Time`` is what the stage's own clock shows, so that its own file can be found again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.instruments.samples import around, parts_of
from rigs.instruments.signals import stamps
from rigs.jumps import joined
from rigs.logs.dialect import Column, Dialect
from rigs.logs.logged import Log

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.instruments.samples import Samples, Table
    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged

FRAME: Final = "uniaxial-frame"
STAGE: Final = "biaxial-hook"


def _column(name: str, unit: str) -> Column:
    return Column(name=name, channel=name, below="({unit})", unit=unit, form=".4f", trimmed=True)


DIALECT: Final = Dialect(
    name="triaxial",
    columns=(
        _column("Time", "s"),
        _column(f"{FRAME}.Displacement", "mm"),
        _column(f"{FRAME}.Force", "N"),
        _column(f"{STAGE}.Time", "s"),
        _column(f"{STAGE}.XDisplacement", "mm"),
        _column(f"{STAGE}.YDisplacement", "mm"),
        _column(f"{STAGE}.XForce", "N"),
        _column(f"{STAGE}.YForce", "N"),
    ),
)


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather the frame's samples, and the stage's at the same moments, in SI units."""
    frame, stage = test.samples[FRAME], test.samples[STAGE]
    return (_beside(samples, stage) for samples in parts_of(frame)), {}


def _beside(frame: Samples, stage: Table) -> Channels:
    """Return some of the frame's samples, and the stage's at the same moments."""
    at = frame.true_time
    clock = stage.part(0, 1)
    first, last = stamps(at[[0, -1]], clock.clock_offset, clock.clock_skew).tolist()
    near = around(stage, first, last)
    own = near.true_time
    channels = {"Time": frame.time.tolist(), f"{STAGE}.Time": np.interp(at, own, near.time).tolist()}
    channels |= {f"{FRAME}.{name}": values.tolist() for name, values in frame.measured.items()}
    for name, values in near.measured.items():
        jumps = near.jumps if near.reads.get(name, "").startswith("force") else near.jumps[:0]
        channels[f"{STAGE}.{name}"] = joined(at, own, values, jumps).tolist()
    return channels


LOG: Final = Log(
    dialect=DIALECT,
    machines=(FRAME, STAGE),
    place="{sample}_merged.csv",
    gather=gather,
    pins=_column("Extensometer{axis}", "mm"),
    about="stage and frame of the triaxial rig in one table",
)
