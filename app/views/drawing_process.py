"""Process that draws the record named on standard input: ``python -m app.views.drawing_process``.

A line of JSON comes, ``[record, name]``, and `DRAWN` goes out. The process ends when its input ends, which it
does when the process that asked for the pictures has ended.
"""

from __future__ import annotations

import json
import os
from importlib import import_module
from pathlib import Path
from queue import Empty
from typing import Final

from app import beside
from app.records.reader import RunReader
from app.views.drawing import DRAWN, IDLE_SECONDS, draw_pictures

AHEAD: Final = (
    "matplotlib.backends.backend_agg",
    "matplotlib.figure",
    "app.views.plotting",
    "app.views.renders",
    "app.views.plots",
)
"""Modules that take long to import."""


def main() -> None:
    """Import, wait for the name of a record, draw it, and reply."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    asked = beside.listen()
    # Only now, so that the end of the input is seen meanwhile.
    for name in AHEAD:
        import_module(name)
    from app.views.tube_images import prepare  # noqa: PLC0415

    prepare()
    try:
        record, name = json.loads(asked.get(timeout=IDLE_SECONDS))
    except Empty:
        return
    draw_pictures(RunReader(Path(record)), name)
    answers.write(DRAWN)
    answers.flush()


if __name__ == "__main__":
    main()
