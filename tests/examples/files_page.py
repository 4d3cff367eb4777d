"""Write how the files of ``docs/files.md`` begin: ``python -m tests.examples.files_page``."""

from __future__ import annotations

import tempfile
from pathlib import Path

from app.export import export_log
from rigs.logs.catalogue import LOGS
from tests.readers.write_files import FRAME, STAGE, as_indenter, run
from tests.rigs.golden_files import written

PAGE = Path(__file__).parents[2] / "docs" / "files.md"
SHOWN = 7
RUNS = {"biotester": "stage", "alemnis-tsv": "indenter"}


def beginnings(folder: Path) -> dict[str, str]:
    """Return the first lines of every text dialect, from tests done in a folder."""
    records = {
        "stage": run(STAGE, folder / "stage"),
        "frame": run(FRAME, folder / "frame"),
        "indenter": run(FRAME.replace("frame.1", "indenter"), folder / "indenter", as_indenter),
    }
    begun = {"triaxial": written("triaxial", "en").decode()}
    for name, log in LOGS.items():
        if log.kind == "text" and name not in begun:
            path = export_log(records[RUNS.get(name, "frame")], folder, name)
            begun[name] = path.read_bytes().decode()
    return {name: "\n".join(begun[name].split("\r\n")[:SHOWN]) for name in LOGS if name in begun}


def blocks(begun: dict[str, str]) -> str:
    """Return them as the page shows them."""
    return "".join(f"\n`{name}`\n\n```\n{text}\n```\n" for name, text in begun.items())


if __name__ == "__main__":
    before, heading, rest = PAGE.read_text(encoding="utf-8").partition("## How they begin\n")
    introduction = rest.split("\n\n`")[0].rstrip("\n") + "\n"
    with tempfile.TemporaryDirectory() as place:
        PAGE.write_text(before + heading + introduction + blocks(beginnings(Path(place))), encoding="utf-8")
