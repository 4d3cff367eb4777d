"""Layout of ``run.h5``: datasets, their units, and the lengths of those that grow."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, get_args

import h5py
import numpy as np

from app.records.folder import whole_file
from app.records.h5_read import reading
from app.records.row_checksum import CHECKSUM
from app.records.staged_file import new_hdf5
from app.records.vtkhdf import make_frames
from rigs.analysis.clasps import COLUMN
from rigs.protocol.bounds import LONGEST_LABEL
from rigs.protocol.targets import Channel
from rigs.record import ENDS, PHASES, units

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from rigs.analysis.clasps import ClaspLoss
    from rigs.analysis.material_limits import MaterialLimit
    from rigs.axes import Axis, IntArray
    from rigs.instruments.channels import Instrument
    from rigs.record import SpecimenSize

#: Rows that one stretch of the file holds; a new one is needed only so often.
CHUNK = 4096
#: Samples are written at the end of a run, many at a time, and much in them is the same again.
PACKED: Mapping[str, object] = MappingProxyType(
    {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
)
#: Rises whenever a reader of the last layout would not find what it looks for.
LAYOUT = 4
RUNNING = "running"
#: Row at which a limit of the material was passed that was not.
NOT_PASSED = -1
#: Place of the first row of the zeros, and the kinds of channels that a zero may set.
AS_PRINTED = "as printed"
KINDS: tuple[Channel, ...] = get_args(Channel)
#: Load plates, in their order along the pile.
PLATES = ("lower", "upper")
TEXT = h5py.string_dtype("utf-8", length=64)
#: Bytes of the longest label, in letters of four bytes each.
TAG_BYTES = 4 * LONGEST_LABEL
TAG = h5py.string_dtype("utf-8", length=TAG_BYTES)
END = h5py.string_dtype("utf-8", length=16)
PLACE = h5py.string_dtype("utf-8", length=256)
MESSAGE = h5py.string_dtype("utf-8", length=1024)
UNFINISHED = ("iterations", "factorisations", "seconds")
_WHOLE = frozenset({"contacts", "iterations", "factorisations", "cycle", "bonds_whole", "bonds_broken", "step"})
#: Attributes that count what has been written.
_COUNTS = ("NSteps",)


def make_record(  # noqa: PLR0913 (each is a part of the record)
    path: Path,
    *,
    protocol: str,
    size: SpecimenSize,
    axes: Sequence[Axis],
    strands: Sequence[int],
    instruments: Sequence[Instrument],
    provenance: Mapping[str, str | int | float],
    materials: str = "",
    plates: tuple[IntArray, IntArray] | None = None,
    wires: int = 0,
    limits: Sequence[MaterialLimit] = (),
    clasps: Iterable[str] = (),
    cell: Iterable[str] = (),
    fixtures: Iterable[str] = (),
    pins: Iterable[Axis] = (),
    let_go: Iterable[ClaspLoss] = (),
) -> Path:
    """Create the record of a run without rows, atomically.

    Parameters
    ----------
    path : Path
        The file, ``run.h5``; an older one is replaced.
    protocol : str
        The protocol's YAML, verbatim.
    size : SpecimenSize
        Extents and fibre radius.
    axes : sequence of Axis
        The axes that are driven.
    strands : sequence of int
        Nodes of every strand, N in all.
    instruments : sequence of Instrument
        Their channels.
    provenance : mapping of str to (str, int or float)
        Versions, seed, rig, material values with their sources.
    materials : str
        The YAML of the materials that the protocol brings in a file of its own, verbatim.
    plates : tuple of IntArray or None
        Nodes in the lower and in the upper load plate; None where hooks hold the specimen.
    wires : int
        Wires that the knit hangs on.
    limits : sequence of MaterialLimit
        Limits of the material whose first crossing the record names.
    clasps : iterable of str
        What the knit's clasps join, ``rows`` or ``layers``; empty where they are unknown.
    cell : iterable of str
        Components of a periodic cell's vectors that rows have, ``C``, ``WC``; empty for a specimen with edges.
    fixtures : iterable of str
        Forces of clamps or plates that rows have, ``W+_C``; empty where hooks hold the knit.
    pins : iterable of Axis
        Axes along which an extensometer measures.
    let_go : iterable of ClaspLoss
        Clasps that the knit lost before its test.

    Returns
    -------
    Path
        The same path.
    """
    facts = {
        "layout": LAYOUT,
        "fibre_radius": size.fibre_radius,
        **{f"extent_{axis}": extent for axis, extent in size.extents.items()},
        "thickness_convention": size.convention,
    }
    with whole_file(path) as made, new_hdf5(made) as file:
        file.create_dataset("protocol", data=protocol, dtype=h5py.string_dtype("utf-8"))
        file.create_dataset("materials", data=materials, dtype=h5py.string_dtype("utf-8"))
        file.create_dataset("strands", data=np.array(strands, dtype=np.int64))
        file.create_dataset("tags", shape=(0,), maxshape=(None,), chunks=(64,), dtype=TAG)
        file.attrs.update({**provenance, **facts})
        _make_equilibria(file, units(axes, clasps, cell, fixtures, pins))
        for loss in let_go:
            facts_of_loss = {"laid": loss.mounted, "let_go": loss.places, "let_go_count": loss.lost}
            file[f"equilibria/{COLUMN}{loss.joined}"].attrs.update(facts_of_loss)
        for name, nodes in zip(PLATES, plates or (), strict=False):
            file.create_dataset(f"plates/{name}", data=nodes)
        make_frames(file, axes, strands, wires)
        _make_steps(file)
        _make_zeros(file, axes, size)
        _make_limits(file, limits, axes)
        file.create_group("channels")
        for instrument in instruments:
            _make_channels(file, instrument)
        outcome = file.create_group("outcome")
        outcome.attrs.create("end", RUNNING, dtype=END)
        outcome.attrs.create("message", "", dtype=MESSAGE)
        for name in UNFINISHED:
            outcome.attrs.create(name, 0.0)
    return path


def lengths(file: h5py.File) -> dict[str, int]:
    """Return the lengths of all growing datasets by name, and counters in attributes as ``group@count``."""
    found: dict[str, int] = {}

    def look(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Group):
            found.update({f"{name}@{count}": int(item.attrs[count]) for count in _COUNTS if count in item.attrs})
        elif item.maxshape[:1] == (None,):
            found[name] = item.shape[0]

    file.visititems(look)
    return found


def reaches(path: Path, wanted: Mapping[str, int]) -> bool:
    """Return whether a record has at least given lengths."""
    with reading(path, "the record of a run") as file:
        found = lengths(file)
    return all(found.get(name, 0) >= length for name, length in wanted.items())


def cut(file: h5py.File, wanted: Mapping[str, int]) -> None:
    """Truncate growing datasets to given lengths, dropping what was written later."""
    for name in lengths(file):
        place, _, count = name.partition("@")
        if count:
            file[place].attrs[count] = wanted.get(name, 0)
        else:
            file[place].resize(wanted.get(name, 0), axis=0)


def _column(
    group: h5py.Group, name: str, dtype: object, unit: str | None = None, packing: Mapping[str, object] | None = None
) -> None:
    dataset = group.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(CHUNK,), dtype=dtype, **(packing or {}))
    if unit is not None:
        dataset.attrs["units"] = unit


def _phase_and_tag(table: h5py.Group, packing: Mapping[str, object] | None = None) -> None:
    _column(table, "phase", "i1", packing=packing)
    table["phase"].attrs["meaning"] = ", ".join(PHASES)
    _column(table, "tag", "i4", packing=packing)


def _make_equilibria(file: h5py.File, columns: Mapping[str, str]) -> None:
    table = file.create_group("equilibria")
    for name, unit in columns.items():
        _column(table, name, "i8" if name in _WHOLE or name.startswith(COLUMN) else "f8", unit)
    _phase_and_tag(table)
    _column(table, CHECKSUM, "u4")
    table[CHECKSUM].attrs["meaning"] = "CRC-32 of the row; see app/records/row_checksum.py"


def _make_steps(file: h5py.File) -> None:
    steps = file.create_group("steps")
    for name, dtype, unit in (
        ("place", PLACE, None),
        ("tag", "i4", None),
        ("start", "f8", "s"),
        ("time", "f8", "s"),
        ("end", "i1", None),
        ("message", MESSAGE, None),
    ):
        _column(steps, name, dtype, unit)
    steps["end"].attrs["meaning"] = ", ".join(ENDS)


def _make_zeros(file: h5py.File, axes: Sequence[Axis], size: SpecimenSize) -> None:
    """Create the table of zeros; its first row is that of the specimen as printed, at which nothing was zeroed."""
    zeros = file.create_group("zeros")
    values: dict[str, tuple[object, object, str | None]] = {
        "place": (PLACE, AS_PRINTED, None),
        "time": ("f8", 0.0, "s"),
        **{f"zeroed_{kind}": ("i1", 0, None) for kind in KINDS},
        **{f"travel_{axis}": ("f8", 0.0, "m") for axis in axes},
        **{f"force_{axis}": ("f8", 0.0, "N") for axis in axes},
        **{f"gauge_length_{axis}": ("f8", size.gauge(axis), "m") for axis in axes},
    }
    for name, (dtype, value, unit) in values.items():
        _column(zeros, name, dtype, unit)
        zeros[name].resize(1, axis=0)
        zeros[name][0] = value


def _make_limits(file: h5py.File, limits: Sequence[MaterialLimit], axes: Sequence[Axis]) -> None:
    """Create the table of material limits; row -1 and nan mean that a limit is not passed."""
    group, count = file.create_group("limits"), len(limits)
    text = h5py.string_dtype("utf-8")
    group.create_dataset("name", data=[limit.name for limit in limits], shape=(count,), dtype=text)
    group.create_dataset("text", data=[limit.text for limit in limits], shape=(count,), dtype=text)
    group.create_dataset("limit", data=np.array([limit.strain for limit in limits], dtype=np.float64))
    group.create_dataset("row", data=np.full(count, NOT_PASSED, dtype=np.int64))
    for name in ("time", "fibre_strain", *(f"strain_{axis}" for axis in axes)):
        group.create_dataset(name, data=np.full(count, np.nan))
    for name in set(group) - {"name", "text"}:
        group[name].attrs["units"] = "s" if name == "time" else "1"


def _make_channels(file: h5py.File, instrument: Instrument) -> None:
    table = file["channels"].create_group(instrument.name)
    _column(table, "Time", "f8", "s", packing=PACKED)
    _column(table, "cycle", "i8", packing=PACKED)
    table.attrs.update({"clock_offset": instrument.offset, "clock_skew": instrument.skew})
    for kind in ("clean", "offset"):
        table.create_group(kind)
    for channel in instrument.channels:
        for place in (table, table["clean"], table["offset"]):
            _column(place, channel.name, "f8", channel.unit, packing=PACKED)
        table[channel.name].attrs.update({"reads": channel.reads, "delay": channel.delay})
    table.create_dataset("overloads", shape=(0,), maxshape=(None,), chunks=(64,), dtype=TEXT)
    _phase_and_tag(table, PACKED)
