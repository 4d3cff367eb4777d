"""The log of an Alemnis indenter: a workbook of one sheet, or the same as text between tabs.

Documented, by readers that laboratories publish: one line of headings, that readers replace by their own; eight
columns, a time before each of corrected displacement, corrected load, raw displacement and raw load; times of
displacement and of load that differ; times before the test negative texts, ``-00:00:06.135``; values in m and N as
texts with an SI prefix (p, n, u, m), or as plain numbers; readers drop repeated times.

Assumed: the headings' words; all times are texts, to the millisecond, of samples a millisecond apart or more; six
digits of a value, without the zeros that end them; a value of 0 or from 1 on is a number, for not every reader knows a
text without prefix; the log begins some seconds before the test. Raw is what the sensors show, before any zeroing;
corrected is zeroed, and the displacement less the load times the compliance of the machine's frame.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from rigs.instruments.samples import around, parts_of
from rigs.instruments.signals import stamps
from rigs.jumps import joined
from rigs.logs.dialect import Column, Dialect
from rigs.logs.logged import Log, pin_names

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigs.axes import FloatArray
    from rigs.instruments.samples import Table
    from rigs.logs.dialect import Channels
    from rigs.logs.logged import Facts, Logged

MACHINE: Final = "nanoindenter"
PREFIXES: Final = (("m", 1e-3), ("u", 1e-6), ("n", 1e-9), ("p", 1e-12))
DIGITS: Final = 6

_ON_SHEET: Final = Dialect(
    name="alemnis",
    columns=(
        Column(name="Time", channel="Displacement time"),
        Column(name="Corrected Displacement", channel="Corrected displacement"),
        Column(name="Time", channel="Load time"),
        Column(name="Corrected Load", channel="Corrected load"),
        Column(name="Time", channel="Displacement time"),
        Column(name="Raw Displacement", channel="Raw displacement"),
        Column(name="Time", channel="Load time"),
        Column(name="Raw Load", channel="Raw load"),
    ),
    delimiter="\t",
)
PINS: Final = Column(name="Extensometer {axis}", channel="")
"""Read with the displacement; no reader of published files expects it, so it comes last."""
DIALECT: Final = replace(_ON_SHEET, name="alemnis-tsv")


def prefixed(value: float) -> str | float:
    """Return a value as text with an SI prefix; 0 and what is not below 1 as a number.

    Examples
    --------
    >>> prefixed(655e-9), prefixed(-1.42e-3), prefixed(0.0), prefixed(2.5)
    ('655n', '-1.42m', 0, 2.5)
    """
    short = float(f"{value:.{DIGITS}g}")
    if abs(short) >= 1.0:
        return short
    for prefix, size in PREFIXES:
        if abs(short) >= size * (1.0 - 0.5 * 10.0**-DIGITS):
            return f"{short / size:.{DIGITS}g}{prefix}"
    smallest, size = PREFIXES[-1]
    text = f"{short / size:.3f}".rstrip("0").rstrip(".")
    return 0 if float(text) == 0.0 else text + smallest


def clock_text(time: float) -> str:
    """Return a time as hours, minutes, seconds and milliseconds.

    Examples
    --------
    >>> clock_text(-6.135), clock_text(3661.5)
    ('-00:00:06.135', '01:01:01.500')
    """
    thousandths = round(abs(time) * 1e3)
    seconds, rest = divmod(thousandths, 1000)
    sign = "-" if time < 0.0 and thousandths else ""
    return f"{sign}{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}.{rest:03d}"


def _stamps(time: FloatArray, before: str) -> tuple[list[str], list[bool]]:
    """Return times as texts, and which of them are not the text before."""
    texts = [clock_text(float(one)) for one in time]
    return texts, [text != last for last, text in pairwise([before, *texts])]


def gather(test: Logged) -> tuple[Iterator[Channels], Facts]:
    """Gather what the indenter's columns show, texts and numbers.

    Returns
    -------
    iterator of dict of str to sequence, each of length n
        Lines on which the time of displacement or of load would be repeated are left out.
    dict
        No facts.
    """
    return _lines(test.samples[MACHINE], test.number("rig.carriage.compliance")), {}


def _lines(table: Table, compliance: float) -> Iterator[Channels]:
    """Yield the lines part by part; the compliance of the machine's frame [m/N] is taken off the displacement."""
    time = load_time = ""
    for samples in parts_of(table):
        travel, load = samples.measured["Displacement"], samples.measured["Force"]
        late, load_late = (samples.time + samples.delay.get(name, 0.0) for name in ("Displacement", "Force"))
        carried = _load_at(table, late, samples.delay.get("Force", 0.0))
        values = {
            "Corrected displacement": travel - compliance * carried,
            "Corrected load": load,
            "Raw displacement": travel + samples.offset["Displacement"],
            "Raw load": load + samples.offset["Force"],
            **{name: samples.measured[name] for name in pin_names(samples)},
        }
        times, fresh = _stamps(late, time)
        load_times, load_fresh = _stamps(load_late, load_time)
        time, load_time = times[-1], load_times[-1]
        kept = [k for k, new in enumerate(fresh) if new and load_fresh[k]]
        channels: dict[str, list[object]] = {
            "Displacement time": [times[k] for k in kept],
            "Load time": [load_times[k] for k in kept],
        }
        yield channels | {name: [prefixed(float(column[k])) for k in kept] for name, column in values.items()}


def _load_at(table: Table, stamp: FloatArray, delay: float) -> FloatArray:
    """Return the load [N] at some stamps [s]: between its own readings, which are late by a delay [s], linear."""
    near = around(table, float(stamp[0]) - delay, float(stamp[-1]) - delay)
    jumps = stamps(near.jumps, near.clock_offset, near.clock_skew)
    return joined(stamp, near.time + delay, near.measured["Force"], jumps)


LOG: Final = Log(
    dialect=_ON_SHEET,
    machines=(MACHINE,),
    place="{sample}.xlsx",
    gather=gather,
    pins=PINS,
    about="the nanoindenter's workbook, as Alemnis'",
    kind="sheet",
)
AS_TEXT: Final = Log(
    dialect=DIALECT,
    machines=(MACHINE,),
    place="{sample}.tsv",
    gather=gather,
    pins=PINS,
    about="the same columns as text between tabs",
)
