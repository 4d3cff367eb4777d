"""Serve an app on a free port of this machine, in a thread of the tests."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import uvicorn

if TYPE_CHECKING:
    from asyncio import Protocol
    from collections.abc import Iterator

    import httpx
    from fastapi import FastAPI


@contextmanager
def served(app: FastAPI, *, quiet: bool = False, http: type[Protocol] | str = "auto") -> Iterator[str]:
    """Lend the address of an app that answers; a quiet one keeps its own mistakes to itself."""
    listener = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(uvicorn.Config(app, http=http, log_level="critical" if quiet else "error", lifespan="off"))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    try:
        while not server.started:
            time.sleep(0.01)
        yield f"http://127.0.0.1:{listener.getsockname()[1]}"
    finally:
        server.should_exit = True
        thread.join(timeout=10)
        listener.close()


def problem(response: httpx.Response, status: int, kind: str) -> dict[str, Any]:
    """Return the problem that an answer carries."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    found: dict[str, Any] = response.json()
    assert found["status"] == status
    assert found["type"] == f"urn:knitlab:problem:{kind}"
    assert {"title", "detail", "instance"} <= set(found)
    assert "Traceback" not in response.text
    return found
