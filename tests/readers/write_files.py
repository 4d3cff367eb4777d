"""Run tiny tests and write their logs in every dialect: ``python -m tests.readers.write_files FOLDER``.

Every test has a folder with its ``run.h5`` and, under ``en`` and ``de``, its logs in two locales.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.export import export_log
from app.provenance import provenance
from app.rig_data import machines_of
from app.run_layout import make_record
from app.run_reader import RunReader
from app.runs import RunWriter
from app.schemas import from_yaml
from rigs.experiment import perform
from rigs.instruments import Zeroing, measure
from rigs.logs.catalogue import LOGS
from rigs.logs.locales import LOCALES
from rigs.record import Equilibrium, Frame, Outcome, trace_of
from rigs.rig import mount
from rigs.specimen import make_specimen

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigs.instruments import Instrument

SPECIMEN = "{knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}"
STAGE = f"""
schema: knitlab/protocol@1
name: stage
rig: biaxial-hook
specimen: {SPECIMEN}
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
specimen: {SPECIMEN}
speed_ref: pair
others: free
log: {{rate: 20 Hz, noise: on, seed: 4}}
max_strain_increment: 2 %
steps:
  - cycle: {{axes: [C], lower: 0, upper: 4 %, rate: 0.2 mm/s, n: 2, tag: course}}
"""
FACTS: dict[str, str | int | float] = {"started": "2018-11-13T17:14:09+01:00", "rig.carriage.compliance": 2e-6}


def as_indenter(frame: Instrument) -> Instrument:
    """Return an instrument that reads what the frame's does as an indenter would: early, its load late."""
    late = tuple(replace(channel, delay=0.003 if channel.kind == "force" else 0.0) for channel in frame.channels)
    return replace(frame, name="nanoindenter", channels=late, lead=6.135)


def run(text: str, folder: Path, read: Callable[[Instrument], Instrument] | None = None) -> RunReader:
    """Do a test, read by the rig's instruments or by others in their place, and return its record."""
    protocol = from_yaml(text)
    data = machines_of(protocol)
    rig, state = mount(make_specimen(protocol.specimen), protocol, data)
    instruments = [one if read is None else read(one) for one in rig.instruments]
    folder.mkdir(parents=True)
    with RunWriter(
        make_record(
            folder / "run.h5",
            protocol=text,
            size=rig.size,
            axes=protocol.axes,
            strands=rig.strands,
            instruments=instruments,
            provenance={**provenance(protocol, data), **FACTS},
        )
    ) as writer:
        events = list(perform(rig, state, protocol))
        rows = [event for event in events if isinstance(event, Equilibrium)]
        zeroings = [event for event in events if isinstance(event, Zeroing)]
        for event in events:
            if isinstance(event, Frame):
                writer.add_frame(event)
        for row in rows:
            writer.append(row)
        for instrument in instruments:
            writer.write_samples(measure(instrument, trace_of(rows), seed=protocol.log.seed, zeroings=zeroings))
        writer.finish(next(event for event in events if isinstance(event, Outcome)))
    return RunReader(folder / "run.h5")


def write_files(folder: Path) -> None:
    """Fill the folder."""
    indenter = FRAME.replace("frame.1", "indenter")
    for text, read in ((STAGE, None), (FRAME, None), (indenter, as_indenter)):
        name = from_yaml(text).name
        record = run(text, folder / name, read)
        for dialect, log in LOGS.items():
            if set(log.machines) <= set(record.samples):
                for locale in LOCALES if log.dialect.delimiter == "," else ["en"]:
                    export_log(record, folder / name / locale, dialect, locale=locale)


if __name__ == "__main__":
    write_files(Path(sys.argv[1]))
