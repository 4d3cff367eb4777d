"""Files that are sent with a protocol, and what the service gives to write one: schemas and examples."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from app.client import Client, ServiceError
from app.schemas import json_schema, load
from app.service.api.documents import MOST_FILES
from app.service.api.library import examples
from tests.service.serving import problem

if TYPE_CHECKING:
    import httpx

    from app.service.store import Store

EXAMPLES = Path(__file__).parents[2] / "examples"
SERPENTINE = (EXAMPLES / "serpentine_small.yaml").read_text(encoding="utf-8")
POINTS = (EXAMPLES / "serpentine.csv").read_text(encoding="utf-8")
WITH_FILE = {"protocol": SERPENTINE, "files": {"serpentine.csv": POINTS}}


def refusal(http: httpx.Client, body: dict[str, Any], path: str = "/v1/protocols:validate") -> dict[str, Any]:
    """Return the first place of the problem that a body is answered with."""
    answer = http.post(path, json=body)
    found = problem(answer, 422, "invalid-protocol")
    place: dict[str, Any] = found["errors"][0]
    return {**place, "whole": found["detail"]}


def test_a_centreline_goes_with_the_protocol_to_every_route(http: httpx.Client, store: Store) -> None:
    plan = http.post("/v1/protocols:validate", json=WITH_FILE).raise_for_status().json()
    seen = http.post("/v1/specimens:preview", json=WITH_FILE).raise_for_status().json()
    assert plan["specimen"]["nodes"] == seen["nodes"] == 73
    job = store.get(http.post("/v1/jobs", json=WITH_FILE).raise_for_status().json()["id"])
    # What runs needs no file: the points are in its protocol.
    spec = store.spec(job.id)
    checked = http.post("/v1/protocols:validate", json={"protocol": spec.protocol}).raise_for_status().json()
    assert spec.materials == ""
    assert checked["specimen"] == plan["specimen"]
    swept = {
        **WITH_FILE,
        "protocol": SERPENTINE.replace("steps:", "params: {r: 1 mm/s}\nsteps:").replace("rate: 1 mm/s", 'rate: "${r}"'),
        "values": {"r": ["1 mm/s"]},
    }
    assert http.post("/v1/sweeps", json=swept).raise_for_status().json()["count"] == 1


def test_the_client_sends_files(address: str, store: Store) -> None:
    with Client(address) as client:
        job = client.submit(SERPENTINE, files={"serpentine.csv": POINTS}, pictures=False)
        with pytest.raises(ServiceError, match=r"serpentine\.csv"):
            client.submit(SERPENTINE)
    assert "serpentine.csv" not in store.spec(job.id).protocol


def test_a_mistake_in_a_file_is_told_with_its_name_and_line(http: httpx.Client) -> None:
    spoilt = {"protocol": SERPENTINE, "files": {"serpentine.csv": POINTS.replace("course-", "curse-")}}
    found = refusal(http, spoilt)
    assert (found["file"], found["line"], found["column"]) == ("serpentine.csv", 2, 1)
    assert found["whole"].startswith("serpentine.csv, line 2, column 1: site: found 'curse-', allowed ")
    listed = refusal(http, {"protocols": [WITH_FILE, spoilt]}, "/v1/sweeps")
    assert listed["pointer"] == "/protocols/1/files/serpentine.csv/site"
    # Of one that is not there the protocol is to blame, with the names of those that are.
    missing = refusal(http, {"protocol": SERPENTINE, "files": {"other.csv": POINTS}})
    assert missing["detail"].endswith("found serpentine.csv, allowed a file that came with the protocol: other.csv")
    assert (missing["pointer"], missing["line"], missing.get("file")) == ("/specimen/knit/centreline", 8, None)


@pytest.mark.parametrize(
    ("files", "says"),
    [
        ({"../serpentine.csv": POINTS}, "files: found '../serpentine.csv', allowed a name such as my-knit.csv"),
        ({"/etc/passwd.csv": ""}, "files: found '/etc/passwd.csv'"),
        ({"a\\b.csv": ""}, "files: found "),
        ({"a\nb.csv": ""}, "files: found "),
        ({"x" * 197 + ".csv": ""}, "files: found "),
        ({"my.yaml": ""}, "materials go under materials"),
        ({"": ""}, "files: found ''"),
        ({"a.csv": 1}, "files: found a value of another kind"),
        ({"a.csv": "", "./a.csv": ""}, "files: found the same file twice"),
        ([], "files: found a value of another kind, allowed texts by name"),
        (
            {f"{n}.csv": "" for n in range(MOST_FILES + 1)},
            f"files: found {MOST_FILES + 1}, allowed {MOST_FILES} or fewer",
        ),
    ],
)
def test_names_of_files_lead_nowhere_else(http: httpx.Client, files: object, says: str) -> None:
    answer = http.post("/v1/protocols:validate", json={"protocol": SERPENTINE, "files": files})
    kind = "beyond-bound" if "or fewer" in says else "invalid-request"
    assert says in problem(answer, 422, kind)["detail"]


def test_files_count_among_what_is_bounded(http: httpx.Client) -> None:
    answer = http.post("/v1/protocols:validate", json={**WITH_FILE, "files": {"serpentine.csv": POINTS * 1200}})
    assert problem(answer, 413, "too-large")["errors"][0]["bound"] == 1_000_000


def test_the_schema_that_is_served_is_that_of_the_files(http: httpx.Client) -> None:
    assert http.get("/v1/schemas/protocol").raise_for_status().json() == json_schema()
    assert "materials" in http.get("/v1/schemas/material").raise_for_status().json()["properties"]
    assert problem(http.get("/v1/schemas/other"), 422, "invalid-request")


def test_every_example_is_listed_and_complete(http: httpx.Client) -> None:
    listed = {one["path"]: one for one in http.get("/v1/examples").raise_for_status().json()["examples"]}
    written = {path for path in EXAMPLES.rglob("*.yaml") if "knitlab/protocol@1" in path.read_text(encoding="utf-8")}
    assert set(listed) == {path.relative_to(EXAMPLES).with_suffix("").as_posix() for path in written}
    assert all(one["purpose"].endswith(".") for one in listed.values())
    assert listed["fabric/rib_course"] == {
        "path": "fabric/rib_course",
        "group": "fabric",
        "title": "rib course",
        "purpose": "Rib: relaxed acrylic with 11.28 mm of yarn in each stitch, "
        "pulled along the course with its sides free.",
        "rig": "uniaxial-frame",
    }
    for path in ("fabric/rib_course", "creeping_small", "serpentine_small"):
        texts = http.get(f"/v1/examples/{path}").raise_for_status().json()
        assert texts["protocol"] == (EXAMPLES / f"{path}.yaml").read_text(encoding="utf-8")
        plan = http.post("/v1/protocols:validate", json=texts).raise_for_status().json()
        assert plan["specimen"]["nodes"] > 0
        assert load(EXAMPLES / f"{path}.yaml").protocol.rig == listed[path]["rig"]


@pytest.mark.parametrize("path", ["fabric/measured/course", "../pyproject", "..%2Fpyproject", "nothing"])
def test_what_is_no_example_is_not_served(http: httpx.Client, path: str) -> None:
    assert http.get(f"/v1/examples/{path}").status_code == 404
    assert path not in examples()
