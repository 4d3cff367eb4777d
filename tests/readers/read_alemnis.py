"""Read the indenter's workbook and text with openpyxl and pandas, as people do."""

import sys
from pathlib import Path

import h5py
import numpy as np
import openpyxl
import pandas as pd

folder = Path(sys.argv[1]) / "indenter"
PREFIXES = {"m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12}
with h5py.File(folder / "run.h5") as file:
    log = file["channels/nanoindenter"]
    travel, load, time = log["Displacement"][()], log["Force"][()], log["Time"][()]
    load_time = time + log["Force"].attrs["delay"]
    carried = np.interp(time, load_time, load)
    corrected = travel - file.attrs["rig.carriage.compliance"] * carried
    raw_travel, raw_load = travel + log["offset/Displacement"][()], load + log["offset/Force"][()]
expected = [time, corrected, load_time, load, time, raw_travel, load_time, raw_load]


def number(cell: object) -> float:
    """Return a value with or without prefix."""
    text = str(cell)
    return float(text[:-1]) * PREFIXES[text[-1]] if text[-1] in PREFIXES else float(text)


book = openpyxl.load_workbook(folder / "en" / "indenter.xlsx", read_only=True)
assert len(book.worksheets) == 1
assert all(len(row) == 8 for row in book.worksheets[0].iter_rows(values_only=True))
for table in (
    pd.read_excel(folder / "en" / "indenter.xlsx"),
    pd.read_csv(folder / "en" / "indenter.tsv", sep="\t"),
):
    assert table.shape == (len(time), 8)
    for k in range(0, 8, 2):
        seconds = table.iloc[:, k].map(lambda text: pd.to_timedelta(text).total_seconds())
        np.testing.assert_allclose(seconds, expected[k], atol=5.001e-4)
        assert seconds.is_monotonic_increasing
        assert seconds.is_unique
        assert seconds[0] < 0
        np.testing.assert_allclose(table.iloc[:, k + 1].map(number), expected[k + 1], rtol=6e-6, atol=6e-16)
    assert (table.iloc[:, 0] != table.iloc[:, 2]).all()
