"""What asks for too much is refused with the bound, before memory is taken for it."""

from __future__ import annotations

import json
import resource
import socket
import time
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import httpx
import psutil
import pytest

from app.schemas import document
from app.service.api.bounds import Bounds
from app.service.api.documents import EXAMPLE_JSON

if TYPE_CHECKING:
    from collections.abc import Iterator

    from app.schemas.document import Data, Place

YAML = {"Content-Type": "application/yaml"}
JSON = {"Content-Type": "application/json"}
MEGABYTE = 1_000_000


def refused(answer: httpx.Response, status: int, *bounds: int) -> None:
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    detail = answer.json()["detail"]
    assert len(detail) < 1100
    for bound in bounds:
        assert str(bound) in detail


@pytest.mark.parametrize("path", ["/v1/jobs", "/v1/protocols:validate", "/v1/specimens:preview", "/v1/sweeps"])
def test_a_body_is_read_no_further_than_its_bound(http: httpx.Client, path: str) -> None:
    bounds = Bounds()
    bound = bounds.sweep_body if path == "/v1/sweeps" else bounds.body
    sent = 0

    def endless() -> Iterator[bytes]:
        nonlocal sent
        for _ in range(100):
            sent += MEGABYTE
            yield b" " * MEGABYTE

    try:
        refused(http.post(path, content=endless(), headers=JSON), 413, bound)
    except httpx.WriteError:
        # The service answered and closed while there was more to send.
        assert sent < 100 * MEGABYTE
    refused(http.post(path, content=b" " * (bound + 1), headers=JSON), 413, bound)


def claim(address: str, path: str, length: int) -> socket.socket:
    """Say that a body of so many bytes comes, and send none of it."""
    place = urlsplit(address)
    line = socket.create_connection((place.hostname or "", place.port or 0), timeout=10)
    line.sendall(
        f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        f"Content-Length: {length}\r\n\r\n".encode()
    )
    return line


def test_a_length_beyond_the_bound_is_refused_before_the_body_comes(address: str) -> None:
    for length in (Bounds().body + 1, 10**12, 10**19):
        with claim(address, "/v1/jobs", length) as line:
            answer = b""
            while b"}" not in answer and (more := line.recv(4000)):
                answer += more
            assert answer.startswith(b"HTTP/1.1 413")
            assert str(Bounds().body).encode() in answer


def test_a_length_that_is_only_claimed_takes_no_memory(address: str, http: httpx.Client) -> None:
    # The service runs in this process: its memory is ours.
    process = psutil.Process()
    assert http.get("/healthz").status_code == 200
    before = process.memory_info().rss
    lines = [claim(address, "/v1/sweeps", Bounds().sweep_body) for _ in range(50)]
    try:
        time.sleep(1.0)
        assert http.get("/healthz").status_code == 200
        # 400 MB are said to come.
        assert process.memory_info().rss - before < 20 * MEGABYTE
    finally:
        for line in lines:
            line.close()


DEEP = {
    "lists in JSON": (JSON, "[" * 400_000),
    "lists in JSON, whole": (JSON, "[" * 400_000 + "]" * 400_000),
    "mappings in JSON": (JSON, '{"a":' * 150_000 + "1" + "}" * 150_000),
    "a little too deep": (JSON, json.dumps({**EXAMPLE_JSON, "steps": json.loads("[" * 25 + "]" * 25)})),
    "lists in YAML": (YAML, "[" * 900_000),
    "dashes": (YAML, "- " * 450_000),
    "mappings in YAML": (YAML, "{a: " * 200_000),
    "questions": (YAML, "? " * 450_000),
    "JSON in an envelope": (JSON, json.dumps({"protocol": "[" * 400_000})),
}


@pytest.mark.parametrize(("headers", "body"), DEEP.values(), ids=DEEP)
def test_deep_nesting(http: httpx.Client, headers: dict[str, str], body: str) -> None:
    answer = http.post("/v1/jobs", content=body, headers=headers)
    assert answer.status_code in {400, 422}
    assert answer.headers["content-type"] == "application/problem+json"


LAUGHS = "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
BOMBS = {
    "laughs": "a: &a [x, x, x, x, x, x, x, x, x]\n" + LAUGHS,
    "an alias to itself": "a: &a [*a]\n",
    "many values": "a: [" + "x," * 400_000 + "]",
    "merge keys": "a: &a {x: 1}\nb:\n  <<: *a\n",
    "a tag": "a: !!python/object/apply:os.system [id]\n",
    "a second document": "a: 1\n---\nb: 2\n",
}


@pytest.mark.parametrize("body", BOMBS.values(), ids=BOMBS)
def test_yaml_bombs(http: httpx.Client, body: str, monkeypatch: pytest.MonkeyPatch) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    read: list[object] = []
    value = document._Reader.value

    def counted(reader: document._Reader, event: object, place: Place) -> Data:
        read.append(place)
        return value(reader, event, place)

    monkeypatch.setattr(document._Reader, "value", counted)
    refused(http.post("/v1/protocols:validate", content=body, headers=YAML), 422)
    # The service, which runs in this process, has read no further than its bound, and unfolded nothing.
    assert 0 < len(read) <= document.MAX_VALUES + 1
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # kB


BODIES = {
    "not text": (YAML, b"a: \xff\xfe", 400),
    "half a character": (JSON, b'{"schema": "\\ud800"}', 400),
    "the same key twice": (JSON, b'{"a": 1, "a": 2}', 400),
    "not a number": (JSON, b'{"a": NaN}', 400),
    "too large a number": (JSON, b'{"a": 1e999}', 400),
    "a number without end": (JSON, b'{"a": ' + b"9" * 100_000 + b"}", 400),
    "cut short": (JSON, b'{"a": ', 400),
    "a control character": (YAML, b"a: \x01", 422),
    "another kind": ({"Content-Type": "text/html"}, b"<p>", 415),
    "no kind": ({}, b"a: 1", 415),
    "a form": ({"Content-Type": "application/x-www-form-urlencoded"}, b"a=1", 415),
    "an unknown field": (JSON, b'{"protocol": "", "rm -rf": 1}', 422),
    "a protocol of another kind": (JSON, b'{"protocol": 7}', 422),
}


@pytest.mark.parametrize(("headers", "body", "status"), BODIES.values(), ids=BODIES)
def test_bodies_that_cannot_be_read(http: httpx.Client, headers: dict[str, str], body: bytes, status: int) -> None:
    refused(http.post("/v1/jobs", content=body, headers=headers), status)


def never(*_: object, **__: object) -> None:
    raise AssertionError("done before it was bounded")


def test_size_of_a_specimen_is_bounded_before_it_is_built(
    http: httpx.Client, protocol: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    huge = protocol.replace("loops: [2, 2]", "loops: [100, 100], nodes_per_loop: 1000")
    monkeypatch.setattr("rigs.protocol.made_specimen.knit_specimen", never)
    refused(http.post("/v1/specimens:preview", content=huge, headers=YAML), 422, Bounds().nodes)
    bundle = protocol.replace("loops: [2, 2]", "loops: [60, 60], yarn: {fibres: 61, model: bundle}")
    refused(http.post("/v1/jobs", content=bundle, headers=YAML), 422, Bounds().nodes)


def test_strokes_and_rows_are_bounded_before_they_are_listed(
    http: httpx.Client, protocol: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.checks.dry_run.planned_rows", never)
    refused(http.post("/v1/jobs", content=protocol.replace("n: 1", "n: 20000"), headers=YAML), 422, Bounds().strokes)
    refused(http.post("/v1/jobs", content=protocol.replace("n: 1", "n: 999999999999"), headers=YAML), 422)
    monkeypatch.undo()
    fast = protocol.replace("10 Hz", "100 Hz").replace("n: 1", "n: 1000").replace("mm/s", "um/s")
    refused(http.post("/v1/jobs", content=fast, headers=YAML), 422)
    some = protocol.replace("10 Hz", "100 Hz").replace("n: 1", "n: 1000")
    refused(http.post("/v1/jobs", content=some, headers=YAML), 422, Bounds().rows)


def test_a_sweep_is_counted_before_it_is_unfolded(http: httpx.Client, protocol: str) -> None:
    two = protocol.replace("params: {", "params: {other: 0, ")
    many = {"protocol": two, "values": {"peak": list(range(1, 5000)), "other": list(range(5000))}}
    refused(http.post("/v1/sweeps", json=many), 422, Bounds().sweep)
    refused(http.post("/v1/sweeps", json={"protocols": [0] * 20_000}), 422, Bounds().sweep)
    long = {
        "protocol": protocol.replace("n: 1", "n: 4900"),
        "values": {"peak": [number / 1000 for number in range(1, 61)]},
    }
    refused(http.post("/v1/sweeps", json=long), 422, Bounds().sweep_strokes)


def test_keys_and_names_are_bounded(http: httpx.Client, protocol: str) -> None:
    for key in ("", "x" * 201, "a b"):
        answer = http.post("/v1/jobs", content=protocol, headers={**YAML, "Idempotency-Key": key})
        refused(answer, 422)
    refused(http.post(f"/v1/jobs?name={'x' * 65}", content=protocol, headers=YAML), 422)
    unnamed = protocol.replace("name: biaxial_small\n", "")
    refused(http.post("/v1/jobs?name=a%0d%0aSet-Cookie:%20b", content=unnamed, headers=YAML), 422)
