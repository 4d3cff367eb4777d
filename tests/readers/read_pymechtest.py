"""Read the frame's quoted log with pymechtest, as its documentation does."""

import sys
from pathlib import Path

import h5py
import numpy as np
from pymechtest import Tensile

folder = Path(sys.argv[1]) / "frame.1"
with h5py.File(folder / "run.h5") as file:
    log = file["channels/uniaxial-frame"]
    travel, load, time = log["Displacement"][()], log["Force"][()], log["Time"][()]
    strain = 100 * travel / file.attrs["extent_C"]
    stress = 1e-6 * load / (file.attrs["extent_W"] * file.attrs["extent_P"])

raw = folder / "en" / "frame.1.is_tens_RawData"
tests = Tensile(raw, id_row=1, header=2, strain1=0.5, strain2=3.5, expect_yield=False)
table = tests.load_all()
assert tests.stress_col == "Tensile stress"
assert tests.strain_col == "Tensile strain (Strain 1)"
assert set(table["Specimen ID"]) == {"frame.1"}
assert len(table) == len(time) > 100
for column, values, digits in (
    ("Time", time, 5),
    ("Extension", 1e3 * travel, 5),
    ("Load", load, 5),
    (tests.strain_col, strain, 4),
    (tests.stress_col, stress, 4),
):
    np.testing.assert_allclose(table[column], values, atol=0.5001 * 10**-digits, rtol=0)

summary = tests.summarise()
inside = (strain >= 0.5) & (strain <= 3.5)
assert summary["Specimen ID"].tolist() == ["frame.1"]
np.testing.assert_allclose(float(summary["Strength"][0]), stress.max(), atol=1e-4)
# In GPa, of stress in MPa over strain in per cent.
np.testing.assert_allclose(
    float(summary["Modulus"][0]), 0.1 * np.polyfit(strain[inside], stress[inside], 1)[0], atol=1e-5
)
