"""A service whose connections are taken up by others still answers; who is slow or idle loses its connection."""

from __future__ import annotations

import json
import os
import re
import socket
import time
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import httpx
import pytest

from app.client import Client
from app.service.api import connections
from app.service.api.build import create_app
from app.service.api.connections import ConnectionLimiter, Limits, watched_by
from app.service.api.context import Context
from tests.service.knitlab_serve import QUICK, serving
from tests.service.lab import until
from tests.service.serving import served

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Iterator
    from pathlib import Path

    from app.service.jobs import Job
    from app.service.store import Store

TOKEN = "s3cret"  # noqa: S105 (of these tests alone)
HALF = b"GET /v1/jobs HTTP/1.1\r\nHost: x\r\n"
PATIENCE = 240.0


@pytest.fixture(scope="module")
def strict(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Start a service that asks for a token, bears few connections and waits for none."""
    limits = ("--max-connections", 8, "--max-per-address", 6, "--header-timeout", 1, "--idle-timeout", 1)
    with serving(tmp_path_factory.mktemp("connections"), "--slots", 0, *limits, KNITLAB_TOKEN=TOKEN) as (address, _):
        yield address


@pytest.fixture(scope="module")
def tolerant(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Start a service that bears few connections, but waits for them."""
    limits = ("--max-connections", 40, "--max-per-address", 20, "--header-timeout", 600)
    with serving(tmp_path_factory.mktemp("crowd"), "--slots", 0, *limits, KNITLAB_TOKEN=TOKEN) as started:
        yield started


@pytest.fixture
def crowded(tolerant: tuple[str, subprocess.Popen[str]]) -> str:
    """Return the address of the service that waits."""
    return tolerant[0]


def connect(address: str, source: str = "127.0.0.1") -> socket.socket:
    """Open a connection."""
    place = urlsplit(address)
    return socket.create_connection((place.hostname or "", place.port or 0), PATIENCE, (source, 0))


def ask(line: socket.socket, path: str = "/v1/rigs", token: str = TOKEN) -> bytes:
    """Ask on a connection that stays open; return the answer, or what there is of it."""
    line.sendall(f"GET {path} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {token}\r\n\r\n".encode())
    answer = b""
    while (
        found := re.search(rb"content-length: (\d+)\r\n(?:.*?)\r\n\r\n(.*)", answer, re.IGNORECASE | re.DOTALL)
    ) is None or (len(found[2]) < int(found[1])):
        more = line.recv(65536)
        if not more:
            break
        answer += more
    return answer


def rest(line: socket.socket) -> bytes:
    """Return what still comes on a connection until the service closes it."""
    said = b""
    try:
        while more := line.recv(65536):
            said += more
    except ConnectionResetError:
        pass
    return said


def is_open(line: socket.socket) -> bool:
    """Tell whether the service has neither closed a connection nor told it to go."""
    line.settimeout(0.0)
    try:
        line.recv(1, socket.MSG_PEEK)
    except BlockingIOError:
        return True
    except ConnectionResetError:
        return False
    else:
        return False
    finally:
        line.settimeout(PATIENCE)


@contextmanager
def many(address: str, count: int, said: bytes = HALF, source: str = "127.0.0.1") -> Iterator[list[socket.socket]]:
    """Lend connections that have said a part of a request."""
    with ExitStack() as stack:
        lines = []
        for _ in range(count):
            lines.append(stack.enter_context(connect(address, source)))
            lines[-1].sendall(said)
        yield lines


@pytest.mark.parametrize("said", [HALF, b""], ids=["half a header", "nothing"])
def test_half_open_connections_leave_room_for_whole_requests(crowded: str, said: bytes) -> None:
    with many(crowded, 150, said) as lines:
        assert httpx.get(f"{crowded}/healthz", timeout=PATIENCE).status_code == 200
        with Client(crowded, TOKEN) as client:
            job = client.submit(QUICK)
            assert client.job(job.id).state == "queued"
        # Half as many as may be admitted of one address; the oldest made room.
        until(lambda: sum(map(is_open, lines)) <= 10)
        assert is_open(lines[-1])
        first = rest(lines[0])
        if said:
            head, _, body = first.partition(b"\r\n\r\n")
            assert head.startswith(b"HTTP/1.1 503 Service Unavailable\r\n")
            assert b"\r\nRetry-After: 5\r\n" in head
            assert json.loads(body)["type"] == "urn:knitlab:problem:busy"
        # All the others of another address are let alone, and take no place of this one.
        with many(crowded, 10, said, "127.0.0.2") as others:
            assert httpx.get(f"{crowded}/healthz", timeout=PATIENCE).status_code == 200
            assert all(map(is_open, others))


@pytest.mark.slow
def test_1100_half_open_connections_leave_room_for_whole_requests(tmp_path: Path) -> None:
    with (
        serving(tmp_path, "--slots", 0, KNITLAB_TOKEN=TOKEN) as (address, process),
        many(address, 550) as lines,
        many(address, 550, b"") as others,
    ):
        for _ in range(5):
            assert httpx.get(f"{address}/healthz", timeout=PATIENCE).status_code == 200
            with Client(address, TOKEN) as client:
                assert client.jobs().jobs == ()
        until(lambda: sum(map(is_open, [*lines, *others])) <= 100)
        process.terminate()
        assert process.wait(timeout=PATIENCE) == 0


def test_a_header_that_comes_in_drops_has_no_more_time(strict: str) -> None:
    with connect(strict) as line:
        line.sendall(HALF)
        line.settimeout(0.05)
        said = b""
        for _ in range(1200):
            try:
                said = line.recv(65536)
                break
            except TimeoutError:
                line.sendall(b"X")
        assert said.startswith(b"HTTP/1.1 408 Request Timeout\r\n")
        assert b"allowed 1 s for the header of a request" in said


def test_who_says_nothing_or_rests_is_closed(strict: str) -> None:
    with connect(strict) as line:
        assert rest(line) == b""
    for token, status in ((TOKEN, b"200"), ("guess", b"401")):
        with connect(strict) as line:
            assert ask(line, token=token).startswith(b"HTTP/1.1 " + status)
            assert rest(line) == b""
        # A second request in drops.
        with connect(strict) as line:
            ask(line, token=token)
            line.sendall(HALF)
            assert rest(line).startswith(b"HTTP/1.1 408")


def test_a_body_that_nobody_waits_for_ends_too(strict: str) -> None:
    with connect(strict) as line:
        line.sendall(b"POST /v1/jobs HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\n\r\n")
        assert line.recv(65536).startswith(b"HTTP/1.1 401")
        line.settimeout(0.05)
        for _ in range(1200):
            try:
                if not line.recv(65536):
                    break
            except TimeoutError:
                line.sendall(b"x")
            except ConnectionError:
                break
        else:
            pytest.fail("still open")


def test_streams_and_slow_uploads_outlive_the_timeouts(strict: str) -> None:
    with Client(strict, TOKEN) as client:
        job = client.submit(QUICK)
        events = client.events(job.id)
        assert next(events).kind == "state"

        def slowly() -> Iterator[bytes]:
            for k in range(0, len(QUICK), 50):
                yield QUICK[k : k + 50].encode()
                time.sleep(0.35)

        headers = {"Content-Type": "application/yaml", "Authorization": f"Bearer {TOKEN}"}
        assert len(QUICK) * 0.35 / 50 > 2.0  # [s]: longer than both timeouts
        assert httpx.post(f"{strict}/v1/jobs", content=slowly(), headers=headers, timeout=PATIENCE).status_code == 202
        client.cancel(job.id)
        assert next(events).data["state"] == "cancelled"


def test_admitted_connections_are_bounded_in_all_and_of_each_address(strict: str) -> None:
    with Client(strict, TOKEN) as client, ExitStack() as stack:
        job = client.submit(QUICK)

        def stream(source: str) -> socket.socket:
            line = stack.enter_context(connect(strict, source))
            line.sendall(
                f"GET /v1/jobs/{job.id}/events HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {TOKEN}\r\n\r\n".encode()
            )
            assert line.recv(100).startswith(b"HTTP/1.1 200")
            return line

        client.close()
        first = [stream("127.0.0.1") for _ in range(6)]
        for held, refusal in ((0, b"connections of this address: found 6"), (2, b"connections: found 8")):
            for _ in range(held):
                stream("127.0.0.2")
            with connect(strict, "127.0.0.3" if held else "127.0.0.1") as line:
                said = ask(line)
                assert said.startswith(b"HTTP/1.1 503")
                assert refusal in said
                assert b"\r\nretry-after: 5\r\n" in said.lower()
            assert httpx.get(f"{strict}/healthz", timeout=PATIENCE).status_code == 200
        first[0].close()

        def has_room() -> bool:
            with connect(strict) as line:
                return ask(line).startswith(b"HTTP/1.1 200")

        until(has_room)


def test_a_client_that_takes_nothing_is_dropped(store: Store, job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "STALLED", 0.3)
    folder = store.folder(job.id) / "run"
    folder.mkdir(parents=True)
    with (folder / "big.csv").open("wb") as file:
        file.truncate(64_000_000)
    keeper = ConnectionLimiter(Limits())
    with served(create_app(Context(store=store)), http=watched_by(keeper)) as at:
        with connect(at) as line:
            line.sendall(f"GET /v1/jobs/{job.id}/files/run/big.csv HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            until(lambda: len(keeper.admitted.members) == 1)
            until(lambda: not keeper.admitted.members)
        # One that takes it is not.
        assert len(httpx.get(f"{at}/v1/jobs/{job.id}/files/run/big.csv", timeout=PATIENCE).content) == 64_000_000


def test_nonsense_fills_no_log(tolerant: tuple[str, subprocess.Popen[str]]) -> None:
    address, process = tolerant
    for _ in range(100):
        with connect(address) as line:
            line.sendall(b"nonsense\r\n\r\n")
            assert rest(line).startswith(b"HTTP/1.1 400")
    assert process.stderr is not None
    os.set_blocking(process.stderr.fileno(), False)
    lines = os.read(process.stderr.fileno(), 10**6).splitlines()
    assert 1 <= sum(b"Invalid HTTP request" in line for line in lines) <= len(lines) <= 15
