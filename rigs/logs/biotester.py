"""Describe the log of CellScale's BioTester, the dialect of the biaxial stage.

Documented, by the ``OutputColumns`` line of the instrument's own test templates and by the readers
that laboratories publish: the ten headings and their order; µm, mN, s and °C; size as the current
grip-to-grip distance, of which the first row is the reference; ``Cycle`` as number, hyphen, phase.

Assumed, for want of a file of the instrument itself: CRLF ends and no byte-order mark (it is a
Windows program); whole µm, time to 1 ms, force to 0.01 mN, temperature to 0.1 °C; ``SetName``
unquoted unless it holds a comma; the rows logged while channels are zeroed count as ``Preload``,
so that the first row, the reference, is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigs.logs.writer import Column, Dialect

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.instruments import Samples
    from rigs.record import Phase, SpecimenSize

BIOTESTER = Dialect(
    name="biotester",
    columns=(
        Column(name="SetName", channel="SetName"),
        Column(name="Cycle", channel="Cycle"),
        Column(name="Time_S", channel="Time", form=".3f"),
        Column(name="Temperature", channel="Temperature", form=".1f"),
        Column(name="XSize_um", channel="XSize", scale=1e6, form=".0f"),
        Column(name="YSize_um", channel="YSize", scale=1e6, form=".0f"),
        Column(name="XDisplacement_um", channel="XDisplacement", scale=1e6, form=".0f"),
        Column(name="YDisplacement_um", channel="YDisplacement", scale=1e6, form=".0f"),
        Column(name="XForce_mN", channel="XForce", scale=1e3, form=".2f"),
        Column(name="YForce_mN", channel="YForce", scale=1e3, form=".2f"),
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


def biotester_channels(
    samples: Samples, size: SpecimenSize, *, set_name: str, temperature: float
) -> dict[str, Sequence[object]]:
    """Gather what the BioTester's columns show.

    Parameters
    ----------
    samples : Samples
        The stage's log; its x is the course and its y the wale.
    size : SpecimenSize
        Gives the initial hook-to-hook distances [m].
    set_name : str
        Name of the set where a step has no label of its own.
    temperature : float
        Temperature of the bath or the room [°C]; nothing in the model depends on it.

    Returns
    -------
    dict of str to sequence, each of length n
        Numbers in SI units (temperature in °C) and texts, for `rigs.logs.writer.write_log`.
    """
    x, y = samples.measured["XDisplacement"], samples.measured["YDisplacement"]
    # Zeroing moves the displacement's origin; it does not change the distance between the hooks.
    x_size = size.extents["C"] + x + samples.offset["XDisplacement"]
    y_size = size.extents["W"] + y + samples.offset["YDisplacement"]
    return {
        "SetName": [tag or set_name for tag in samples.tag],
        "Cycle": [cycle_text(int(cycle), phase) for cycle, phase in zip(samples.cycle, samples.phase, strict=True)],
        "Time": samples.time.tolist(),
        "Temperature": [temperature] * len(samples.time),
        "XSize": x_size.tolist(),
        "YSize": y_size.tolist(),
        "XDisplacement": x.tolist(),
        "YDisplacement": y.tolist(),
        "XForce": samples.measured["XForce"].tolist(),
        "YForce": samples.measured["YForce"].tolist(),
    }
