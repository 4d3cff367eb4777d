"""Write how the files of ``docs/files.md`` begin: ``python -m tests.examples.files_page``."""

from __future__ import annotations

import tempfile
from pathlib import Path

import h5py

from app.records.export import export_log
from app.records.reader import RunReader
from rigs.logs.catalogue import LOGS
from tests.readers.write_files import FRAME, INDENTER, SHEARED, STAGE, TRIAXIAL, run

PAGE = Path(__file__).parents[2] / "docs" / "files.md"
SHOWN = 7
STARTED = "2018-11-13T17:14:09+01:00"
RUNS = {"biotester": STAGE, "triaxial": TRIAXIAL, "alemnis-tsv": INDENTER, "shear-stage": SHEARED}


def beginnings(folder: Path) -> dict[str, str]:
    """Return the first lines of every text dialect, from tests done in a folder."""
    records: dict[str, RunReader] = {}
    begun = {}
    for name, log in LOGS.items():
        text = RUNS.get(name, FRAME)
        if log.kind == "text":
            if text not in records:
                records[text] = _dated(run(text, folder).path)
            begun[name] = export_log(records[text], folder, name).read_bytes().decode()
    return {name: "\n".join(begun[name].split("\r\n")[:SHOWN]) for name in LOGS if name in begun}


def _dated(path: Path) -> RunReader:
    """Give a record the date of the page."""
    with h5py.File(path, "r+") as file:
        file.attrs["started"] = STARTED
    return RunReader(path)


def blocks(begun: dict[str, str]) -> str:
    """Return them as the page shows them."""
    return "".join(f"\n`{name}`\n\n```\n{text}\n```\n" for name, text in begun.items())


if __name__ == "__main__":
    before, heading, rest = PAGE.read_text(encoding="utf-8").partition("## How they begin\n")
    introduction = rest.split("\n\n`")[0].rstrip("\n") + "\n"
    with tempfile.TemporaryDirectory() as place:
        PAGE.write_text(before + heading + introduction + blocks(beginnings(Path(place))), encoding="utf-8")
