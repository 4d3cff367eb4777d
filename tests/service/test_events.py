from __future__ import annotations

import json
import socket
import time
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import httpx
import psutil
import pytest
from httpx_sse import connect_sse

from app.service.api import streams
from app.service.api.bounds import Bounds
from app.service.api.build import create_app
from app.service.api.context import Context
from app.service.api.rows import MOST, NewRows
from app.service.api.streams import Seen
from app.service.folder import JobFolder
from app.service.jobs import Job, Progress
from tests.service.lab import until
from tests.service.serving import served

if TYPE_CHECKING:
    from collections.abc import Generator
    from pathlib import Path

    from app.service.store import Store

Event = tuple[str, Any, str]


def row(number: int) -> bytes:
    """Return one line of the rows of a job."""
    force = {"C": number * 1e-3, "W": number * 2e-3}
    return json.dumps({"row": number, "time": 0.1 * number, "force": force}).encode() + b"\n"


def write(store: Store, job: Job, rows: int) -> JobFolder:
    """Write some rows into the folder of a job, and how far it is."""
    files = JobFolder(store.folder(job.id))
    files.path.mkdir(parents=True, exist_ok=True)
    files.rows_file.write_bytes(b"".join(map(row, range(rows))))
    files.write_progress(Progress(share=0.25, text="Stretch 1", rows=rows, seconds_left=12.5), 1.0)
    return files


def end(store: Store, job: Job) -> None:
    """End a job the one way that needs no process."""
    store.pause(job.id)
    store.cancel(job.id)


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streams, "PERIOD", 0.05)


def read(http: httpx.Client, job: Job, last: str = "") -> Generator[Event, None, None]:
    headers = {"Last-Event-ID": last} if last else {}
    with connect_sse(http, "GET", f"/v1/jobs/{job.id}/events", headers=headers) as source:
        for event in source.iter_sse():
            yield event.event, json.loads(event.data or "null"), event.id


def numbers(events: list[Event]) -> list[int]:
    """Return the numbers of the rows that came."""
    return [one["row"] for kind, data, _ in events if kind == "rows" for one in data["rows"]]


def test_rows_progress_and_states_arrive_as_they_come(http: httpx.Client, store: Store, job: Job) -> None:
    events = read(http, job)
    kind, data, _ = next(events)
    assert (kind, data["state"]) == ("state", "queued")
    files = write(store, job, 3)
    kind, data, _ = next(events)
    assert (kind, data["first"], len(data["rows"])) == ("rows", 0, 3)
    store.pause(job.id)
    later = {kind: data for kind, data, _ in (next(events), next(events))}
    assert set(later) == {"progress", "state"}
    assert (later["progress"]["share"], later["progress"]["seconds_left"]) == (0.25, 12.5)
    assert later["state"]["progress"]["seconds_left"] == 12.5
    with files.rows_file.open("ab") as file:
        file.write(row(3) + row(4)[:10])
        file.flush()
        assert numbers([next(events)]) == [3]
        # Half a row waits for its other half.
        file.write(row(4)[10:])
    assert numbers([next(events)]) == [4]
    store.cancel(job.id)
    rest = list(events)
    assert rest[-1][0] == "state"
    assert rest[-1][1]["state"] == "cancelled"


def test_what_was_seen_is_not_sent_again(http: httpx.Client, store: Store, job: Job) -> None:
    write(store, job, 2 * MOST + 7)
    end(store, job)
    whole = list(read(http, job))
    assert numbers(whole) == list(range(2 * MOST + 7))
    assert [kind for kind, _, _ in whole] == ["rows", "rows", "rows", "progress", "state"]
    for seen, (_, _, last) in enumerate(whole[:-1], start=1):
        assert list(read(http, job, last)) == whole[seen:]
    # Who has seen the end is told not to come again.
    gone = http.get(f"/v1/jobs/{job.id}/events", headers={"Last-Event-ID": whole[-1][2]})
    assert gone.status_code == 204
    # Ids of others are none.
    for odd in ("x", "1-2-3", "9" * 60, "-1-queued-0"):
        assert list(read(http, job, odd)) == whole


def test_rows_that_are_written_again_are_not_sent_twice(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    rows = NewRows(path, 0)
    assert rows.read() == []
    path.write_bytes(b"".join(map(row, range(9))))
    assert [one["row"] for one in rows.read()] == list(range(9))
    # A job was killed, and goes on from its checkpoint at row 5.
    path.write_bytes(b"".join(map(row, range(5))))
    assert rows.read() == []
    path.write_bytes(b"".join(map(row, range(11))))
    assert [one["row"] for one in rows.read()] == [9, 10]
    assert [one["row"] for one in NewRows(path, 7).read()] == [7, 8, 9, 10]


def test_ids_say_what_was_seen() -> None:
    seen = Seen(rows=12, state="running", share=4300)
    assert Seen.read(seen.id) == seen
    assert Seen.read("1-running-1\nid: 2") == Seen()


def stuck(address: str, job: Job) -> socket.socket:
    """Ask for events and take none of them."""
    place = urlsplit(address)
    line = socket.socket()
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    line.connect((place.hostname, place.port))
    line.sendall(f"GET /v1/jobs/{job.id}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    return line


def test_slow_clients_block_nobody_and_take_no_memory(address: str, http: httpx.Client, store: Store, job: Job) -> None:
    write(store, job, 40_000)
    process = psutil.Process()
    http.get("/healthz")
    before = process.memory_info().rss
    lines = [stuck(address, job) for _ in range(20)]
    try:
        time.sleep(2.0)
        # Answered while all of them are still owed what they asked for.
        assert http.get("/healthz").status_code == 200
        assert next(read(http, job))[0] == "rows"
        assert {
            one.status for one in process.net_connections() if one.laddr[:2] in {line.getsockname() for line in lines}
        } == {"ESTABLISHED"}
        # What they have not taken, 20 times 3 MB, is held for none of them.
        assert process.memory_info().rss - before < 30e6
    finally:
        for line in lines:
            line.close()
        end(store, job)


def test_a_client_that_takes_nothing_is_dropped(store: Store, job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streams, "STALLED", 0.5)
    write(store, job, 40_000)
    app = create_app(Context(store=store, bounds=Bounds(streams=1)))
    with served(app, quiet=True) as at:
        line = stuck(at, job)
        with httpx.Client(base_url=at) as http:
            deadline = time.monotonic() + 30.0
            while app.state.metrics.open_streams == 0 and time.monotonic() < deadline:
                time.sleep(0.02)
            # As many as may be.
            busy = http.get(f"/v1/jobs/{job.id}/events")
            assert (busy.status_code, busy.headers["retry-after"]) == (503, "5")
            while app.state.metrics.open_streams and time.monotonic() < deadline:
                time.sleep(0.05)
            assert app.state.metrics.open_streams == 0
            assert next(read(http, job))[0] == "rows"
        line.close()


def test_streams_end_when_the_service_is_about_to(store: Store, job: Job) -> None:
    context = Context(store=store)
    with served(create_app(context)) as at, httpx.Client(base_url=at) as http:
        events = read(http, job)
        assert next(events)[0] == "state"
        context.closing.set()
        # It ends by itself, with nothing more in it: not even the sign of life that comes between events.
        assert list(events) == []
    assert store.get(job.id).state == "queued"


def test_a_stream_ends_with_its_client(address: str, store: Store, job: Job, http: httpx.Client) -> None:
    events = read(http, job)
    assert next(events)[0] == "state"
    events.close()
    until(lambda: "knitlab_event_streams 0.0" in httpx.get(f"{address}/metrics").text)
    assert store.get(job.id).state == "queued"
