"""The shapes of a run as VTK's own reader finds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import h5py
import numpy as np
import pytest

from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.vtkhdf import growing
from app.records.writer import RunWriter
from rigs.record import Frame, Phase
from tests.synthetic_run import BOTH, SIZE, make_run, row, stage_instrument

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import FloatArray

STRANDS = (5, 7)

vtk = pytest.importorskip("vtkmodules.vtkIOHDF", reason="needs the extra 'test'")
numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")


def two_strands(k: int, phase: Phase = "Stretch", image: str | None = None) -> Frame:
    """Return a made-up shape of two strands, a broken edge in the second from step 3 on."""
    count = sum(STRANDS)
    random = np.random.default_rng(k)
    strained = random.normal(size=count - 2)
    if k >= 3:
        strained[6] = np.nan
    return Frame(
        time=0.7 * k,
        nodes=random.normal(size=(count, 3)),
        axial_strain=strained,
        bending_strain=np.abs(strained),
        contact_force=random.random(count),
        strain={"C": 0.02 * k, "W": 0.01 * k},
        cycle=1 + k // 4,
        phase=phase,
        image=image,
    )


def write(path: Path, frames: list[Frame]) -> None:
    with RunWriter(
        make_record(
            path,
            protocol="",
            size=SIZE,
            axes=BOTH,
            strands=STRANDS,
            instruments=[stage_instrument()],
            provenance={},
        )
    ) as writer:
        writer.append(row(0.0, 0.0, 1, "Zero"))
        for one in frames:
            writer.add_frame(one)


def numbers(of: object) -> FloatArray:
    """Return the numbers of one of VTK's arrays."""
    return numpy_support.vtk_to_numpy(of)  # type: ignore[no-any-return]


def test_vtk_reads_every_step_as_it_was_recorded(tmp_path: Path) -> None:
    given = [two_strands(k) for k in range(7)]
    write(tmp_path / "run.h5", given)
    reader = vtk.vtkHDFReader()
    assert reader.CanReadFile(str(tmp_path / "run.h5"))
    reader.SetFileName(str(tmp_path / "run.h5"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 7
    pairs = [[k, k + 1] for k in range(11) if k != 4]
    # Back and forth, as someone who scrubs does.
    for k in (0, 1, 2, 3, 4, 5, 6, 2, 5, 0):
        reader.UpdateTimeStep(given[k].time)
        data = reader.GetOutputDataObject(0)
        assert reader.GetTimeValue() == given[k].time
        assert numbers(data.GetPoints().GetData()).tolist() == given[k].nodes.tolist()
        assert (data.GetNumberOfCells(), data.GetNumberOfLines()) == (10, 10)
        lines = numbers(data.GetLines().GetConnectivityArray()).reshape(-1, 2)
        assert lines.tolist() == pairs
        for name in ("axial_strain", "bending_strain"):
            assert numbers(data.GetCellData().GetArray(name)) == pytest.approx(
                getattr(given[k], name), rel=1e-7, nan_ok=True
            )
        assert numbers(data.GetPointData().GetArray("contact_force")) == pytest.approx(given[k].contact_force, rel=1e-7)
        assert numbers(data.GetFieldData().GetArray("strain_C")).tolist() == [given[k].strain["C"]]
        assert numbers(data.GetFieldData().GetArray("cycle")).tolist() == [given[k].cycle]


def test_times_of_all_steps_are_told_before_any_is_read(tmp_path: Path) -> None:
    write(tmp_path / "run.h5", [two_strands(k) for k in range(7)])
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "run.h5"))
    reader.UpdateInformation()
    key = reader.GetExecutive().TIME_STEPS()
    assert reader.GetOutputInformation(0).Get(key) == tuple(0.7 * k for k in range(7))


def test_frames_come_back_with_what_marks_an_image(tmp_path: Path) -> None:
    given = [two_strands(0, "Zero"), two_strands(1), two_strands(4, "Hold", "Übersicht"), two_strands(5)]
    write(tmp_path / "run.h5", given)
    found = RunReader(tmp_path / "run.h5").frames()
    assert [one.image for one in found] == [None, None, "Übersicht", None]
    for one, other in zip(found, given, strict=True):
        assert (one.time, one.cycle, one.phase, one.strain) == (other.time, other.cycle, other.phase, other.strain)
        assert one.nodes.tolist() == other.nodes.tolist()
        assert one.contact_force == pytest.approx(other.contact_force, rel=1e-7)


def test_a_step_that_was_cut_off_is_not_there(tmp_path: Path) -> None:
    write(tmp_path / "run.h5", [two_strands(k) for k in range(3)])
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        # Killed after some datasets of a fourth step had grown, before it was counted.
        for name in ("Points", "Steps/PointOffsets", "CellData/axial_strain"):
            dataset = file["VTKHDF"][name]
            dataset.resize(4 * dataset.attrs["rows"], axis=0)
    assert len(RunReader(tmp_path / "run.h5").frames()) == 3
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "run.h5"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    reader.UpdateTimeStep(1.4)
    assert reader.GetOutputDataObject(0).GetNumberOfPoints() == sum(STRANDS)


def test_steps_can_be_taken_back_dataset_by_dataset(tmp_path: Path) -> None:
    given = [two_strands(k) for k in range(6)]
    write(tmp_path / "run.h5", given)
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        for dataset in growing(file["VTKHDF"]).values():
            dataset.resize(2 * dataset.attrs["rows"], axis=0)
        file["VTKHDF/Steps"].attrs.modify("NSteps", 2)
    found = RunReader(tmp_path / "run.h5").frames()
    assert [one.time for one in found] == [0.0, 0.7]
    assert found[1].nodes.tolist() == given[1].nodes.tolist()


def test_arrays_say_their_units(tmp_path: Path) -> None:
    make_run(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as file:
        units = {name: one.attrs.get("units") for name, one in growing(file["VTKHDF"]).items()}
    assert units["Points"] == "m"
    assert units["Steps/Values"] == "s"
    assert units["PointData/contact_force"] == "N"
    assert units["CellData/axial_strain"] == units["CellData/bending_strain"] == units["FieldData/strain_C"] == "1"
