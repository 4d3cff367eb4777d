"""Run tiny tests and write their logs in every dialect: ``python -m tests.readers.write_files FOLDER``.

Every test has a folder with its ``run.h5``, the same as ``NAME.vtkhdf``, its images if it took any and, under ``en``
and ``de``, its logs in two locales.
"""

from __future__ import annotations

import sys
from pathlib import Path

from app.records.export import export_log
from app.records.export_shapes import export_shapes
from app.records.reader import RunReader
from app.runs.use_cases import run_protocol
from app.schemas import loads
from rigs.logs.catalogue import LOGS
from rigs.logs.locales import LOCALES

PLANAR = "{knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}"
VOLUMETRIC = "{knit: volumetric-default, loops: [2, 1, 2], loop: 8 mm, material: RGD8530-DM, nodes_per_loop: 24}"
CELL = "{knit: stockinette-default, loops: [1, 1], periodic: on, loop: 8 mm, material: RGD8530-DM}"
MICRO = "{knit: volumetric-default, loops: [2, 1, 2], loop: 50 um, material: IP-Dip, nodes_per_loop: 24}"
STAGE = f"""
schema: knitlab/protocol@1
name: stage
rig: biaxial-hook
specimen: {PLANAR}
speed_ref: pair
others: hold
log: {{rate: 10 Hz, noise: on, seed: 3}}
max_strain_increment: 2 %
steps:
  - zero: {{channels: [force, displacement]}}
  - cycle: {{axes: [C, W], lower: 0, upper: 4 %, rate: 0.2 mm/s, n: 1, tag: equibiaxial}}
"""
FRAME = f"""
schema: knitlab/protocol@1
name: frame.1
rig: uniaxial-frame
mount: C
specimen: {PLANAR}
speed_ref: pair
others: free
log: {{rate: 20 Hz, noise: on, seed: 4}}
max_strain_increment: 2 %
steps:
  - cycle: {{axes: [C], lower: 0, upper: 4 %, rate: 0.2 mm/s, n: 2, tag: course}}
"""
TRIAXIAL = f"""
schema: knitlab/protocol@1
name: both
rig: triaxial
specimen: {VOLUMETRIC}
speed_ref: pair
others: hold
log: {{rate: 10 Hz, noise: on, seed: 5, clock_offset: 0.2 s, clock_skew: 2e-5}}
max_strain_increment: 4 %
steps:
  - ramp: {{axes: [C, W], to: {{strain: 4 %}}, rate: 0.2 mm/s}}
  - ramp: {{axes: [P], to: {{strain: 4 %}}, rate: 0.2 mm/s}}
"""
INDENTER = f"""
schema: knitlab/protocol@1
name: indenter
rig: sem-microgripper
specimen: {MICRO}
speed_ref: pair
others: free
log: {{rate: 2 Hz, noise: on, seed: 6}}
max_strain_increment: 4 %
steps:
  - zero: {{channels: [force, displacement]}}
  - image: {{every: 40 s}}
  - ramp: {{axes: [P], to: {{strain: 8 %}}, rate: 1e-3 /s}}
"""


SHEARED = f"""
schema: knitlab/protocol@1
name: sheared
rig: biaxial-shear
specimen: {CELL}
others: hold
log: {{rate: 10 Hz, noise: on, seed: 7}}
max_strain_increment: 2 %
steps:
  - ramp: {{axes: [C, W], to: 4 %, rate: 0.2 mm/s}}
  - ramp: {{axes: [WC], to: 4 %, rate: 8.34e-3 /s}}
"""


def run(text: str, folder: Path) -> RunReader:
    """Do a test as the command line does, but for its plots, and return its record."""
    loaded = loads(text)
    run_protocol(loaded, folder / loaded.protocol.name, exact=True, draw=None)
    return RunReader(folder / loaded.protocol.name / "run.h5")


def write_files(folder: Path) -> None:
    """Fill the folder."""
    for text in (STAGE, FRAME, TRIAXIAL, INDENTER, SHEARED):
        record = run(text, folder)
        export_shapes(record.path.parent, "copy")
        for dialect, log in LOGS.items():
            if set(log.machines) <= set(record.samples):
                for locale in LOCALES if log.dialect.delimiter == "," else ["en"]:
                    export_log(record, record.path.parent / locale, dialect, locale=locale)


if __name__ == "__main__":
    write_files(Path(sys.argv[1]))
