"""Shapes of a run as VTKHDF: a PolyData with time steps, which ParaView and VTK open.

The yarn's edges are lines, listed once and shared by all steps. Every step appends `rows` to each growing dataset and
is counted last, so that a file that was cut off anywhere holds whole steps.

References
----------
"VTKHDF format specification", docs.vtk.org, version 2.3: Poly data; Temporal data.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import h5py
import numpy as np

from rigs.axes import AXES
from rigs.record import PHASES, Frame

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigs.axes import Axis, FloatArray

GROUP: Final = "VTKHDF"
VERSION: Final = (2, 3)
#: Of the kinds of cells that a PolyData has, in the order of its offsets, the second is in use.
KINDS: Final = ("Vertices", "Lines", "Polygons", "Strips")
#: Steps that one stretch of a column holds.
CHUNK: Final = 256
NO_IMAGE: Final = -1
#: Both ends of every wire, one after the other.
WIRES: Final = "FieldData/wires"
TIMES: Final = "Steps/Values"


def make_frames(file: h5py.File, axes: Sequence[Axis], strands: Sequence[int], wires: int = 0) -> None:
    """Create the group of a knit without time steps.

    Parameters
    ----------
    file : h5py.File
        The record of a run.
    axes : sequence of Axis
        The axes that are driven.
    strands : sequence of int
        Nodes of every strand.
    wires : int
        Wires that the knit hangs on.
    """
    group = file.create_group(GROUP)
    group.attrs["Version"] = np.array(VERSION, dtype=np.int64)
    group.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", 8))
    first = np.delete(np.arange(sum(strands) - 1), np.cumsum(strands)[:-1] - 1)
    lines = np.column_stack([first, first + 1])
    group["NumberOfPoints"] = np.array([sum(strands)], dtype=np.int64)
    for kind in KINDS:
        cells = lines if kind == "Lines" else lines[:0]
        group[f"{kind}/NumberOfCells"] = np.array([len(cells)], dtype=np.int64)
        group[f"{kind}/NumberOfConnectivityIds"] = np.array([cells.size], dtype=np.int64)
        group[f"{kind}/Connectivity"] = cells.ravel()
        group[f"{kind}/Offsets"] = 2 * np.arange(len(cells) + 1, dtype=np.int64)
    nodes, edges = sum(strands), len(lines)
    _grow(group, "Points", (nodes, 3), "f8", "m")
    # Values that only colour lines need single precision.
    _grow(group, "CellData/axial_strain", (edges,), "f4", "1")
    _grow(group, "CellData/bending_strain", (edges,), "f4", "1")
    _grow(group, "PointData/contact_force", (nodes,), "f4", "N")
    for axis in axes:
        _grow(group, f"FieldData/strain_{axis}", (1,), "f8", "1")
    for name, dtype in (("cycle", "i8"), ("phase", "i4"), ("image", "i4")):
        _grow(group, f"FieldData/{name}", (1,), dtype, "1")
    if wires:
        _grow(group, WIRES, (wires, 6), "f8", "m")
    group["FieldData/phase"].attrs["meaning"] = ", ".join(PHASES)
    group["FieldData/image"].attrs["meaning"] = f"index in /tags; {NO_IMAGE} where no image was taken"
    _make_steps(group)


def _make_steps(group: h5py.Group) -> None:
    """Create the table of offsets of each time step."""
    group.create_group("Steps").attrs["NSteps"] = 0
    _grow(group, TIMES, (1,), "f8", "s")
    for name in ("NumberOfParts", "PartOffsets", "PointOffsets"):
        _grow(group, f"Steps/{name}", (1,), "i8")
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        _grow(group, f"Steps/{name}", (1, len(KINDS)), "i8")
    for data in ("PointData", "CellData", "FieldData"):
        for name in group[data]:
            _grow(group, f"Steps/{data}Offsets/{name}", (1,), "i8")
    for name in group["FieldData"]:
        _grow(group, f"Steps/FieldDataSizes/{name}", (1, 2), "i8")


def _grow(group: h5py.Group, name: str, shape: tuple[int, ...], dtype: str, unit: str | None = None) -> None:
    """Create an empty dataset that grows by rows with every time step."""
    rows, *tail = shape
    chunk = rows if rows > 1 else CHUNK
    # Where a step fills a chunk it is written once, and may carry HDF5's own checksum.
    made = group.create_dataset(
        name, shape=(0, *tail), maxshape=(None, *tail), chunks=(chunk, *tail), dtype=dtype, fletcher32=rows > 1
    )
    made.attrs["rows"] = rows
    if unit is not None:
        made.attrs["units"] = unit


def growing(group: h5py.Group) -> dict[str, h5py.Dataset]:
    """Return the datasets that grow with every time step; their attribute `rows` counts the rows."""
    found: dict[str, h5py.Dataset] = {}

    def look(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset) and "rows" in item.attrs:
            found[name] = item

    group.visititems(look)
    return found


class FrameWriter:
    """Writer of a record's time steps, whose datasets it looks up once.

    Parameters
    ----------
    file : h5py.File
        The record of a run.
    """

    def __init__(self, file: h5py.File) -> None:
        self._file, self._group = file, file[GROUP]
        self._columns = growing(self._group)
        self._times = self._columns.pop(TIMES)
        self._rows = {name: int(dataset.attrs["rows"]) for name, dataset in self._columns.items()}
        # An entry in the table of steps: a value, and by how much it rises from step to step.
        self._places = {name: self._place(name) for name in self._columns if name.startswith("Steps/")}
        self._steps = int(self._group["Steps"].attrs["NSteps"])

    def append(self, frame: Frame, image: int) -> None:
        """Append a time step.

        Parameters
        ----------
        frame : Frame
            The shape.
        image : int
            Index of the image's name in ``/tags``; `NO_IMAGE` where none is taken.
        """
        step = self._steps
        values: dict[str, object] = {
            "Points": frame.nodes,
            "CellData/axial_strain": frame.axial_strain,
            "CellData/bending_strain": frame.bending_strain,
            "PointData/contact_force": frame.contact_force,
            **{f"FieldData/strain_{axis}": strain for axis, strain in frame.strain.items()},
            "FieldData/cycle": frame.cycle,
            "FieldData/phase": PHASES.index(frame.phase),
            "FieldData/image": image,
            WIRES: frame.wires.reshape(-1, 6),
            **{name: np.array(start) + step * rise for name, (start, rise) in self._places.items()},
            "Steps/PointOffsets": step * len(frame.nodes),
        }
        for name, dataset in self._columns.items():
            _append(dataset, step, self._rows[name], values[name])
        # Data first: a step that is counted is there. VTK breaks down where there are more times than steps.
        self._file.flush()
        _append(self._times, step, 1, frame.time)
        self._group["Steps"].attrs.modify("NSteps", step + 1)
        self._file.flush()
        self._steps = step + 1

    def _place(self, name: str) -> tuple[tuple[int, ...] | int, int]:
        """Return the offset of step 0 in an array, or the size of its field, and the rise per step.

        Lines and parts are those of step 0.
        """
        _, table, *array = name.split("/")
        if table == "FieldDataSizes":
            field = f"FieldData/{array[0]}"
            return (int(np.prod(self._columns[field].shape[1:])), self._rows[field]), 0
        if table in {"PointDataOffsets", "CellDataOffsets", "FieldDataOffsets"}:
            return 0, self._rows[f"{table.removesuffix('Offsets')}/{array[0]}"]
        return int(table == "NumberOfParts"), 0


def _append(dataset: h5py.Dataset, step: int, rows: int, values: object) -> None:
    """Write the rows of a time step through HDF5's low-level interface, which is faster than h5py's indexing."""
    begin, shape = step * rows, (rows, *dataset.shape[1:])
    column = dataset.id
    column.set_extent((begin + rows, *shape[1:]))
    place = column.get_space()
    place.select_hyperslab((begin, *(0,) * (len(shape) - 1)), shape)
    numbers = np.ascontiguousarray(np.broadcast_to(np.asarray(values, dtype=dataset.dtype), shape))
    column.write(h5py.h5s.create_simple(shape), place, numbers)


def count_frames(file: h5py.File) -> int:
    """Return the number of complete time steps."""
    group = file[GROUP]
    whole = (len(dataset) // int(dataset.attrs["rows"]) for dataset in growing(group).values())
    return min(int(group["Steps"].attrs["NSteps"]), *whole)


def read_frames(file: h5py.File, tags: Sequence[str]) -> tuple[Frame, ...]:
    """Return the shapes of a run in the order of time."""
    columns = growing(file[GROUP])
    return tuple(_frame_of(columns, step, tags) for step in range(count_frames(file)))


def read_frame(file: h5py.File, step: int, tags: Sequence[str]) -> Frame:
    """Return the shape at one time step; `tags` are the names in ``/tags``."""
    return _frame_of(growing(file[GROUP]), step, tags)


def _frame_of(columns: Mapping[str, h5py.Dataset], step: int, tags: Sequence[str]) -> Frame:
    """Return the shape at one time step from the growing datasets."""

    def part(name: str) -> FloatArray:
        rows = int(columns[name].attrs["rows"])
        return np.asarray(columns[name][step * rows : (step + 1) * rows], dtype=np.float64)

    return _frame(part, set(columns), tags)


def _frame(part: Callable[[str], FloatArray], names: set[str], tags: Sequence[str]) -> Frame:
    """Return the frame whose arrays `part` gives."""
    image = int(part("FieldData/image")[0])
    return Frame(
        time=float(part(TIMES)[0]),
        nodes=part("Points"),
        axial_strain=part("CellData/axial_strain"),
        bending_strain=part("CellData/bending_strain"),
        contact_force=part("PointData/contact_force"),
        strain={
            axis: float(part(f"FieldData/strain_{axis}")[0]) for axis in AXES if f"FieldData/strain_{axis}" in names
        },
        cycle=int(part("FieldData/cycle")[0]),
        phase=PHASES[int(part("FieldData/phase")[0])],
        image=tags[image] if 0 <= image < len(tags) else None,
        wires=part(WIRES).reshape(-1, 2, 3) if WIRES in names else np.zeros((0, 2, 3)),
    )
