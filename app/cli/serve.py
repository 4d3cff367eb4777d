"""Commands of the service; `app.cli.main` registers them."""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from app.cli.terminal import Token  # noqa: TC001 (typer reads the annotations)
from app.service.address import PORT

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
    from app.service.log import set_up_log  # noqa: PLC0415 (lazy, as in app.cli.main)
    from app.service.settings import settings  # noqa: PLC0415
    from app.service.store import Store  # noqa: PLC0415
    from app.service.worker import Worker, own  # noqa: PLC0415

    set_up_log(logging.INFO)
    told = False

    def leave(*_: object) -> None:
        nonlocal told
        if told:  # a second signal ends it at once, even if the database does not answer
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


@service.command(
    short_help="Serve: the API, and jobs in so many slots.",
    epilog="\b\nExample:\n  knitlab serve --slots 2",
)
def serve(
    *,
    slots: Annotated[int, typer.Option(help="Jobs that run at once; 0 for the API alone.", min=0, max=1024)] = 2,
    host: Annotated[str, typer.Option(help="Address to listen on; any but this machine's own needs a token.")] = (
        "127.0.0.1"
    ),
    port: Annotated[int, typer.Option(help="Port; 0 for a free one.", min=0, max=65535)] = PORT,
    data: Annotated[
        Path | None,
        typer.Option(envvar="KNITLAB_DATA", help="Data folder.", show_default="knitlab-data", file_okay=False),
    ] = None,
    token: Token = None,
    max_connections: Annotated[
        int, typer.Option(help="Connections open at once; half as many more may wait to be let in.", min=1)
    ] = 400,
    max_per_address: Annotated[
        int, typer.Option(help="The same from one address; as many as in all behind a proxy.", min=1)
    ] = 200,
    header_timeout: Annotated[float, typer.Option(help="Seconds for the header of a request.", min=0.1)] = 10.0,
    idle_timeout: Annotated[int, typer.Option(help="Seconds that a connection may rest.", min=1)] = 30,
    keep: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="Delete jobs, with their files, so long after their end: 30d.", show_default="never"
        ),
    ] = None,
) -> None:
    """Serve until Ctrl-C: the API, and so many jobs at a time. Jobs that run go on at the next start.

    The documentation of the API is at /docs. KNITLAB_DB=postgresql://... shares one queue among many machines.
    """
    from app.schemas.units import parse  # noqa: PLC0415
    from app.service.api.connections import Limits  # noqa: PLC0415
    from app.service.serving import serve as serve_until_stopped  # noqa: PLC0415

    limits = Limits(
        connections=max_connections,
        per_address=max_per_address,
        header_timeout=header_timeout,
        idle_timeout=idle_timeout,
    )
    serve_until_stopped(
        host=host,
        port=port,
        slots=slots,
        data=data,
        token=token,
        limits=limits,
        keep=None if keep is None else parse(keep, "time", "--keep"),
    )
