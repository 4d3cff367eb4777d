"""Read the shapes of every run in the folder with PyVista, which chooses its reader by the name of the file."""

import sys
from pathlib import Path

import h5py
import numpy as np
import pyvista

files = sorted(Path(sys.argv[1]).rglob("*.vtkhdf"))
assert files
for path in files:
    with h5py.File(path) as file:
        strands = file["strands"][()]
        first = file["VTKHDF/Points"][: strands.sum()]
        strain = file["VTKHDF/CellData/axial_strain"][: strands.sum() - len(strands)]
    shape = pyvista.read(path)
    np.testing.assert_array_equal(shape.points, first)
    np.testing.assert_array_equal(shape.cell_data["axial_strain"], strain)
    assert shape.n_lines == len(strain)
