"""Export of a run's log in the dialect of an instrument; it is computed from ``run.h5`` and can be repeated."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from app.extensions import load_extensions
from app.file_names import file_stem
from app.records.folder import write_whole
from app.records.measurements import zeroings_of
from app.records.reader import read_run
from app.records.sampled import samples_of
from knitlab_core.errors import SpecificationError
from rigs.logs.catalogue import LOGS, defaults
from rigs.logs.locales import localised
from rigs.logs.logged import Logged
from rigs.logs.units import in_units
from rigs.logs.writer import write_log
from rigs.protocol.bounds import require_label

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from app.records.reader import RunReader
    from rigs.instruments.samples import Table
    from rigs.logs.logged import Log


def export_run(
    place: Path, *, dialect: str | None = None, locale: str = "en", units: str | None = None, out: Path | None = None
) -> tuple[Path, ...]:
    """Write the logs of a run, in its own or in chosen dialects.

    Parameters
    ----------
    place : Path
        Its folder, or its ``run.h5``.
    dialect : str or None
        One of `LOGS`; None for those that its machines write.
    locale : str
        Language of the country whose numbers and dates are written.
    units : str or None
        Units other than the dialect's, ``force=mN,length=um``.
    out : Path or None
        Where to; None for beside the record.

    Returns
    -------
    tuple of Path
        The files.

    Raises
    ------
    FileNotFoundError, FormatError
        If there is no record of a run.
    SpecificationError
        As `export_log`.
    """
    load_extensions()
    run = read_run(place)
    folder = run.path.parent if out is None else out
    wanted = _units(units)
    with samples_of(run) as samples:
        names = defaults(samples) if dialect is None else [dialect]
        if not names:
            raise SpecificationError("run.equilibria", "none", "a run with a row or more")
        return tuple(_export(run, samples, folder, name, locale=locale, units=wanted) for name in names)


def _units(text: str | None) -> dict[str, str]:
    """Parse units by quantity, as ``force=mN,length=um`` gives them."""
    wanted = {}
    for part in [] if text is None else text.split(","):
        quantity, equals, unit = part.strip().partition("=")
        if not equals:
            raise SpecificationError("units", part, "quantity=unit, such as force=mN,length=um")
        wanted[quantity] = unit
    return wanted


def export_logs(run: RunReader, folder: Path) -> tuple[Path, ...]:
    """Write the log of every instrument of a run in its own dialect, under the instrument's file names."""
    with samples_of(run) as samples:
        return tuple(_export(run, samples, folder, dialect) for dialect in defaults(samples))


def export_log(
    run: RunReader, folder: Path, dialect: str, *, locale: str = "en", units: Mapping[str, str] | None = None
) -> Path:
    """Write the log of one instrument of a run, at the path where the instrument would write it.

    Parameters
    ----------
    run : RunReader
        The run.
    folder : Path
        Folder for the instrument's own folders and files; made if it is not there.
    dialect : str
        One of `LOGS`.
    locale : str
        Language of the country whose numbers and dates are written.
    units : mapping of str to str
        Units other than the dialect's, by quantity.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    SpecificationError
        If dialect, locale or units are unknown, or the run has no log of the dialect's machine: it has no row, or the
        machine was no part of its rig.
    """
    load_extensions()
    with samples_of(run) as samples:
        return _export(run, samples, folder, dialect, locale=locale, units=units)


def _export(
    run: RunReader,
    samples: Mapping[str, Table],
    folder: Path,
    dialect: str,
    *,
    locale: str = "en",
    units: Mapping[str, str] | None = None,
) -> Path:
    """Write the log of one instrument from the samples of a run's instruments, as `export_log` does."""
    if dialect not in LOGS:
        raise SpecificationError("dialect", dialect, f"one of {', '.join(LOGS)}")
    log = LOGS[dialect]
    for machine in log.machines:
        if machine not in samples:
            found = ", ".join(samples) or "none"
            raise SpecificationError("run.channels", found, f"a run on {machine}")
    test = replace(logged(run), samples=samples)
    shown = localised(in_units(log.shown(test), {} if units is None else units), locale)
    path = folder / log.place.format(sample=file_stem(test.sample))
    path.parent.mkdir(parents=True, exist_ok=True)
    return _written(replace(log, dialect=shown), test, path)


def _written(log: Log, test: Logged, path: Path) -> Path:
    parts, facts = log.gather(test)
    if log.kind == "sheet":
        from rigs.logs.sheet import write_sheet  # noqa: PLC0415 (few instruments write workbooks)

        return write_whole(path, [write_sheet(log.dialect, parts, test.start())])
    return write_whole(path, write_log(log.dialect, parts, facts))


def logged(run: RunReader) -> Logged:
    """Return the data of a run that its logs are written from.

    Raises
    ------
    SpecificationError
        If its name or a tag is no label, for a log shows them as they are.
    """
    sample = str(run.provenance.get("name", "knitlab"))
    require_label("run.name", sample)
    for tag in run.tags:
        require_label("run.tags", tag)
    return Logged(
        sample=sample, size=run.size, samples=run.logs, facts=run.provenance, zeroings=tuple(zeroings_of(run))
    )
