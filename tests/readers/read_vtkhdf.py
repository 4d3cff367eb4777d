"""Read the shapes of every run in the folder with VTK's HDF reader, which is ParaView's."""

import sys
from pathlib import Path

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOHDF import vtkHDFReader


def numbers(array: object) -> np.ndarray:
    """Return the numbers of one of VTK's arrays."""
    return np.asarray(vtk_to_numpy(array))  # type: ignore[no-untyped-call]


steps = 0
for path in sorted(Path(sys.argv[1]).rglob("run.h5")):
    with h5py.File(path) as file:
        group = file["VTKHDF"]
        times, strands = group["Steps/Values"][()], file["strands"][()]
        nodes = group["Points"][()].reshape(len(times), strands.sum(), 3)
        data = {
            name: group[name][()].reshape(len(times), -1)
            for name in ("CellData/axial_strain", "CellData/bending_strain", "PointData/contact_force")
        }
    reader = vtkHDFReader()
    assert reader.CanReadFile(str(path))
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(times)
    for step, time in enumerate(times):
        reader.UpdateTimeStep(time)
        shape = reader.GetOutputDataObject(0)
        np.testing.assert_array_equal(numbers(shape.GetPoints().GetData()), nodes[step])
        assert shape.GetNumberOfLines() == strands.sum() - len(strands)
        for name, values in data.items():
            of = shape.GetCellData() if name.startswith("Cell") else shape.GetPointData()
            np.testing.assert_array_equal(numbers(of.GetArray(name.split("/")[1])), values[step])
        steps += 1
assert steps
