from __future__ import annotations

import json
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import httpx
import pytest
import sqlalchemy as sa

from app.cli.main import main
from app.client import Client, UnreachableError
from app.runs.use_cases import run_protocol
from app.schemas import loads
from app.service.errors import ServiceError
from app.service.jobs import JobSpec
from app.service.settings import settings
from app.service.store import Store
from app.service.tables import jobs as table
from tests.service.knitlab_serve import QUICK, ROOT, environment, knitlab, serving
from tests.service.lab import until

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

PEAK = '"${peak}"'


class Said(NamedTuple):
    """What a command answered."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with serving(tmp_path_factory.mktemp("serve"), "--slots", 1) as (address, _):
        yield address


@pytest.fixture
def say(service: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """Run commands in this process, where their imports cost but once."""
    monkeypatch.setenv("KNITLAB_SERVER", service)

    def command(*words: object) -> Said:
        monkeypatch.setattr(sys, "argv", ["knitlab", *map(str, words)])
        with pytest.raises(SystemExit) as raised:
            main()
        return Said(int(raised.value.code or 0), *capsys.readouterr())

    return command


def test_a_submitted_test_logs_what_a_run_logs(service: str, tmp_path: Path) -> None:
    protocol = tmp_path / "quick.yaml"
    protocol.write_text(QUICK, encoding="utf-8")
    said = knitlab(
        "submit", protocol, "--watch", "--no-pictures", "--quiet", "--json", folder=tmp_path, KNITLAB_SERVER=service
    )
    assert said.returncode == 0, said.stderr
    job = json.loads(said.stdout)
    assert (job["state"], job["end"], job["name"]) == ("succeeded", "target", "quick")
    assert job["progress"]["share"] == 1.0
    run = run_protocol(loads(QUICK), tmp_path / "here", draw=None)
    log = (run.folder / "quick.csv").read_bytes()
    assert len(log.splitlines()) > 50
    assert [Path(path).name for path in job["files"]] == ["quick.csv"]
    assert (tmp_path / job["files"][0]).read_bytes() == log
    # What came over the stream is what the record has.
    with Client(service) as client:
        events = list(client.follow(job["id"]))
        rows = [row for event in events if event.kind == "rows" for row in event.data["rows"]]
        assert [row["row"] for row in rows] == list(range(job["progress"]["rows"]))
        told = [event.data for event in events if event.kind == "progress"]
        assert all(one["seconds_left"] is None or one["seconds_left"] >= 0.0 for one in told)
        assert told[-1]["share"] == 1.0
        assert client.log(job["id"], "biotester", tmp_path / "log.csv").read_bytes() == log
        assert {one.name for one in client.files(job["id"])} >= {"run/run.h5", "run/quick.csv", "job.log"}


def test_jobs_are_steered_from_the_command_line(say: Callable[..., Said], tmp_path: Path) -> None:
    protocol = tmp_path / "long.yaml"
    protocol.write_text(QUICK.replace("n: 1", "n: 4000").replace("name: quick\n", ""), encoding="utf-8")
    job = say("submit", protocol).out.strip()
    assert re.fullmatch(r"[A-Za-z0-9_-]+", job)
    assert job in say("jobs").out
    assert job in [one["id"] for one in json.loads(say("jobs", "--json").out)]
    assert json.loads(say("jobs", "show", job, "--json").out)["name"] == "long"
    # It pauses at its checkpoint, or at once if it has not begun.
    assert say("jobs", "pause", job).out.split()[:2] in (["running", job], ["paused", job])
    assert say("jobs", "resume", job).out.split()[1] == job
    assert say("cancel", job).out.split()[0] in {"cancelled", "cancelling"}
    watched = say("watch", job, "--quiet", "--out", tmp_path / "out")
    assert watched.code == 130
    assert "cancelled" in watched.out
    refused = say("delete", running := say("submit", protocol).out.strip(), job)
    assert (refused.code, refused.out) == (2, f"deleted {job}\n")
    assert re.fullmatch(rf"job '{running}': found (queued|running), allowed .*; cancel it first\n", refused.err)
    say("cancel", running)
    assert say("watch", running, "--quiet", "--out", tmp_path / "out").code == 130
    assert json.loads(say("delete", running, "--json").out) == {"deleted": [running]}
    assert say("delete", running).err == f"job '{running}': there is none\n"


def test_old_jobs_are_deleted_where_that_is_asked_for(tmp_path: Path) -> None:
    with Store(settings(tmp_path, {})) as store:
        jobs = [store.submit(JobSpec(name="a", protocol=QUICK)).id for _ in range(3)]
        store.cancel(jobs[0])
        store.cancel(jobs[1])
        with store.engine.begin() as connection:
            old = sa.update(table).where(table.c.id == jobs[0]).values(finished=time.time() - 31 * 86400)
            connection.execute(old)
    with serving(tmp_path, "--slots", 0, "--keep", "30d") as (address, _), Client(address) as client:
        until(lambda: len(client.jobs().jobs) < 3)
        assert {job.id for job in client.jobs().jobs} == set(jobs[1:])


SWEPT = QUICK.replace("upper: 5 %", f"upper: {PEAK}") + "params: {peak: 5 %}\nsweep: {peak: [1 %, 2 %, 3 %]}\n"


def test_a_sweep_is_submitted_with_its_limits(say: Callable[..., Said], service: str, tmp_path: Path) -> None:
    protocol = tmp_path / "swept.yaml"
    protocol.write_text(SWEPT, encoding="utf-8")
    refused = say("submit", protocol, "--watch")
    assert (refused.code, refused.err) == (2, "--watch: found 'a sweep of 3 points', allowed one test\n")
    limits = ("--timeout", "2h", "--memory", "1GiB", "--no-pictures")
    sweep = say("submit", protocol, *limits).out.strip()
    listed = json.loads(say("jobs", "--sweep", sweep, "--json").out)
    assert [job["name"] for job in listed] == ["quick-3", "quick-2", "quick-1"]
    assert len(json.loads(say("submit", protocol, "--json").out)) == 3
    for words, complaint in (
        (("--timeout", "2 kg"), "--timeout: found '2 kg', allowed a time with its unit"),
        (("--memory", "8"), "--memory: found '8', allowed a size of memory with its unit"),
        (("--memory", "1 MiB"), "memory: "),
    ):
        said = say("submit", protocol, *words)
        assert (said.code, len(said.err.splitlines())) == (2, 1)
        assert said.err.startswith(complaint), said.err
    # What the command line asks for arrives: a job that may run for no time at all fails of it.
    with Client(service) as client:
        for job in client.jobs(limit=1000).jobs:
            client.cancel(job.id)
        short = say("submit", protocol, "--timeout", "1 ms", "--no-pictures").out.strip()
        assert list(client.follow(client.jobs(sweep=short).jobs[-1].id))[-1].data["end"] == "timeout"


def test_a_client_sweeps_over_values_and_lists(tmp_path: Path) -> None:
    with serving(tmp_path, "--slots", 0) as (address, _), Client(address) as client:
        over = client.sweep(SWEPT, values={"peak": ["1 %", 0.02]}, timeout=60.0, memory=2**30, pictures=False)
        assert [job.name for job in over] == ["quick-1", "quick-2"]
        assert [job.name for job in client.sweep(SWEPT, name="other")] == ["quick-1", "quick-2", "quick-3"]
        assert len(client.sweep([QUICK, QUICK], timeout=60.0)) == 2
        client.submit(QUICK, timeout=60.0, memory=2**30)
    with Store(settings(tmp_path, {})) as store:
        specs = [store.spec(job.id) for job in store.list(limit=100).jobs]
        assert [(spec.timeout, spec.memory, spec.pictures) for spec in specs] == [
            (60.0, 2**30, True),
            *[(60.0, 8 * 2**30, True)] * 2,
            *[(None, 8 * 2**30, True)] * 3,
            *[(60.0, 2**30, False)] * 2,
        ]


def test_open_streams_do_not_hold_up_the_end(tmp_path: Path) -> None:
    with serving(tmp_path, "--slots", 0) as (address, process), Client(address) as client:
        job = client.submit(QUICK)
        events = client.events(job.id)
        assert next(events).kind == "state"
        process.terminate()
        assert list(events) == []
        assert process.wait(timeout=30) == 0
        # None of them was cut off when its time to end was over.
        assert process.stderr is not None
        assert "graceful" not in process.stderr.read()


def test_every_example_of_the_documentation_runs(service: str, tmp_path: Path) -> None:
    text = (ROOT / "docs" / "service.md").read_text(encoding="utf-8").replace("http://127.0.0.1:8731", service)
    shell, python = (
        "\n".join(re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE))
        for language in ("sh", "python")
    )
    assert shell.count("curl") > 15
    assert shell.count("knitlab ") > 5
    (tmp_path / "examples").mkdir()
    quick = QUICK.replace("quick", "biaxial_small").replace("upper: 5 %", f"upper: {PEAK}") + "params: {peak: 5 %}\n"
    (tmp_path / "examples" / "biaxial_small.yaml").write_text(quick, encoding="utf-8")
    (tmp_path / "examples" / "swept.yaml").write_text(SWEPT, encoding="utf-8")
    command = f'knitlab() {{ "{sys.executable}" -P -c "from app.cli.main import main; main()" "$@"; }}\n'
    for program in (["/bin/bash", "-euo", "pipefail", "-c", command + shell], [sys.executable, "-c", python]):
        ran = subprocess.run(  # noqa: S603 (our own documentation)
            program,
            cwd=tmp_path,
            env=environment(KNITLAB_SERVER=service),
            capture_output=True,
            text=True,
            check=False,
            timeout=240,
        )
        assert ran.returncode == 0, ran.stdout[-2000:] + ran.stderr[-2000:]
    assert (tmp_path / "head.bin").read_bytes() == b"\x89HDF\r\n\x1a\n"
    assert len(json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))["jobs"]) == 2
    logs = [tmp_path / "here" / "biaxial_small.csv", tmp_path / "log.csv"]
    assert logs[0].read_bytes() == logs[1].read_bytes()
    # Each route has its example.
    routes = httpx.get(f"{service}/openapi.json").json()["paths"]
    for route in routes:
        part = route.replace("/v1/jobs/{job}", "").partition("/{")[0] or "/v1/jobs"
        assert part in shell, route


def test_no_service(tmp_path: Path) -> None:
    said = knitlab("jobs", "--server", "http://127.0.0.1:1", folder=tmp_path)
    assert said.returncode == 5
    assert said.stderr.startswith("http://127.0.0.1:1: ")
    assert len(said.stderr.splitlines()) == 1
    for server in ("http://127.0.0.1:1", "nonsense", "http://[bad"):
        with pytest.raises(UnreachableError), Client(server) as client:
            client.jobs()


def test_mistakes_are_one_line(service: str, say: Callable[..., Said], tmp_path: Path) -> None:
    wrong = tmp_path / "p.yaml"
    wrong.write_text(QUICK.replace("biaxial-hook", "hook"), encoding="utf-8")
    for words, part in (
        (("submit", wrong), "p.yaml:3:6: rig"),
        (("watch", "nobody"), "job 'nobody': there is none"),
        (("cancel", "../x"), "no such route"),
        (("serve", "--host", "192.0.2.1", "--data", tmp_path), "host: found '192.0.2.1'"),
        (("serve", "--keep", "0 s", "--data", tmp_path), "--keep: found '0 s', allowed a time above zero"),
        (("serve", "--keep", "30", "--data", tmp_path), "--keep: found '30', allowed a time with its unit"),
        (("serve", "--max-connections", 10**7, "--data", tmp_path), "--max-connections: found 10000000, allowed"),
        (("serve", "--port", service.rpartition(":")[2], "--data", tmp_path), "address already in use"),
    ):
        said = say(*words)
        assert said.code == 2, (words, said.err)
        assert part in said.err
        assert len(said.err.splitlines()) == 1, said.err


@pytest.mark.slow
def test_a_service_with_a_token(tmp_path: Path) -> None:
    with serving(tmp_path, "--slots", 0, "--host", "0.0.0.0", KNITLAB_TOKEN="s3cret") as (address, process):  # noqa: S104, S106
        local = address.replace("0.0.0.0", "127.0.0.1")  # noqa: S104 (it asks for a token)
        with Client(local, "s3cret") as client:
            job = client.submit(QUICK, key="once")
            assert client.submit(QUICK, key="once").id == job.id
            with pytest.raises(ServiceError, match="another body"):
                client.submit(QUICK.replace("5 %", "6 %"), key="once")
            assert [one.id for one in client.jobs().jobs] == [job.id]
            assert [one.state for one in client.sweep([QUICK, QUICK])] == ["queued"] * 2
        with Client(local, "guess") as client, pytest.raises(ServiceError, match="token") as refused:
            client.jobs()
        assert refused.value.status == 401
        process.terminate()
        # It leaves when it is asked to, and keeps what it was given.
        assert process.wait(timeout=60) == 0
    with serving(tmp_path, "--slots", 0) as (address, _), Client(address) as client:
        assert client.job(job.id).state == "queued"
