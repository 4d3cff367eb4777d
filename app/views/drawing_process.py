"""Draw the record named on the standard input: ``python -m app.views.drawing_process``, started by `drawing`.

A line of JSON comes, ``[record, name]``, and the note of `draw_pictures` goes out, as a line of JSON too. The end of
the input is the end of whoever wanted the pictures, and of this process.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from queue import Empty

from app import beside
from app.views.drawing import IDLE_SECONDS, draw_pictures
from app.views.painters import start_painter


def main() -> None:
    """Get ready, wait for a record, draw it, answer."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what libraries print is no answer
    asked = beside.listen()
    start_painter()
    import matplotlib.backends.backend_agg  # noqa: F401, PLC0415

    import app.views.plots  # noqa: F401, PLC0415

    try:
        record, name = json.loads(asked.get(timeout=IDLE_SECONDS))
    except Empty:
        return
    answers.write(json.dumps(draw_pictures(Path(record), name)) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
