"""Start a real PostgreSQL, as Debian installs it."""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import uuid
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import psycopg
from psycopg import sql

from tests.service.lab import until

if TYPE_CHECKING:
    from collections.abc import Iterator


def postgres_programs() -> Path | None:
    """Return the folder of PostgreSQL's programs; None without."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
    return found[-1].parent if found else None


def new_database(url: str) -> str:
    """Make an empty database on a server and return its URL."""
    name = f"lab_{uuid.uuid4().hex}"
    with psycopg.connect(url, autocommit=True) as connection:
        connection.execute(sql.SQL("CREATE DATABASE {}").format(sql.Identifier(name)))
    return f"{url.rsplit('/', 1)[0]}/{name}"


@contextmanager
def postgres() -> Iterator[str]:
    """Start a PostgreSQL server on a free port and lend the URL of its database."""
    programs = postgres_programs()
    if programs is None:
        raise FileNotFoundError("PostgreSQL is not installed")
    folder = Path(tempfile.mkdtemp(prefix="knitlab-postgres-"))
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])

    def begin(program: str, *options: str) -> subprocess.Popen[bytes]:
        # It refuses to run as root.
        user = pwd.getpwnam("postgres") if os.geteuid() == 0 else None
        if user is not None:
            os.chown(folder, user.pw_uid, user.pw_gid)
        return subprocess.Popen(  # noqa: S603 (of the system)
            [str(programs / program), *options],
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            user=None if user is None else user.pw_uid,
            group=None if user is None else user.pw_gid,
            extra_groups=None if user is None else [],
        )

    data = str(folder / "data")
    if begin("initdb", "-D", data, "-U", "lab", "-A", "trust", "-N").wait():
        raise RuntimeError("initdb failed")
    places = ("-D", data, "-k", str(folder), "-p", port, "-c", "listen_addresses=127.0.0.1")
    server = begin("postgres", *places, "-c", "max_connections=200")
    try:
        until(lambda: begin("pg_isready", "-h", "127.0.0.1", "-p", port, "-q").wait() == 0, 60.0, 0.1)
        yield f"postgresql://lab@127.0.0.1:{port}/postgres"
    finally:
        server.send_signal(signal.SIGQUIT)  # at once: nothing in it is kept
        server.wait()
        shutil.rmtree(folder, ignore_errors=True)
