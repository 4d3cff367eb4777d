"""Read the microscope's images with tifffile, as people do: every image of every run in the folder."""

import sys
from datetime import datetime, timedelta
from pathlib import Path

import h5py
import numpy as np
import tifffile

NANO = {"pm": 1e-12, "nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
found = sorted(Path(sys.argv[1]).rglob("images/*.tif"))
assert found
for path in found:
    with h5py.File(path.parent.parent / "run.h5") as file:
        start = datetime.fromisoformat(file.attrs["started"])
        times = file["VTKHDF/Steps/Values"][()]
    with tifffile.TiffFile(path) as file:
        assert file.is_sem
        said, grey = file.sem_metadata or {}, file.asarray()
    height, width = grey.shape
    assert grey.dtype == np.uint8
    assert said["dp_image_store"] == ("Store resolution", f"{width} * {height}")
    assert said["sv_file_name"] == ("File Name", path.name)
    _, pixel, unit = said["ap_image_pixel_size"]
    for key, count in (("ap_width", width), ("ap_height", height)):
        _, length, prefix = said[key]
        np.testing.assert_allclose(length * NANO[prefix], count * pixel * NANO[unit], rtol=1e-3)
    # What hyperspy takes for the scale.
    np.testing.assert_allclose(said[""][3] * 1024 / width, pixel * NANO[unit], rtol=1e-3)
    moment = f"{said['ap_date'][1]} {said['ap_time'][1]} {start:%z}"
    taken = datetime.strptime(moment, "%d %b %Y %H:%M:%S %z")
    assert any(abs(taken - start - timedelta(seconds=time)) < timedelta(seconds=1) for time in times)
