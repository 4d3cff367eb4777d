"""Runs whose disk is full or closed to them: one line, an exit code, every row kept, and how it goes on."""

from __future__ import annotations

import errno
import os
import shutil
import subprocess
import sys
import tracemalloc
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
import sqlalchemy as sa

from app.cli.main import main
from app.records.export import export_run
from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.sampled import samples_of
from app.records.stored_log import StoredLog
from app.records.writer import RunWriter
from app.runs.provenance import provenance
from app.runs.stopped import kept_in
from app.schemas import loads
from app.schemas.machine_data import machines_of
from app.service import job_process
from app.service.api.build import create_app
from app.service.api.context import Context
from app.service.folder import JobFolder
from app.service.settings import settings
from app.service.store import Store, StoreAwayError
from knitlab_core.errors import SpecificationError
from rigs.instruments.ticks import PART
from tests.app.records.test_records import writer
from tests.app.runs.test_resume import CHILD, ROOT, SHORT
from tests.service.serving import problem, served
from tests.service.test_rest import YAML
from tests.synthetic_run import BOTH, PROTOCOL, SIZE, rows, stage_instrument

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits of file sizes and tmpfs are Unix")

LIMITED = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))\n"


def knitlab(*words: object, limit: int | None = None) -> tuple[int, str]:
    """Run a command without pictures, with files of at most so many bytes; return its exit code and what it said."""
    text = ("" if limit is None else LIMITED.format(limit=limit)) + CHILD
    plain = ["--no-pictures"] if words[0] in {"run", "resume"} else []
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-P", "-c", text, *map(str, words), *plain],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    return done.returncode, done.stderr


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run that found room, its protocol beside it."""
    folder = tmp_path_factory.mktemp("Disk")
    (folder / "short.yaml").write_text(SHORT.replace("name: elastic", "name: Short"), encoding="utf-8")
    assert knitlab("run", folder / "short.yaml", "--out", folder / "Whole", "-q") == (0, "")
    return folder / "Whole"


def test_a_run_without_room_says_what_is_kept_and_goes_on(whole: Path) -> None:
    folder, room = whole.with_name("Full"), (whole / "run.h5").stat().st_size - 200_000
    code, said = knitlab("run", whole.parent / "short.yaml", "--out", folder, "-q", limit=room)
    rows = len(RunReader(folder / "run.h5").trace)
    assert rows > 0
    kept = f"{rows} rows kept; when that is mended go on with: knitlab resume {folder}"
    assert (code, said) == (7, f"{folder}: file too large; {kept}\n")
    assert RunReader(folder / "run.h5").going_on
    code, said = knitlab("resume", folder, "-q")
    # The disk may have been full before the first checkpoint.
    assert (code, said) in {(0, ""), (0, f"{folder}: no checkpoint to go on from: starts from the beginning\n")}
    assert (folder / "Short.csv").read_bytes() == (whole / "Short.csv").read_bytes()
    assert {one.name for one in folder.iterdir()} == {one.name for one in whole.iterdir()}


def test_a_run_without_room_for_anything_says_so(whole: Path) -> None:
    folder = whole.with_name("Nothing")
    code, said = knitlab("run", whole.parent / "short.yaml", "--out", folder, "-q", limit=1000)
    assert (code, said) == (7, f"{folder}: run.h5: file too large; nothing was recorded\n")


@pytest.fixture
def closed(tmp_path: Path) -> Iterator[Path]:
    """Lend a folder in which nothing can be written, by rights or, for root, by a disk that is read-only."""
    folder = tmp_path / "Closed"
    folder.mkdir()
    with ExitStack() as stack:
        if os.geteuid() == 0:
            command = ["mount", "-t", "tmpfs", "-o", "ro,size=1m", "knitlab-test", str(folder)]
            if shutil.which("mount") is None or subprocess.run(command, capture_output=True, check=False).returncode:  # noqa: S603
                pytest.skip("root may write everywhere, and this one may not mount a disk that is read-only")
            stack.callback(subprocess.run, ["umount", str(folder)], check=True)
        else:
            folder.chmod(0o500)
            stack.callback(folder.chmod, 0o700)
        yield folder


def test_a_folder_that_is_closed_is_one_line(whole: Path, closed: Path) -> None:
    code, said = knitlab("run", whole.parent / "short.yaml", "--out", closed / "Run", "-q")
    assert code == 7
    assert said.startswith(f"{closed / 'Run'}: ")
    assert said.endswith("; nothing was recorded\n")
    code, said = knitlab("export", whole, "--out", closed)
    assert code in {2, 7}
    assert said.startswith(f"{closed}/")
    assert said.count("\n") == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_output_that_finds_no_room_is_one_line() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(  # noqa: S603
            [sys.executable, "-P", "-c", CHILD, "materials"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
    assert (done.returncode, done.stderr) == (7, "output: no space left on device\n")


def test_no_run_is_one_line_with_its_own_letters(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "NoSuchRun"
    for command in ("resume", "export", "analyse", "plot", "images"):
        monkeypatch.setattr(sys, "argv", ["knitlab", command, str(missing)])
        with pytest.raises(SystemExit) as left:
            main()
        assert left.value.code == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert "NoSuchRun" in said
        assert "HDF5" not in said
        assert "synchronously" not in said


def test_a_killed_run_is_exported_up_to_its_last_row(whole: Path, tmp_path: Path) -> None:
    folder = tmp_path / "Killed"
    die = "import os; from app.records.writer import RunWriter; keep = RunWriter.append; \ndef append(self, row):\n"
    die += "    keep(self, row)\n"
    die += "    if self.rows == 4: os.kill(os.getpid(), 9)\nRunWriter.append = append\n"
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-P", "-c", die + CHILD, "run", whole.parent / "short.yaml", "--out", folder, "-q"],
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == -9
    assert len(RunReader(folder / "run.h5").trace) == 4
    (log,) = export_run(folder)
    lines, all_lines = log.read_bytes().splitlines(), (whole / "Short.csv").read_bytes().splitlines()
    assert 2 <= len(lines) <= len(all_lines)
    # The last sample of a killed run rests on no row after it.
    assert lines[:-1] == all_lines[: len(lines) - 1]
    # Its samples are computed into a file, from which they are read part by part.
    with samples_of(RunReader(folder / "run.h5")) as samples:
        (table,) = samples.values()
        assert isinstance(table, StoredLog)
        assert table.path.parent != folder
        assert len(table.part(0, 2)) == 2
    assert not table.path.exists()


@pytest.mark.slow
def test_memory_does_not_grow_with_the_samples_of_a_killed_run(tmp_path: Path) -> None:
    text, most = PROTOCOL.replace("rate: 10 Hz", "rate: 100 Hz"), {}
    loaded = loads(text, "protocol.yaml")
    facts = provenance(loaded.protocol, machines_of(loaded.protocol))
    for turns in (1, 4):
        folder = tmp_path / str(turns)
        folder.mkdir()
        path = make_record(
            folder / "run.h5",
            protocol=text,
            size=SIZE,
            axes=BOTH,
            strands=[4],
            instruments=[stage_instrument()],
            provenance={**facts, "started": "2026-01-31T09:00:00+01:00"},
        )
        with RunWriter(path) as record:
            for turn in range(turns):
                for one in rows(steps=5):
                    record.append(replace(one, time=one.time + turn * 400.0))
        tracemalloc.start()
        (log,) = export_run(folder)
        most[turns] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        # More samples than are in memory at one time.
        assert len(log.read_bytes().splitlines()) > turns * PART
    assert most[4] < 1.3 * most[1]


def test_a_run_killed_before_its_first_row_has_no_log(tmp_path: Path) -> None:
    writer(tmp_path / "run.h5")._let_go()
    with pytest.raises(SpecificationError, match="allowed a run with a row or more"):
        export_run(tmp_path)


@pytest.mark.parametrize(
    ("pragma", "status", "kind"), [("max_page_count = 1", 507, "full"), ("query_only = ON", 503, "away")]
)
def test_a_store_that_cannot_write_says_when_to_come_again(
    pragma: str, status: int, kind: str, tmp_path: Path, protocol: str
) -> None:
    with Store(settings(tmp_path, {})) as store:
        body = protocol + "# " + "x" * 100_000

        @sa.event.listens_for(store.engine, "checkout")
        def limit(connection: sa.engine.interfaces.DBAPIConnection, *_: object) -> None:
            connection.cursor().execute(f"PRAGMA {pragma}")

        with served(create_app(Context(store=store)), quiet=True) as at:
            answer = httpx.post(f"{at}/v1/jobs", content=body, headers=YAML, timeout=30.0)
            problem(answer, status, kind)
            assert ("retry-after" in answer.headers) == (status == 503)


@pytest.mark.parametrize("first", [0, 4096])
def test_a_store_whose_file_cannot_be_read_for_a_while_says_when_to_come_again(
    first: int, tmp_path: Path, protocol: str
) -> None:
    # What SQLite makes of reads that fail: "file is not a database", "database disk image is malformed".
    given = settings(tmp_path, {})
    Store(given).close()
    file = tmp_path / "knitlab.sqlite"
    whole = file.read_bytes()
    with Store(given) as store, served(create_app(Context(store=store)), quiet=True) as at:
        for data in (whole[:first] + b"\xa5" * (len(whole) - first), whole):
            store.engine.dispose()
            for other in tmp_path.glob("knitlab.sqlite-*"):
                other.unlink()
            file.write_bytes(data)
            answer = httpx.post(f"{at}/v1/jobs", content=protocol, headers=YAML, timeout=30.0)
            if data == whole:
                assert answer.status_code == 202, answer.text
            else:
                problem(answer, 503, "away")


def test_what_h5py_says_in_words_alone_gives_the_job_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = "Can't write data (file write failed: errno = 28, error message = 'No space left on device')"
    faults = [RuntimeError(words), PermissionError(13, "Permission denied"), OSError(116, os.strerror(116))]
    monkeypatch.setattr(job_process, "_redirect_output", lambda _: None)
    monkeypatch.setattr("app.service.job_process.when_asked", lambda *_: None)
    for fault in faults:

        def fail(*_: object, fault: Exception = fault) -> None:
            raise fault

        monkeypatch.setattr(job_process, "_test", fail)
        with pytest.raises(SystemExit) as left:
            job_process._work_in(JobFolder(tmp_path))
        assert left.value.code == job_process.TROUBLE
        assert JobFolder(tmp_path).result() is None


def test_a_store_that_cannot_be_opened_is_one_line(tmp_path: Path) -> None:
    where = settings(tmp_path, {})
    (tmp_path / "knitlab.sqlite").mkdir()
    with pytest.raises(StoreAwayError, match="the database cannot be used: unable to open database file"):
        Store(where)


@pytest.mark.parametrize("number", [errno.EDQUOT, errno.EIO, errno.ESTALE])
def test_a_record_that_cannot_be_read_now_is_not_called_lost(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer(tmp_path / "run.h5")._let_go()

    def away(*_: object, **__: object) -> None:
        raise KeyError(f"Unable to open object (file read failed: errno = {number}, '{os.strerror(number)}')")

    monkeypatch.setattr("app.records.h5_read.h5py.File", away)
    told = r"what was recorded cannot be read now; .*knitlab resume"
    with pytest.raises(OSError, match=told) as caught, kept_in(tmp_path):
        raise OSError(number, os.strerror(number))
    assert caught.value.errno == number
