"""Open the service's commands; `app.cli` takes them in."""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from pathlib import Path
from typing import Annotated

import typer

service = typer.Typer()

DataFolder = Annotated[
    Path | None,
    typer.Option(
        "--data",
        help="Folder of the jobs' folders.",
        show_default="KNITLAB_DATA, else knitlab-data",
        file_okay=False,
    ),
]
Slots = Annotated[int | None, typer.Option(help="Jobs at once.", min=1, show_default="one per processor")]


@service.command(
    short_help="Run jobs from a shared queue (KNITLAB_DB) on this host.",
    epilog="\b\nExample:\n  KNITLAB_DB=postgresql://lab@db/knitlab knitlab worker --slots 16 --data /shared/knitlab",
)
def worker(
    *,
    slots: Slots = None,
    data: DataFolder = None,
    lease: Annotated[
        float, typer.Option(help="Seconds of silence after which others take this worker for dead.", min=1.0)
    ] = 15.0,
) -> None:
    """Take jobs from the queue and run each in a process of its own, until SIGTERM or Ctrl-C.

    On SIGTERM running jobs stop at a checkpoint and are queued again; that takes seconds; a second one ends it at
    once. All workers and the server share the database KNITLAB_DB and the data folder. Without KNITLAB_DB the worker
    serves the embedded store of the data folder alone, as `knitlab serve` does.
    """
    from app.service.log import set_up_log  # noqa: PLC0415 (lazy, as in app.cli)
    from app.service.settings import settings  # noqa: PLC0415
    from app.service.store import Store  # noqa: PLC0415
    from app.service.worker import Worker, own  # noqa: PLC0415

    set_up_log(logging.INFO)
    told = False

    def leave(*_: object) -> None:
        nonlocal told
        if told:  # the second time it is meant, even if the database is away
            os._exit(1)
        told = True

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, leave)
    where = settings(data)
    with own(where), Store(where) as store:
        crew = Worker(store, slots or os.cpu_count() or 1, lease)
        crew.start()
        while not told:
            time.sleep(0.2)
        sys.stderr.write("leaving: running jobs stop at a checkpoint and are queued again\n")
        crew.drain()
