"""A file must be whole after every commit and after every one that failed."""

from __future__ import annotations

import io
import os
import random
import subprocess
import sys
import textwrap
from pathlib import Path

import h5py
import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.seal import require_intact, seal, sealed_size
from app.records.staged_file import StagedFile
from knitlab_core.errors import FormatError
from tests.app.records.test_records import writer
from tests.synthetic_run import row

ROOT = Path(__file__).parents[3]


def test_it_reads_and_commits_what_a_file_in_memory_would(tmp_path: Path) -> None:
    chance = random.Random(25)  # noqa: S311 (not for secrets)
    path, twin = tmp_path / "staged", io.BytesIO(b"0123456789")
    path.write_bytes(twin.getvalue())
    with StagedFile(path) as staged:
        for turn in range(400):
            at, count = chance.randrange(200), chance.randrange(1, 60)
            match turn % 4:
                case 0 | 1:
                    piece = chance.randbytes(count)
                    for file in (staged, twin):
                        file.seek(at)
                        file.write(piece)
                case 2:
                    end = twin.seek(0, io.SEEK_END)
                    size = chance.randrange(end - 5, end + 1)
                    staged.truncate(size)
                    twin.truncate(size)
                case _:
                    staged.seek(at)
                    twin.seek(at)
                    assert staged.read(count).rstrip(b"\0") == twin.read(count).rstrip(b"\0")
            if chance.random() < 0.1:
                staged.commit()
                assert path.read_bytes() == twin.getvalue()


FILL = textwrap.dedent(
    """
    import resource, sys
    from dataclasses import replace
    from pathlib import Path
    from rigs.record import Outcome
    from tests.synthetic_run import frame, row
    from app.records import layout
    from tests.app.records.test_records import writer

    layout.CHUNK = 64
    for number, limit in enumerate(map(int, sys.argv[2:])):
        path, kept, frames = Path(sys.argv[1]) / f"{number}.h5", 0, 0
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        try:
            with writer(path) as run:
                for k in range(300):
                    run.append(replace(row(float(k), 0.1, 1, "Stretch"), tag=f"tag {k // 50}"))
                    kept += 1
        except OSError as error:
            print(number, kept, error.strerror, flush=True)
    """
)


@pytest.mark.skipif(sys.platform == "win32", reason="limits of file sizes are Unix")
def test_a_record_that_finds_no_room_keeps_every_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # In the record itself, before the first row, among its chunks, and where the second chunks begin.
    monkeypatch.setattr("app.records.layout.CHUNK", 64)
    with writer(tmp_path / "one.h5") as run:
        empty = (tmp_path / "one.h5").stat().st_size
        run.append(row(0.0, 0.1, 1, "Stretch"))
        one = (tmp_path / "one.h5").stat().st_size
    limits = [empty // 2, empty + 1000, (empty + one) // 2, one + 1000, one + (one - empty) // 2]
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-P", "-c", FILL, str(tmp_path), *map(str, limits)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    told = [line.split(maxsplit=2) for line in done.stdout.splitlines()]
    assert [words[2] for words in told] == ["File too large"] * len(limits)
    kept = [int(words[1]) for words in told]
    assert kept[:3] == [0, 0, 0]
    assert 0 < kept[3] < kept[4] < 300
    assert not (tmp_path / "0.h5").exists()
    for number, count in enumerate(kept[1:], start=1):
        read = RunReader(tmp_path / f"{number}.h5")
        assert read.trace.columns["time"].tolist() == list(range(count))
        assert read.going_on


def test_a_sealed_file_shows_every_change(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with writer(path) as run:
        run.append(row(0.0, 0.1, 1, "Stretch"))
    whole = path.read_bytes()
    size = sealed_size(path)
    assert size is not None
    chance = random.Random(25)  # noqa: S311 (not for secrets)
    for place in [0, size - 1, *(chance.randrange(size) for _ in range(30))]:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1 << chance.randrange(8)]) + whole[place + 1 :])
        with pytest.raises(FormatError, match="checksum does not match"):
            RunReader(path)
    # Cut off within its seal it is whole, and has none.
    path.write_bytes(whole[:-3])
    assert len(RunReader(path).trace) == 1
    assert sealed_size(path) is None


def test_a_file_that_is_changed_on_purpose_loses_its_seal(tmp_path: Path) -> None:
    path = tmp_path / "some.h5"
    with h5py.File(path, "w") as file:
        file["x"] = np.arange(5)
    seal(path)
    with h5py.File(path, "r+") as file:
        file["x"][0] = 7
    assert sealed_size(path) is None
    seal(path)
    require_intact(path, "some file")


def test_rows_that_a_power_cut_blanked_are_not_rows(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    run = writer(path)
    for k in range(6):
        run.append(row(float(k), 0.1, 1, "Stretch"))
    run._let_go()  # as a kill does: nothing seals the file
    with h5py.File(path, "r+") as file:
        file["equilibria/force_C"][4:] = 0.0
    assert RunReader(path).trace.columns["time"].tolist() == [0.0, 1.0, 2.0, 3.0]
    with h5py.File(path, "r+") as file:
        file["equilibria/force_C"][2] = 0.0
        file["equilibria/force_C"][5] = file["equilibria/force_C"][0]
    with pytest.raises(FormatError, match="row 2 does not match its checksum"):
        RunReader(path)
