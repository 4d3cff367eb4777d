"""The report of a job, and a measured file over its test."""

from __future__ import annotations

import math
from shutil import copyfile
from typing import TYPE_CHECKING

import pytest

from app.client import Client, ServiceError
from app.records.export import export_log
from app.records.reader import read_run
from app.schemas import loads, to_yaml
from app.service.api.bounds import Bounds
from app.service.folder import JobFolder
from app.service.jobs import Job, JobSpec
from app.service.row_file import restore
from app.views.overlay import compare
from rigs.analysis.alignment import Alignment
from tests.service.serving import problem
from tests.synthetic_run import PROTOCOL, make_run

if TYPE_CHECKING:
    from pathlib import Path

    import httpx

    from app.service.store import Store

CSV = {"Content-Type": "text/csv"}


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the record of a test on a small knit."""
    return make_run(tmp_path_factory.mktemp("record") / "run.h5", protocol=PROTOCOL.replace("[6, 6]", "[2, 2]")).path


@pytest.fixture(scope="module")
def log(record: Path) -> Path:
    """Write its log as the instrument would: what a user may send."""
    return export_log(read_run(record), record.parent, "biotester")


@pytest.fixture
def done(store: Store, protocol: str, record: Path) -> Job:
    """Put the record of a test that has been run into the folder of a job."""
    job = store.submit(JobSpec(name="made", protocol=protocol))
    files = JobFolder(store.folder(job.id))
    files.run.mkdir(parents=True)
    copyfile(record, files.run / "run.h5")
    return job


@pytest.mark.slow
def test_the_report_of_a_job_is_a_page_that_does_nothing(http: httpx.Client, done: Job) -> None:
    answer = http.get(f"/v1/jobs/{done.id}/report")
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert answer.headers["content-disposition"] == "attachment; filename*=utf-8''synthetic_report.html"
    assert "sandbox" in answer.headers["content-security-policy"]
    assert "loops: [2, 2]" in answer.text
    assert "<script" not in answer.text


@pytest.mark.slow
def test_the_client_fetches_a_report(address: str, done: Job, tmp_path: Path) -> None:
    with Client(address) as client:
        page = client.report(done.id, tmp_path / "new" / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    assert "loops: [2, 2]" in page


def test_a_job_without_a_record_has_no_report_and_no_comparison(http: httpx.Client, job: Job) -> None:
    problem(http.get(f"/v1/jobs/{job.id}/report"), 409, "not-ready")
    problem(http.post(f"/v1/jobs/{job.id}/compare", content=b"a", headers=CSV), 409, "not-ready")
    problem(http.get("/v1/jobs/none/report"), 404, "unknown")
    problem(http.post("/v1/jobs/none/compare", content=b"a", headers=CSV), 404, "unknown")


def test_a_file_over_a_job_has_the_scores_of_the_command(
    http: httpx.Client, done: Job, record: Path, log: Path, tmp_path: Path
) -> None:
    answer = http.post(f"/v1/jobs/{done.id}/compare", params={"name": "<b>.csv"}, content=log.read_bytes(), headers=CSV)
    assert answer.status_code == 200, answer.text
    found = answer.json()
    assert (found["across"], found["along"]) == ("strain", "stress")
    same = compare([log, record], tmp_path / "over.png").scores
    wanted = {(axis, figure): value for _, axis, _, figure, value, *_ in same.rows() if figure == "NRMSE"}
    scores = {(one["axis"], one["figure"]): one["value"] for one in found["scores"] if one["figure"] == "NRMSE"}
    assert scores == pytest.approx(wanted)
    assert set(wanted) == {("C", "NRMSE"), ("W", "NRMSE")}
    parts = {(one["name"], one["axis"], one["part"]) for one in found["curves"]}
    assert ("<b>.csv", "C", "loading") in parts
    assert ("synthetic", "W", "unloading") in parts
    assert all(len(one["x"]) == len(one["y"]) <= 2000 for one in found["curves"])


def test_the_client_lays_a_file_over_a_job(
    address: str, done: Job, job: Job, record: Path, log: Path, tmp_path: Path
) -> None:
    with Client(address) as client:
        found = client.compare(done.id, log, axis="W", cycle=2)
        with pytest.raises(ServiceError, match=r"gauge_length: found .*0 mm"):
            client.compare(done.id, log, gauge_length="0 mm")
        (tmp_path / "fabric.csv").write_text("Time [s],Load [N],Extension [mm]\n0,0,0\n1,x,1\n")
        with pytest.raises(ServiceError, match=r"fabric\.csv, line 3: expected"):
            client.compare(done.id, tmp_path / "fabric.csv")
        for call in (lambda: client.compare(job.id, log), lambda: client.report(job.id, tmp_path / "none.html")):
            with pytest.raises(ServiceError) as raised:
                call()
            assert (raised.value.status, raised.value.kind) == (409, "not-ready")
    assert not (tmp_path / "none.html").exists()
    same = compare([log, record], axis="W", alignment=Alignment(cycle=2)).scores
    wanted = {(name, figure): value for name, _, _, figure, value, *_ in same.rows()}
    assert {(one.name, one.figure): one.value for one in found.scores} == pytest.approx(wanted, nan_ok=True)
    measured = next(one for one in found.curves if one.measured)
    assert (found.across, found.along, measured.name) == ("strain", "stress", log.name)
    assert len(measured.x) == len(measured.y) > 10


def test_the_curves_of_a_job_are_its_rows(http: httpx.Client, store: Store, done: Job, record: Path) -> None:
    rows = store.files(done.id).rows_file
    run = read_run(record)
    restore(rows, run)
    found = http.get(f"/v1/jobs/{done.id}/curves").json()
    columns = run.trace.columns
    assert found["rows"] == len(run.trace)
    assert found["cycle"] == columns["cycle"].tolist()
    for axis in ("C", "W"):
        assert found["force"][axis] == columns[f"force_{axis}"].tolist()
        assert found["strain"][axis] == pytest.approx(columns[f"displacement_{axis}"] / run.size.extents[axis])
        assert found["stress"][axis] == pytest.approx(columns[f"force_{axis}"] / found["section"][axis])
    # Of a long test what can be seen is sent: ends and extremes, in order.
    line = '{{"time": {0}, "cycle": 1, "strain": {{"C": {0}, "W": 0}}, "force": {{"C": {1}, "W": {2}}}}}\n'
    force = [(math.sin(k / 900) + (9.0 if k == 7777 else 0.0), -5.0 if k == 12345 else 0.0) for k in range(20_000)]
    rows.write_text("".join(line.format(k, *both) for k, both in enumerate(force)) + '{"time": 1')
    found = http.get(f"/v1/jobs/{done.id}/curves").json()
    assert found["rows"] == 20_000
    assert 1000 < len(found["time"]) <= 4200
    assert found["time"] == sorted(found["time"])
    assert (found["time"][0], found["time"][-1]) == (0, 19_999)
    assert (max(found["force"]["C"]), min(found["force"]["W"])) == (max(one for one, _ in force), -5.0)


def test_the_figures_and_the_protocol_of_a_job(http: httpx.Client, store: Store, done: Job, protocol: str) -> None:
    problem(http.get(f"/v1/jobs/{done.id}/figures"), 409, "not-ready")
    store.files(done.id).write_figures([("loop area", 2.5, "J/m3")])
    found = http.get(f"/v1/jobs/{done.id}/figures").json()["figures"]
    assert found == [{"name": "loop area", "value": 2.5, "unit": "J/m3"}]
    # As it was sent; what came as JSON is written as people write it.
    assert http.get(f"/v1/jobs/{done.id}/protocol").json() == {"name": "made", "protocol": protocol, "materials": ""}
    sent = http.post("/v1/sweeps", json={"protocol": protocol, "values": {"peak": ["5 %"]}}).json()["jobs"][0]["id"]
    text = http.get(f"/v1/jobs/{sent}/protocol").json()["protocol"]
    assert "\n  loops: [2, 2]\n" in text
    assert to_yaml(loads(text).protocol) == to_yaml(loads(store.spec(sent).protocol).protocol)
    for part in ("curves", "figures", "protocol"):
        problem(http.get(f"/v1/jobs/none/{part}"), 404, "unknown")


def test_one_axis_and_another_cycle(http: httpx.Client, done: Job, log: Path) -> None:
    where = f"/v1/jobs/{done.id}/compare"
    content = log.read_bytes()
    found = http.post(where, params={"axis": "W", "cycle": 2}, content=content, headers=CSV).json()
    assert {one["axis"] for one in found["curves"]} == {"W"}
    assert {one["cycle"] for one in found["scores"]} == {2}
    beyond = problem(http.post(where, params={"cycle": 9}, content=content, headers=CSV), 422, "invalid-request")
    assert beyond["errors"][0]["parameter"] == "cycle"
    for name, value in (("slack", "3 mm"), ("gauge_length", "0 mm"), ("width", "wide"), ("axis", "Q"), ("cycle", "0")):
        refused = problem(http.post(where, params={name: value}, content=content, headers=CSV), 422, "invalid-request")
        assert refused["errors"][0]["parameter"] == name


@pytest.mark.parametrize(
    ("content", "line", "words"),
    [
        (b"Time [s],Load [N],Extension [mm]\n0,0,0\n1,x,1\n", 3, "Load"),
        (b"Time [s],Load,Extension [mm]\n0,0,0\n1,1,1\n", 1, "unit"),
        (b"PK\x03\x04\x00\x00", 1, "text"),
        (b"", 1, "expected"),
        (b"<html><script>alert(1)</script></html>", 1, "expected"),
        (
            b"repeat,Time [s],Load [N],Extension [mm]\n" + b"".join(b"%d,0,0,0\n" % k for k in range(1200)),
            2,
            "1000 repeats",
        ),
    ],
)
def test_what_is_no_table_is_refused_with_its_line(
    http: httpx.Client, done: Job, content: bytes, line: int, words: str
) -> None:
    answer = http.post(f"/v1/jobs/{done.id}/compare", params={"name": "fabric.csv"}, content=content, headers=CSV)
    refused = problem(answer, 422, "invalid-request")
    assert refused["detail"].startswith(f"fabric.csv, line {line}: expected")
    assert words in refused["detail"]
    assert refused["errors"][0]["line"] == line
    assert "/tmp" not in answer.text  # noqa: S108 (no path of the service leaves)


def test_a_file_is_bounded_and_of_its_kind(http: httpx.Client, done: Job) -> None:
    where = f"/v1/jobs/{done.id}/compare"
    most = Bounds().measured
    refused = problem(http.post(where, content=b"1" * (most + 1), headers=CSV), 413, "too-large")
    assert refused["errors"][0]["bound"] == most
    problem(http.post(where, content=b"a", headers={"Content-Type": "application/zip"}), 415, "media-type")
