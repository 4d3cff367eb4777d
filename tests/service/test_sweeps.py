"""Sweeps: all or none, each refusal at its place in the body, bounded in text and in time."""

from __future__ import annotations

import json
import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import httpx
import pytest
from anyio import CapacityLimiter

from app.schemas.materials import to_materials
from app.service.api.bounds import Bounds
from app.service.api.build import create_app
from app.service.api.concurrency import Turns
from app.service.api.context import Context
from app.service.api.documents import EXAMPLE_JSON, EXAMPLE_SWEEP
from app.service.api.sweeping import swept
from app.service.folder import JobFolder
from tests.service.lab import PATIENCE
from tests.service.serving import problem, served
from tests.service.test_rest import YAML

if TYPE_CHECKING:
    from app.schemas.document import Document
    from app.service.store import Store
    from knitlab_core.materials import Substance

OWN = """\
schema: knitlab/materials@1
materials:
  mine: {young_modulus: {value: 1 GPa, source: guess}, poisson_ratio: {value: 0.4, source: guess}}
"""
PEAK = '"${peak}"'


def place_of(http: httpx.Client, body: object, kind: str = "invalid-protocol") -> tuple[str, dict[str, Any]]:
    """Return the line for people and the one place of a sweep that is refused."""
    found = problem(http.post("/v1/sweeps", json=body), 422, kind)
    (place,) = found["errors"]
    return found["detail"], place


def brought(protocol: str) -> str:
    """Return the protocol with a material of its own."""
    return protocol.replace("RGD8530-DM", "mine").replace("log:", "materials: own.yaml\nlog:")


def test_a_sweep_is_accepted_whole(http: httpx.Client, store: Store, protocol: str) -> None:
    body = {"protocol": protocol, "values": {"peak": ["5 %", "10 %", 0.15]}}
    key = {"Idempotency-Key": uuid.uuid4().hex}
    answer = http.post("/v1/sweeps", json=body, headers=key)
    assert answer.status_code == 202, answer.text
    jobs = answer.json()["jobs"]
    assert [job["name"] for job in jobs] == ["biaxial_small-1", "biaxial_small-2", "biaxial_small-3"]
    assert {job["sweep"] for job in jobs} == {answer.json()["sweep"]}
    plans = [
        http.post("/v1/protocols:validate", content=store.spec(job["id"]).protocol, headers=YAML).json() for job in jobs
    ]
    lengths = plans[0]["specimen"]["gauge_lengths_m"]
    peaks = [plan["strokes"][1]["end_m"]["C"] / lengths["C"] for plan in plans]
    assert peaks == pytest.approx([0.05, 0.10, 0.15])
    assert http.post("/v1/sweeps", json=body, headers=key).json()["sweep"] == answer.json()["sweep"]
    own = protocol.replace("steps:", "sweep: {peak: [5 %, 10 %]}\nsteps:")
    assert http.post("/v1/sweeps", json={"protocol": own}).json()["count"] == 2
    listed = {"protocols": [{"protocol": protocol}, EXAMPLE_JSON]}
    assert http.post("/v1/sweeps", json=listed).json()["count"] == 2


@pytest.mark.parametrize(
    ("body", "kind"),
    [
        ({"protocols": []}, "invalid-request"),
        ({"protocols": [EXAMPLE_JSON, {**EXAMPLE_JSON, "rig": "x"}]}, "invalid-protocol"),
        ({**EXAMPLE_SWEEP, "values": {"peak": ["5 %", -1]}}, "invalid-protocol"),
        ({**EXAMPLE_SWEEP, "values": {"speed": [1]}}, "invalid-request"),
        ({**EXAMPLE_SWEEP, "values": {"peak": []}}, "invalid-request"),
        ({**EXAMPLE_SWEEP, "values": {"peak": [[1]]}}, "invalid-request"),
        ({**EXAMPLE_SWEEP, "values": {"peak": ["5 %"] * 10_001}}, "beyond-bound"),
        ([], "invalid-request"),
    ],
)
def test_a_sweep_is_refused_whole(http: httpx.Client, store: Store, body: object, kind: str) -> None:
    before = sum(store.counts().values())
    problem(http.post("/v1/sweeps", json=body), 422, kind)
    assert sum(store.counts().values()) == before


def test_a_refused_combination_is_named_and_found_in_the_text(http: httpx.Client, protocol: str) -> None:
    detail, place = place_of(http, {"protocol": protocol, "values": {"peak": ["5 %", "30 kg"]}})
    assert place["pointer"] == "/protocol/steps/1/cycle/upper"
    assert protocol.splitlines()[place["line"] - 1][place["column"] - 1 :].startswith(PEAK)
    assert detail.startswith("peak = '30 kg': line ")
    # In JSON the lines are nobody's own.
    detail, place = place_of(http, {"protocol": EXAMPLE_JSON, "values": {"peak": ["30 kg"]}})
    assert place["pointer"] == "/protocol/steps/1/cycle/upper"
    assert "line" not in place


def test_a_refused_protocol_is_found_in_its_text(http: httpx.Client, protocol: str) -> None:
    _, place = place_of(http, {"protocol": protocol.replace("8 mm", "8 kg"), "values": {"peak": ["5 %"]}})
    assert place["pointer"] == "/protocol/specimen/loop"
    assert protocol.splitlines()[place["line"] - 1][place["column"] - 1 :].startswith("8 mm")
    _, place = place_of(http, {"protocol": "a: [", "values": {"peak": [1]}})
    assert place["pointer"].startswith("/protocol")
    assert place["line"] == 1
    own = protocol.replace("steps:", "sweep: {speed: [5 %, 10 %]}\nsteps:")
    assert place_of(http, {"protocol": own}, "invalid-request")[1]["pointer"] == "/protocol/sweep/speed"


@pytest.mark.parametrize(
    ("second", "pointer", "lined"),
    [
        ({"protocol": "", "x": 1}, "/protocols/1/x", False),
        ({"protocol": 7}, "/protocols/1/protocol", False),
        ({**EXAMPLE_JSON, "rig": "x"}, "/protocols/1/rig", False),
        ({"protocol": {**EXAMPLE_JSON, "rig": "x"}}, "/protocols/1/protocol/rig", False),
        ({"protocol": "rig: x"}, "/protocols/1/protocol/rig", True),
    ],
)
def test_a_refused_protocol_of_a_list_is_found(
    http: httpx.Client, second: object, pointer: str, *, lined: bool
) -> None:
    body = {"protocols": [EXAMPLE_JSON, second]}
    found = http.post("/v1/sweeps", json=body).json()
    assert found["errors"][0]["pointer"] == pointer
    assert all(one["pointer"].startswith("/protocols/1") for one in found["errors"])
    assert ("line" in found["errors"][0]) == lined
    assert found["detail"].startswith("/protocols/1: ")


def test_a_bound_names_the_protocol_that_passes_it(http: httpx.Client, protocol: str) -> None:
    large = protocol.replace("loops: [2, 2]", "loops: [100, 100], nodes_per_loop: 1000")
    detail, place = place_of(http, {"protocols": [EXAMPLE_JSON, {"protocol": large}]}, "beyond-bound")
    assert place["pointer"] == "/protocols/1/protocol/specimen/loops"
    assert place["bound"] == Bounds().nodes
    assert detail.startswith("/protocols/1: ")
    some = protocol.replace("10 Hz", "100 Hz").replace("n: 1", "n: 1000")
    detail, place = place_of(http, {"protocol": some, "values": {"peak": ["1 %", "20 %"]}}, "beyond-bound")
    assert place["pointer"] == "/protocol/log/rate"
    assert detail.startswith("peak = '20 %': rows: ")
    # Hooks would pass through each other: known once the strokes are, and found in the text.
    detail, place = place_of(http, {"protocol": protocol, "values": {"peak": ["5 %", -0.999]}})
    assert place["pointer"].startswith("/protocol/")
    assert detail.startswith("peak = -0.999: line ")


def test_what_is_wrong_in_the_materials_is_found_there(http: httpx.Client, protocol: str) -> None:
    body = {"protocol": brought(protocol), "materials": OWN.replace("1 GPa", "1 m"), "values": {"peak": ["5 %"]}}
    _, place = place_of(http, body)
    assert place["pointer"].startswith("/materials/materials/mine/young_modulus")
    assert place["line"] == 3


def test_a_sweep_takes_limits(http: httpx.Client, store: Store, protocol: str) -> None:
    body = {"protocol": protocol, "values": {"peak": ["5 %", "10 %"]}}
    for sent in (body, {"protocols": [EXAMPLE_JSON, {"protocol": protocol}]}):
        answer = http.post(f"/v1/sweeps?timeout=60&memory={2**30}&pictures=false", json=sent)
        assert answer.status_code == 202, answer.text
        specs = [store.spec(job["id"]) for job in answer.json()["jobs"]]
        assert [(spec.timeout, spec.memory, spec.pictures) for spec in specs] == [(60.0, 2**30, False)] * 2
    # They are part of what a key stands for.
    key = {"Idempotency-Key": uuid.uuid4().hex}
    assert http.post("/v1/sweeps?timeout=60", json=body, headers=key).status_code == 202
    problem(http.post("/v1/sweeps?timeout=61", json=body, headers=key), 422, "key-used")
    for wrong in ("timeout=0", "timeout=nan", "memory=1", "pictures=some"):
        problem(http.post(f"/v1/sweeps?{wrong}", json=body), 422, "invalid-request")


def test_the_text_of_a_sweep_is_bounded(
    http: httpx.Client, store: Store, protocol: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = sum(store.counts().values())
    long = OWN + "#" * 950_000
    body = {"protocol": brought(protocol), "materials": long, "values": {"peak": [k / 1000 for k in range(1, 101)]}}
    read: list[object] = []
    monkeypatch.setattr("app.service.api.sweeping.loads_document", lambda *words, **_: read.append(words))
    detail, place = place_of(http, body, "beyond-bound")
    assert place == {"detail": detail, "pointer": "/values", "bound": Bounds().sweep_text}
    # Not one of its jobs was made before.
    assert not read
    monkeypatch.undo()
    assert sum(store.counts().values()) == before
    # A list brings no more text than its body has, but for what the indentation of JSON adds.
    few = Bounds(sweep_text=10 * len(protocol))
    with pytest.raises(Exception, match="beyond-bound"):
        swept({"protocols": [{"protocol": protocol}] * 11}, few)


def test_materials_are_read_once_for_a_whole_sweep(protocol: str, monkeypatch: pytest.MonkeyPatch) -> None:
    read = []

    def counted(document: Document) -> dict[str, Substance]:
        read.append(document.text)
        return to_materials(document)

    monkeypatch.setattr("app.schemas.named_files.to_materials", counted)
    entries = "".join(
        f"  m{k}: {{young_modulus: {{value: 1 GPa, source: s}}, poisson_ratio: {{value: 0.4, source: s}}}}\n"
        for k in range(9)
    )
    values = {"peak": [k / 1000 for k in range(1, 21)]}
    many = swept({"protocol": brought(protocol), "materials": OWN + entries, "values": values}, Bounds())
    assert read == [OWN + entries]
    assert [spec.materials for spec in many] == [OWN + entries] * 20


def test_sweeps_that_wait_are_bounded_and_hold_up_nothing_else(store: Store, protocol: str) -> None:
    # Somebody's sweep is being looked at, and takes its time.
    context = Context(store=store, sweeping=Turns(what="", again=30, limiter=CapacityLimiter(0)))
    body = {"protocol": protocol, "values": {"peak": ["5 %"]}}
    with served(create_app(context)) as at, ThreadPoolExecutor(20) as pool:
        asked = [pool.submit(httpx.post, f"{at}/v1/sweeps", json=body, timeout=60.0) for _ in range(20)]
        deadline = time.monotonic() + 30.0
        while sum(one.done() for one in asked) < 20 - context.sweeping.most and time.monotonic() < deadline:
            time.sleep(0.05)
        for one in asked:
            if one.done():
                problem(one.result(), 503, "busy")
                assert int(one.result().headers["retry-after"]) > 0
        assert sum(not one.done() for one in asked) == context.sweeping.most
        assert httpx.get(f"{at}/v1/rigs").status_code == 200
        context.sweeping.limiter.total_tokens = 1
        assert sum(one.result().status_code == 202 for one in asked) == context.sweeping.most


def own_sweep(protocol: str, line: str) -> dict[str, str]:
    """Return the body of a protocol with a sweep, or a design, of its own."""
    return {"protocol": protocol.replace("steps:", f"{line}\nsteps:")}


def test_a_sweep_is_planned_as_its_jobs_are(http: httpx.Client, store: Store, protocol: str) -> None:
    body = own_sweep(protocol, "sweep: {peak: [5 %, 10 %]}")
    before = sum(store.counts().values())
    plan = http.post("/v1/sweeps:validate", json=body).json()
    assert sum(store.counts().values()) == before
    assert (plan["count"], plan["looked_at"]) == (2, 2)
    assert [one["values"] for one in plan["points"]] == [{"peak": "5 %"}, {"peak": "10 %"}]
    jobs = http.post("/v1/sweeps", json=body).json()["jobs"]
    ones = [
        http.post("/v1/protocols:validate", content=store.spec(job["id"]).protocol, headers=YAML).json() for job in jobs
    ]
    for total in ("duration_s", "rows", "log_bytes"):
        assert plan[total] == pytest.approx(sum(one[total] for one in ones))
        assert [one[total] for one in plan["points"]] == [one[total] for one in ones]
    assert plan["first"] == ones[0]
    # Of many the first are looked at, the rest are like them.
    many = http.post("/v1/sweeps:validate", json=own_sweep(protocol, "sample: {points: 3000, of: {peak: [5 %, 10 %]}}"))
    assert many.json()["count"] == 3000
    assert many.json()["looked_at"] == len(many.json()["points"]) < 3000
    assert many.json()["duration_s"] == pytest.approx(1500 * plan["duration_s"], rel=0.02)


def test_a_sweep_where_one_test_is_wanted_is_told_so(http: httpx.Client, protocol: str) -> None:
    swept_text = own_sweep(protocol, "sweep: {peak: [5 %, 10 %]}")["protocol"]
    for route in ("/v1/protocols:validate", "/v1/jobs"):
        found = problem(http.post(route, content=swept_text, headers=YAML), 422, "swept")
        assert found["errors"][0]["pointer"] == "/sweep"
        assert "knitlab sweep" not in found["detail"]
    # A mistake of its own sweep has a line.
    for line in ("sweep: {speed: [5 %, 10 %]}", "sample: {points: 3, of: {speed: [5 %, 10 %]}}"):
        body = own_sweep(protocol, line)
        (place,) = http.post("/v1/sweeps:validate", json=body).json()["errors"]
        assert body["protocol"].splitlines()[place["line"] - 1] == line
        assert line[place["column"] - 1 :].startswith("speed")


def test_sweeps_are_listed_and_one_is_a_table(http: httpx.Client, store: Store, protocol: str) -> None:
    body = own_sweep(protocol, "sample: {points: 3, of: {peak: [5 %, 10 %]}}")
    sent = http.post("/v1/sweeps", json=body).json()
    other = http.post("/v1/sweeps", json={"protocols": [EXAMPLE_JSON]}).json()["sweep"]
    first, _, last = sent["jobs"]
    http.post(f"/v1/jobs/{last['id']}/cancel")
    files = JobFolder(store.folder(first["id"]))
    files.path.mkdir(parents=True)
    files.write_figures([("loop area", 2.5, "J/m3")])
    page = http.get("/v1/sweeps", params={"limit": 1}).json()
    assert page["sweeps"][0]["id"] == other
    page = http.get("/v1/sweeps", params={"limit": 1, "cursor": page["cursor"]}).json()
    (listed,) = page["sweeps"]
    assert (listed["id"], listed["name"]) == (sent["sweep"], "biaxial_small")
    assert {state: count for state, count in listed["counts"].items() if count} == {"queued": 2, "cancelled": 1}
    table = http.get(f"/v1/sweeps/{sent['sweep']}").json()
    assert table["sweep"] == listed
    assert (table["parameters"], table["figures"]) == (["peak"], [{"name": "loop area", "unit": "J/m3"}])
    assert [one["job"]["name"] for one in table["points"]] == [job["name"] for job in sent["jobs"]]
    assert [one["figures"] for one in table["points"]] == [[2.5], [], []]
    peaks = [float(one["values"]["peak"].removesuffix(" %")) for one in table["points"]]
    assert len(set(peaks)) == 3
    assert all(5.0 <= peak <= 10.0 for peak in peaks)
    rest = http.get(f"/v1/sweeps/{sent['sweep']}", params={"limit": 2}).json()
    rest = http.get(f"/v1/sweeps/{sent['sweep']}", params={"limit": 2, "cursor": rest["cursor"]}).json()
    assert [one["job"]["id"] for one in rest["points"]] == [last["id"]]
    assert rest["cursor"] is None
    problem(http.get("/v1/sweeps/none"), 404, "unknown")


@pytest.mark.slow
def test_ten_thousand_jobs_by_values_are_accepted(http: httpx.Client, store: Store, protocol: str) -> None:
    body = {"protocol": protocol, "values": {"peak": [0.01 + k * 1e-5 for k in range(10_000)]}}
    headers = {"Content-Type": "application/json"}
    answer = http.post("/v1/sweeps", content=json.dumps(body), headers=headers, timeout=PATIENCE)
    assert answer.json()["count"] == 10_000
    assert store.counts()["queued"] >= 10_000
