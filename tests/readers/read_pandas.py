"""Read every text log with pandas, as people do."""

import itertools
import sys
from pathlib import Path

import h5py
import numpy as np
import pandas as pd

folder = Path(sys.argv[1])


def record(run: str, machine: str) -> dict[str, np.ndarray]:
    """Return the channels of the record."""
    with h5py.File(folder / run / "run.h5") as file:
        log = file[f"channels/{machine}"]
        return {name: log[name][()] for name in ("Time", *log["clean"])}


def agree(shown: pd.Series, values: np.ndarray, digits: int) -> None:
    """Demand that what is shown is what was recorded, to the digits printed."""
    np.testing.assert_allclose(shown.astype(float), values, atol=0.5001 * 10.0**-digits, rtol=1e-12)


frame, stage = record("frame.1", "uniaxial-frame"), record("stage", "biaxial-hook")
for locale, marks in (
    ("en", {"thousands": ","}),
    ("de", {"sep": ";", "decimal": ","}),
    ("fr", {"sep": ";", "decimal": ","}),
):
    logs = folder / "frame.1" / locale

    universal = pd.read_csv(logs / "frame.1.is_tcyclic_Exports" / "frame.1_1.csv", skiprows=[1], **marks)
    assert universal.columns.tolist() == ["Time", "Displacement", "Force"]
    agree(universal["Time"], frame["Time"], 4)
    agree(universal["Displacement"], 1e3 * frame["Displacement"], 4)
    agree(universal["Force"], frame["Force"], 4)

    path = logs / "frame.1.is_tcyclic_RawData" / "Specimen_RawData_1.csv"
    lines = path.read_bytes().split(b"\r\n")
    # Readers look for the one blank line among the first hundred.
    (blank,) = (k for k, line in enumerate(lines[:100]) if not line)
    cyclic = pd.read_csv(path, skiprows=[*range(blank + 1), blank + 2], **marks)
    agree(cyclic["Extension"], 1e3 * frame["Displacement"], 5)
    agree(cyclic["Load"], frame["Force"], 5)
    assert cyclic["Segment ID"].map({22476: "outward", 22412: "return"}).notna().all()
    assert cyclic["Total Cycle Count"].drop_duplicates().tolist() == [0, 1]
    # People split the strokes at the changes of the segment.
    turns = np.flatnonzero(np.diff(cyclic["Segment ID"])) + 1
    assert len(turns) == 3
    for first, last in itertools.pairwise([0, *turns, len(cyclic)]):
        stroke = cyclic["Extension"][first:last]
        assert abs(stroke.iloc[-1] - stroke.iloc[0]) > 0.9 * np.ptp(cyclic["Extension"])
    counted = cyclic["Extension"][int(np.flatnonzero(np.diff(cyclic["Total Cycle Count"]))[0]) + 1]
    turned = cyclic["Extension"][turns[1] - 1 : turns[1] + 1].min()
    assert 0 < counted - turned < 0.03 * np.ptp(cyclic["Extension"])

    path = logs / "frame.1.is_tens_Exports" / "frame.1_1.csv"
    results = pd.read_csv(path, skiprows=[0, 2], nrows=1, index_col=0, **marks)
    agree(results["Maximum Load"], frame["Force"].max(keepdims=True), 5)
    raw = pd.read_csv(path, skiprows=[*range(5), 6], **marks)
    agree(raw["Load"], frame["Force"], 5)

    marks.pop("thousands", None)
    biotester = pd.read_csv(folder / "stage" / locale / "stage.csv", **marks)
    agree(biotester["Time_S"], stage["Time"], 3)
    agree(biotester["XDisplacement_um"], 1e6 * stage["XDisplacement"], 0)
    agree(biotester["YForce_mN"], 1e3 * stage["YForce"], 2)
    assert biotester["Cycle"].drop_duplicates().tolist() == ["1-Preload", "1-Stretch", "1-Recover"]
