from __future__ import annotations

import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from shutil import copyfile
from typing import TYPE_CHECKING
from urllib.parse import quote, urlsplit

import anyio
import pytest
from starlette.requests import Request

from app.cli.watching import _inside
from app.service.api.transfer import transfer
from app.service.errors import ServiceError
from app.service.folder import JobFolder
from app.service.jobs import Job, JobSpec
from tests.service.serving import problem
from tests.synthetic_run import make_run

if TYPE_CHECKING:
    from pathlib import Path

    import httpx

    from app.service.store import Store

CONTENT = bytes(range(256)) * 1000


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the record of a test."""
    path = tmp_path_factory.mktemp("record") / "run.h5"
    make_run(path)
    return path


@pytest.fixture
def done(store: Store, protocol: str, record: Path) -> Job:
    """Put the files of a test that has been run into the folder of a job."""
    job = store.submit(JobSpec(name="made", protocol=protocol))
    files = JobFolder(store.folder(job.id))
    files.write_spec(store.spec(job.id))
    files.run.mkdir()
    copyfile(record, files.run / "run.h5")
    (files.run / "made.csv").write_bytes(CONTENT)
    (files.run / ".made-tmp.csv").write_bytes(b"half")
    (files.path / "lock").write_bytes(b"{}")
    (files.run / "run.lock").write_bytes(b"{}")
    return job


def test_files_are_listed(http: httpx.Client, done: Job) -> None:
    found = {one["name"]: one for one in http.get(f"/v1/jobs/{done.id}/files").json()["files"]}
    assert set(found) == {"protocol.yaml", "run/made.csv", "run/run.h5"}
    assert found["run/made.csv"]["size"] == len(CONTENT)
    assert found["run/made.csv"]["kind"] == "log"
    assert found["run/run.h5"]["kind"] == "record"


def test_a_file_is_sent_whole(http: httpx.Client, done: Job) -> None:
    answer = http.get(f"/v1/jobs/{done.id}/files/run/made.csv")
    assert answer.content == CONTENT
    assert answer.headers["content-type"].startswith("text/csv")
    assert answer.headers["content-disposition"] == "attachment; filename*=utf-8''made.csv"
    assert answer.headers["x-content-type-options"] == "nosniff"
    for known in ("{}", '"other", W/{}', "*"):
        same = http.get(answer.request.url, headers={"If-None-Match": known.format(answer.headers["etag"])})
        assert (same.status_code, same.content) == (304, b"")
    part = http.head(answer.request.url, headers={"Range": "bytes=10-19"})
    assert (part.status_code, part.content, part.headers["content-length"]) == (206, b"", "10")


@pytest.mark.parametrize(
    ("wanted", "start", "end"),
    [
        ("0-0", 0, 1),
        ("100-199", 100, 200),
        ("255900-", 255900, 256000),
        ("-10", 255990, 256000),
        ("9-999999", 9, 256000),
    ],
)
def test_a_range_is_sent(http: httpx.Client, done: Job, wanted: str, start: int, end: int) -> None:
    answer = http.get(f"/v1/jobs/{done.id}/files/run/made.csv", headers={"Range": f"bytes={wanted}"})
    assert answer.status_code == 206
    assert answer.content == CONTENT[start:end]
    assert answer.headers["content-range"] == f"bytes {start}-{end - 1}/{len(CONTENT)}"
    assert int(answer.headers["content-length"]) == end - start


def test_ranges_that_are_not_there(http: httpx.Client, done: Job) -> None:
    path = f"/v1/jobs/{done.id}/files/run/made.csv"
    for wanted in ("256000-", "999999-9999999", "-0"):
        answer = http.get(path, headers={"Range": f"bytes={wanted}"})
        problem(answer, 416, "range")
        assert answer.headers["content-range"] == "bytes */256000"
    # What is no range is passed over, and so are several.
    for ignored in ("bytes=9-3", "bytes=a-b", "lines=0-1", "bytes=0-1,5-6", "bytes=-"):
        assert http.get(path, headers={"Range": ignored}).content == CONTENT
    # A range of what the file was before is of no use.
    old = http.get(path, headers={"Range": "bytes=0-9", "If-Range": '"old"'})
    assert (old.status_code, old.content) == (200, CONTENT)
    new = http.get(path, headers={"Range": "bytes=0-9", "If-Range": old.headers["etag"]})
    assert (new.status_code, new.content) == (206, CONTENT[:10])


def raw(address: str, target: str) -> bytes:
    """Ask for a path that no client would leave as it is."""
    place = urlsplit(address)
    with socket.create_connection((place.hostname or "", place.port or 0), timeout=10) as line:
        line.sendall(f"GET {target} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
        return b"".join(iter(lambda: line.recv(65536), b""))


@pytest.mark.parametrize(
    "name",
    [
        "../spec.json",
        "run/../spec.json",
        "run/../../../../knitlab.sqlite",
        "..%2f..%2f..%2fknitlab.sqlite",
        "%2e%2e/%2e%2e/%2e%2e/knitlab.sqlite",
        "..%5c..%5cknitlab.sqlite",
        "/etc/passwd",
        "//etc/passwd",
        "%2fetc%2fpasswd",
        "run/..%00/made.csv",
        "run%00.csv",
        ".",
        "run",
        "lock",
        "spec.json",
        "run/.made-tmp.csv",
        "run/run.lock",
        "link.csv",
        "outside/knitlab.sqlite",
    ],
)
def test_no_path_leads_out_of_a_job(store: Store, address: str, done: Job, name: str) -> None:
    folder = store.folder(done.id)
    (folder / "link.csv").symlink_to("/etc/passwd")
    (folder / "outside").symlink_to(store.settings.data, target_is_directory=True)
    answer = raw(address, f"/v1/jobs/{done.id}/files/{name}")
    assert answer.startswith((b"HTTP/1.1 404", b"HTTP/1.1 400", b"HTTP/1.1 422")), answer[:200]
    assert b"root:" not in answer
    assert b"SQLite" not in answer


@pytest.mark.parametrize(
    "name", ['a"b.csv', "a\r\nSet-Cookie: b=c.csv", "a\nb.csv", "é;x=y.csv", "a%0d%0ab.csv", "日.csv"]
)
def test_no_file_name_breaks_a_header(store: Store, http: httpx.Client, done: Job, name: str) -> None:
    (store.folder(done.id) / name).write_bytes(b"here")
    answer = http.get(f"/v1/jobs/{done.id}/files/{quote(name, safe='')}")
    assert "set-cookie" not in answer.headers
    if "\n" in name:
        # Not even looked for.
        assert answer.status_code == 404
        return
    assert answer.content == b"here"
    assert answer.headers["content-disposition"] == f"attachment; filename*=utf-8''{quote(name, safe='')}"


def test_a_page_in_a_job_is_no_page_of_the_service(store: Store, http: httpx.Client, done: Job) -> None:
    (store.folder(done.id) / "evil.html").write_bytes(b"<script>")
    answer = http.get(f"/v1/jobs/{done.id}/files/evil.html")
    assert answer.headers["content-type"] == "application/octet-stream"
    assert answer.headers["content-disposition"].startswith("attachment")


def test_a_file_that_grows_is_sent_as_long_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "log"
    path.write_bytes(b"x" * 100_000)
    answer = transfer(Request({"type": "http", "headers": []}), path.open("rb"), "log", "text/plain")
    with path.open("ab") as more:
        more.write(b"y" * 100_000)

    async def received() -> bytes:
        return b"".join([bytes(part) async for part in answer.body_iterator])  # type: ignore[attr-defined]

    # In a thread: a browser that other tests left open may run a loop in this one.
    with ThreadPoolExecutor(1) as thread:
        assert thread.submit(anyio.run, received).result() == b"x" * 100_000
    assert answer.headers["content-length"] == "100000"


def test_a_log_in_a_dialect(http: httpx.Client, store: Store, done: Job) -> None:
    answer = http.get(f"/v1/jobs/{done.id}/log", params={"dialect": "biotester"})
    assert answer.text.startswith("SetName,Cycle,Time_S,Temperature,XSize_um")
    assert http.get(f"/v1/jobs/{done.id}/log").content == answer.content
    part = http.get(f"/v1/jobs/{done.id}/log", headers={"Range": "bytes=0-6"})
    assert (part.status_code, part.text) == (206, "SetName")
    problem(http.get(f"/v1/jobs/{done.id}/log?dialect=x"), 422, "invalid-request")
    # It never will be: the rig has no such machine.
    never = problem(http.get(f"/v1/jobs/{done.id}/log?dialect=bluehill-universal"), 422, "invalid-request")
    assert never["errors"] == [{"parameter": "dialect", "detail": never["detail"]}]
    assert never["detail"].endswith("allowed on biaxial-hook: biotester")
    (store.folder(done.id) / "run" / "run.h5").unlink()
    for query in ("", "?dialect=biotester"):
        problem(http.get(f"/v1/jobs/{done.id}/log{query}"), 409, "not-ready")
    problem(http.get(f"/v1/jobs/{done.id}/log?dialect=bluehill-universal"), 422, "invalid-request")


def test_files_that_come_and_go_break_no_list(http: httpx.Client, store: Store, done: Job) -> None:
    folder = store.folder(done.id) / "run"
    (folder / "part").mkdir()
    files = [folder / "part" / f"{number}.csv" for number in range(200)]
    over = threading.Event()

    def restless() -> None:
        while not over.is_set():
            for file in files:
                file.write_bytes(b"x")
            for file in files:
                file.unlink()

    thread = threading.Thread(target=restless)
    thread.start()
    try:
        for _ in range(10):
            listed = http.get(f"/v1/jobs/{done.id}/files")
            assert listed.status_code == 200
            assert {"run/made.csv", "run/run.h5"} <= {one["name"] for one in listed.json()["files"]}
            assert http.get(f"/v1/jobs/{done.id}/files/run/part/7.csv").status_code in {200, 404}
    finally:
        over.set()
        thread.join()


def test_frames_are_there_while_the_record_is_written(
    http: httpx.Client, store: Store, done: Job, record: Path
) -> None:
    path = store.folder(done.id) / "run" / "run.h5"
    whole = record.read_bytes()
    over = threading.Event()

    def writes() -> None:
        while not over.is_set():
            # Torn for as long as it takes to write a row, whole in between.
            path.write_bytes(whole[: len(whole) // 2])
            over.wait(0.02)
            path.write_bytes(whole)
            over.wait(0.1)

    thread = threading.Thread(target=writes)
    thread.start()
    try:
        for _ in range(15):
            index = http.get(f"/v1/jobs/{done.id}/frames")
            assert index.status_code == 200, index.text
            assert http.get(f"/v1/jobs/{done.id}/frames/0").status_code == 200
    finally:
        over.set()
        thread.join()
    assert len(index.json()["frames"]) > 0
    path.write_bytes(whole[: len(whole) // 2])
    problem(http.get(f"/v1/jobs/{done.id}/frames"), 409, "not-ready")


def test_a_client_takes_no_path_on_trust() -> None:
    assert str(_inside("x.is_tcyclic_Exports/x_1.csv")) == "x.is_tcyclic_Exports/x_1.csv"
    for name in ("../x", "/etc/x", "a/../../x", "", "c:x", "a\\b", "a\0"):
        with pytest.raises(ServiceError, match="leads out"):
            _inside(name)
