from __future__ import annotations

import threading
import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import httpx
import pytest
import sqlalchemy as sa

from app.service.api.build import create_app
from app.service.api.concurrency import Turns
from app.service.api.context import Context
from app.service.api.documents import EXAMPLE_JSON, EXAMPLE_SWEEP, EXAMPLE_YAML
from app.service.settings import settings
from app.service.store import Store
from tests.service.serving import problem, served

if TYPE_CHECKING:
    from pathlib import Path

    from app.service.jobs import Job

YAML = {"Content-Type": "application/yaml"}


def test_health_and_figures(http: httpx.Client, job: Job) -> None:
    assert http.get("/healthz").json()["status"] == "ok"
    text = http.get("/metrics").text
    queued = next(line for line in text.splitlines() if line.startswith('knitlab_jobs{state="queued"}'))
    assert float(queued.split()[1]) >= 1.0, job
    assert 'knitlab_requests_total{method="GET",route="/healthz",status="200"}' in text


def test_catalogues_say_where_numbers_come_from(http: httpx.Client) -> None:
    rigs = http.get("/v1/rigs").json()
    stage = next(rig for rig in rigs["rigs"] if rig["name"] == "biaxial-hook")
    assert stage["axes"] == ["C", "W"]
    assert "biotester" in stage["dialects"]
    assert (stage["others"], stage["others_default"]) == (["hold", "free", "follow"], None)
    frame = next(rig for rig in rigs["rigs"] if rig["name"] == "uniaxial-frame")
    assert frame["others"] == ["free"]
    numbers = next(one for one in rigs["machines"] if one["name"] == "biaxial-hook")["numbers"]
    assert numbers["load_cell"]["limit"] | {"source": ""} == {
        "value": 100.0,
        "unit": "N",
        "source": "",
        "assumed": True,
    }
    materials = {one["name"]: one for one in http.get("/v1/materials").json()["materials"]}
    assert materials["RGD8530-DM"]["young_modulus"]["value"] == 8.2e8
    assert materials["RGD8530-DM"]["young_modulus"]["source"]


def test_a_protocol_is_checked_without_physics(http: httpx.Client, protocol: str) -> None:
    plan = http.post("/v1/protocols:validate", content=protocol, headers=YAML).json()
    assert [stroke["phase"] for stroke in plan["strokes"]] == ["Zero", "Stretch", "Recover"]
    # 2 x 20 % of the longer gauge length at 0.2 mm/s.
    length = max(plan["specimen"]["gauge_lengths_m"].values())
    assert plan["duration_s"] == pytest.approx(2 * 0.2 * length / 2e-4)
    assert http.post("/v1/protocols:validate", json={"protocol": protocol}).json() == plan


@pytest.mark.parametrize("bodiless", ["", "null", "[]", "7", '"text"'])
def test_what_is_no_protocol_is_refused(http: httpx.Client, bodiless: str) -> None:
    for kind in ("application/yaml", "application/json"):
        answer = http.post("/v1/protocols:validate", content=bodiless, headers={"Content-Type": kind})
        assert answer.status_code in {400, 422}
        assert answer.headers["content-type"] == "application/problem+json"


def test_an_error_names_pointer_and_line(http: httpx.Client, protocol: str) -> None:
    wrong = protocol.replace("rate: 0.2 mm/s", "rate: 0.2 mm")
    found = problem(http.post("/v1/jobs", content=wrong, headers=YAML), 422, "invalid-protocol")
    (place,) = found["errors"]
    assert place["pointer"] == "/steps/1/cycle/rate"
    line = wrong.splitlines()[place["line"] - 1]
    assert line[place["column"] - 1 :].startswith("0.2 mm")
    # In JSON the lines are nobody's own.
    body = {**EXAMPLE_JSON, "rig": "hook"}
    (place,) = problem(http.post("/v1/jobs", json=body), 422, "invalid-protocol")["errors"]
    assert place["pointer"] == "/rig"
    assert "line" not in place


def test_a_specimen_is_looked_at(http: httpx.Client, protocol: str) -> None:
    facts = http.post("/v1/specimens:preview", content=protocol, headers=YAML).json()
    assert 0.0 < facts["clearance_m"] < facts["yarn_length_m"]
    assert 0.3 < facts["locking_strain"] < 0.7


@pytest.mark.slow
def test_a_specimen_is_drawn(http: httpx.Client, protocol: str) -> None:
    answer = http.post(
        "/v1/specimens:preview", content=protocol, headers={**YAML, "Accept": "image/png"}, timeout=120.0
    )
    assert answer.headers["content-type"] == "image/png"
    assert answer.content.startswith(b"\x89PNG\r\n")


def test_pictures_that_wait_hold_up_nothing_else(store: Store, protocol: str) -> None:
    # Somebody's picture is being drawn, and takes its time.
    context = Context(store=store, drawing=Turns(what="", again=10, patience=8.0, _taken=True))
    headers = {**YAML, "Accept": "image/png"}
    with served(create_app(context)) as at, ThreadPoolExecutor(45) as pool:
        began = time.monotonic()
        path = f"{at}/v1/specimens:preview"
        waiting = [pool.submit(httpx.post, path, content=protocol, headers=headers, timeout=60.0) for _ in range(45)]
        while sum(one.done() for one in waiting) < 45 - context.drawing.most and time.monotonic() - began < 30.0:
            time.sleep(0.05)
        for path in ("/healthz", "/v1/rigs", "/v1/jobs"):
            assert httpx.get(at + path, timeout=30.0).status_code == 200
        assert sum(not one.done() for one in waiting) == context.drawing.most
        for one in waiting:
            busy = one.result()
            problem(busy, 503, "busy")
            assert int(busy.headers["retry-after"]) > 0


def test_a_job_is_accepted_once(http: httpx.Client, store: Store, protocol: str) -> None:
    key = {"Idempotency-Key": uuid.uuid4().hex}
    first = http.post("/v1/jobs", content=protocol, headers=YAML | key)
    assert first.status_code == 202
    assert first.headers["location"] == f"/v1/jobs/{first.json()['id']}"
    count = sum(store.counts().values())
    again = http.post("/v1/jobs", content=protocol, headers=YAML | key)
    assert again.json()["id"] == first.json()["id"]
    other = http.post("/v1/jobs", content=protocol.replace("20 %", "10 %"), headers=YAML | key)
    problem(other, 422, "key-used")
    assert sum(store.counts().values()) == count
    assert store.spec(first.json()["id"]).protocol == protocol


def test_a_key_that_comes_at_once_from_many_is_one_job(address: str, store: Store, protocol: str) -> None:
    key = YAML | {"Idempotency-Key": uuid.uuid4().hex}
    count = sum(store.counts().values())
    together = threading.Barrier(8)

    def submit(_: int) -> httpx.Response:
        together.wait()
        return httpx.post(f"{address}/v1/jobs", content=protocol, headers=key, timeout=60.0)

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(submit, range(8)))
    assert {answer.status_code for answer in answers} == {202}
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert sum(store.counts().values()) == count + 1


def test_a_job_takes_name_timeout_and_materials(http: httpx.Client, store: Store, protocol: str) -> None:
    own = "schema: knitlab/materials@1\nmaterials:\n  mine: {young_modulus: {value: 1 GPa, source: guess},"
    own += " poisson_ratio: {value: 0.4, source: guess}}\n"
    text = protocol.replace("RGD8530-DM", "mine").replace("name: biaxial_small\n", "materials: own.yaml\n")
    answer = http.post("/v1/jobs?timeout=60", json={"protocol": text, "name": "mine-1", "materials": own})
    assert answer.status_code == 202, answer.text
    spec = store.spec(answer.json()["id"])
    assert (spec.name, spec.materials, spec.timeout) == ("mine-1", own, 60.0)


def test_a_job_that_has_not_changed_is_not_sent_again(http: httpx.Client, store: Store, job: Job) -> None:
    first = http.get(f"/v1/jobs/{job.id}")
    tag = first.headers["etag"]
    same = http.get(f"/v1/jobs/{job.id}", headers={"If-None-Match": f'"x", W/{tag}'})
    assert (same.status_code, same.content) == (304, b"")
    store.pause(job.id)
    new = http.get(f"/v1/jobs/{job.id}", headers={"If-None-Match": tag})
    assert new.json()["state"] == "paused"
    assert new.headers["etag"] != tag


def test_jobs_are_paged_newest_first(http: httpx.Client, store: Store, job: Job) -> None:
    specs = [store.spec(job.id)] * 5
    ids = [one.id for one in store.submit_all(specs)]
    sweep = store.get(ids[0]).sweep
    seen: list[str] = []
    cursor: str | None = None
    while True:
        page = http.get("/v1/jobs", params={"limit": 2, "sweep": sweep or "", **({"cursor": cursor} if cursor else {})})
        seen += [one["id"] for one in page.json()["jobs"]]
        assert {state: count for state, count in page.json()["counts"].items() if count} == {"queued": 5}
        cursor = page.json()["cursor"]
        if cursor is None:
            break
    assert seen == ids[::-1]
    store.cancel(ids[2])
    cancelled = http.get("/v1/jobs", params={"state": "cancelled", "sweep": sweep or ""}).json()["jobs"]
    assert [one["id"] for one in cancelled] == [ids[2]]
    for wrong in ("limit=0", "limit=5000", "cursor=-1", "cursor=1e3", "state=dead"):
        problem(http.get(f"/v1/jobs?{wrong}"), 422, "invalid-request")


@pytest.mark.parametrize(
    "path",
    ["/v1/jobs", "/v1/jobs/{job}", "/v1/jobs/{job}/files", "/v1/rigs", "/healthz", "/openapi.json", "/docs", "/"],
)
def test_head_answers_what_get_does_without_the_body(http: httpx.Client, job: Job, path: str) -> None:
    whole, head = (http.request(method, path.format(job=job.id)) for method in ("GET", "HEAD"))
    assert (head.status_code, head.content) == (200, b"")
    assert head.headers["content-type"] == whole.headers["content-type"]
    assert int(head.headers["content-length"]) == len(whole.content) > 0
    assert head.headers.get("etag") == whole.headers.get("etag")


def test_head_of_what_is_not_there_or_without_end(http: httpx.Client, job: Job) -> None:
    for path in ("/v1/jobs/nobody", "/v1/jobs/nobody/files/x", f"/v1/jobs/{job.id}/files/x", "/nothing"):
        assert http.head(path).status_code == 404
    events = http.head(f"/v1/jobs/{job.id}/events")
    assert (events.status_code, events.headers["content-type"].split(";")[0]) == (200, "text/event-stream")
    assert http.head(f"/v1/jobs/{job.id}/cancel").status_code == 405


def test_wishes_are_idempotent(http: httpx.Client, job: Job) -> None:
    for wish, state in (("pause", "paused"), ("resume", "queued"), ("cancel", "cancelled")):
        for _ in range(2):
            answer = http.post(f"/v1/jobs/{job.id}/{wish}")
            assert (answer.status_code, answer.json()["state"]) == (202, state)
    for wish in ("pause", "resume", "cancel"):
        assert http.post(f"/v1/jobs/{job.id}/{wish}").json()["state"] == "cancelled"


def test_a_job_is_deleted_once_it_has_ended(http: httpx.Client, store: Store, job: Job) -> None:
    store.files(job.id).write_spec(store.spec(job.id))
    for state, wish in (("queued", "pause"), ("paused", "cancel")):
        found = problem(http.delete(f"/v1/jobs/{job.id}"), 409, "not-ended")
        allowed = "allowed succeeded, failed or cancelled; cancel it first"
        assert found["detail"] == f"job '{job.id}': found {state}, {allowed}"
        http.post(f"/v1/jobs/{job.id}/{wish}")
    answer = http.delete(f"/v1/jobs/{job.id}")
    assert (answer.status_code, answer.content) == (204, b"")
    assert not store.files(job.id).path.exists()
    problem(http.delete(f"/v1/jobs/{job.id}"), 404, "unknown")
    problem(http.get(f"/v1/jobs/{job.id}"), 404, "unknown")
    assert job.id not in [one["id"] for one in http.get("/v1/jobs", params={"limit": 1000}).json()["jobs"]]


def test_a_stream_of_a_job_that_is_deleted_ends(http: httpx.Client, store: Store, job: Job) -> None:
    with http.stream("GET", f"/v1/jobs/{job.id}/events") as stream:
        lines = stream.iter_lines()
        assert next(lines) == "event: state"
        # Both between two looks of the stream, or one at a time: it ends either way.
        store.cancel(job.id)
        store.delete(job.id)
        assert all("Traceback" not in line for line in lines)


@pytest.mark.parametrize("path", ["", "/events", "/files", "/files/run/run.h5", "/log", "/cancel", "/pause", "/resume"])
def test_a_job_that_is_not_there(http: httpx.Client, path: str) -> None:
    if path == "":
        problem(http.delete("/v1/jobs/nobody"), 404, "unknown")
    method = "POST" if path in {"/cancel", "/pause", "/resume"} else "GET"
    problem(http.request(method, f"/v1/jobs/nobody{path}"), 404, "unknown")
    problem(http.request(method, f"/v1/jobs/no%00body{path}"), 422, "invalid-request")


def test_what_the_framework_refuses_is_a_problem_too(http: httpx.Client) -> None:
    for answer, status in ((http.get("/nothing"), 404), (http.delete("/v1/rigs"), 405)):
        assert answer.status_code == status
        assert answer.headers["content-type"] == "application/problem+json"
        assert answer.json()["type"] == "about:blank"
    for method, path, allowed in (
        ("DELETE", "/v1/jobs", "GET, HEAD, POST"),
        ("GET", "/v1/jobs/nobody/cancel", "POST"),
        ("POST", "/v1/jobs/nobody", "GET, HEAD, DELETE"),
        ("PUT", "/healthz", "GET, HEAD"),
    ):
        answer = http.request(method, path)
        assert (answer.status_code, answer.headers["allow"]) == (405, allowed)


def test_the_documentation_has_examples_that_run(http: httpx.Client) -> None:
    document = http.get("/openapi.json").json()
    assert http.get("/docs").status_code == 200
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            assert operation["summary"], path
            bodied = method == "post" and (not path.startswith("/v1/jobs/{job}") or path.endswith("/compare"))
            assert bodied == ("requestBody" in operation), path
            for content in operation.get("requestBody", {}).get("content", {}).values():
                assert "example" in content or "examples" in content, path
    assert http.post("/v1/jobs", content=EXAMPLE_YAML, headers=YAML).status_code == 202
    for path, body in (("/v1/jobs", EXAMPLE_JSON), ("/v1/sweeps", EXAMPLE_SWEEP)):
        assert http.post(path, json=body).status_code == 202
    assert "Protocol" in document["components"]["schemas"]


def test_no_trace_leaves_when_the_database_fails(tmp_path: Path, job: Job) -> None:
    with Store(settings(tmp_path, {})) as broken:
        with broken.engine.begin() as connection:
            connection.execute(sa.text("DROP TABLE knitlab_jobs"))
        with served(create_app(Context(store=broken)), quiet=True) as at:
            answer = httpx.get(f"{at}/v1/jobs/{job.id}")
    assert answer.status_code == 503
    assert "knitlab_jobs" not in answer.text


def test_no_trace_leaves_when_the_service_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError("knitlab_jobs")

    with Store(settings(tmp_path, {})) as broken:
        monkeypatch.setattr(Store, "get", fail)
        with served(create_app(Context(store=broken)), quiet=True) as at:
            answer = httpx.get(f"{at}/v1/jobs/{'0' * 16}")
    assert answer.status_code == 500
    assert answer.json()["detail"] == "the service failed; its log says how"
    assert "knitlab_jobs" not in answer.text
