"""The log of CellScale's BioTester, the dialect of the biaxial stage.

Documented, by the ``OutputColumns`` line of the instrument's own test templates and by the readers
that laboratories publish: the ten headings and their order; µm, mN, s and °C; size as the current
grip-to-grip distance, of which the first row is the reference; ``Cycle`` as number, hyphen, phase.

Assumed, for want of a file of the instrument itself: CRLF ends and no byte-order mark (it is a
Windows program); whole µm, time to 1 ms, force to 0.01 mN, temperature to 0.1 °C; ``SetName``
unquoted unless it holds a comma; the rows logged while channels are zeroed count as ``Preload``,
so that the first row, the reference, is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.instruments.samples import parts_of
from rigs.logs.dialect import Column, Dialect
from rigs.logs.logged import Log, pin_channels

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.instruments.samples import Samples
    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged
    from rigs.record import Phase

DIALECT: Final = Dialect(
    name="biotester",
    columns=(
        Column(name="SetName", channel="SetName"),
        Column(name="Cycle", channel="Cycle"),
        Column(name="Time_S", channel="Time", unit="s", form=".3f"),
        Column(name="Temperature", channel="Temperature", form=".1f"),
        Column(name="XSize_{unit}", channel="XSize", unit="um", form=".0f"),
        Column(name="YSize_{unit}", channel="YSize", unit="um", form=".0f"),
        Column(name="XDisplacement_{unit}", channel="XDisplacement", unit="um", form=".0f"),
        Column(name="YDisplacement_{unit}", channel="YDisplacement", unit="um", form=".0f"),
        Column(name="XForce_{unit}", channel="XForce", unit="mN", form=".2f"),
        Column(name="YForce_{unit}", channel="YForce", unit="mN", form=".2f"),
    ),
)


def cycle_text(cycle: int, phase: Phase) -> str:
    """Return the text of the ``Cycle`` column.

    Examples
    --------
    >>> cycle_text(1, "Stretch")
    '1-Stretch'
    """
    return f"{max(cycle, 1)}-{'Preload' if phase == 'Zero' else phase}"


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather what the BioTester's columns show: x is the course, y the wale; the sample's name where a step has none.

    Returns
    -------
    iterator of dict of str to sequence, each of length n
        Numbers in SI units (temperature in °C) and texts, part by part.
    dict
        No facts.
    """
    return (_shown(test, samples) for samples in parts_of(test.samples["biaxial-hook"])), {}


def _shown(test: Logged, samples: Samples) -> Channels:
    x, y = samples.measured["XDisplacement"], samples.measured["YDisplacement"]
    return {
        "SetName": [tag or test.sample for tag in samples.tag],
        "Cycle": [cycle_text(int(cycle), phase) for cycle, phase in zip(samples.cycle, samples.phase, strict=True)],
        "Time": samples.time.tolist(),
        "Temperature": [test.number("rig.convention.temperature")] * len(samples.time),
        # Zeroing moves the displacement's origin; it does not change the distance between the hooks.
        "XSize": (test.size.extents["C"] + x + samples.offset["XDisplacement"]).tolist(),
        "YSize": (test.size.extents["W"] + y + samples.offset["YDisplacement"]).tolist(),
        "XDisplacement": x.tolist(),
        "YDisplacement": y.tolist(),
        "XForce": samples.measured["XForce"].tolist(),
        "YForce": samples.measured["YForce"].tolist(),
        **pin_channels(samples),
    }


LOG: Final = Log(
    dialect=DIALECT,
    machines=("biaxial-hook",),
    place="{sample}.csv",
    gather=gather,
    pins=Column(name="Extensometer{axis}_{unit}", channel="", unit="um", form=".0f"),
    about="the biaxial stage's, as CellScale's BioTester",
)
