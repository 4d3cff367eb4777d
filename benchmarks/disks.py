"""Try what disks do: damage records, checkpoints, protocols and kernel caches at random places, and fill disks.

    python -m benchmarks.disks damage --trials 300
    python -m benchmarks.disks cache --trials 60
    sudo python -m benchmarks.disks full

Every trial is a process of its own, forked from one that has imported the program, that runs one command. Counted is
how it ended: as if nothing had happened (*done*), by one line and an exit code (*one line*), by a traceback, by a
signal; and what it printed or wrote of a damaged file that is not what it is of the whole one (*other*: fewer rows of a
run that was killed; *wrong*: anything else). The seed is printed; the same seed makes the same trials.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

import h5py

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

PROTOCOL: Final = """\
schema: knitlab/protocol@1
name: Disk
rig: biaxial-hook
specimen:
  {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3, nodes_per_loop: 16}
speed_ref: pair
others: hold
log: {rate: 10 Hz}
max_strain_increment: 0.01
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C, W], lower: 0, upper: 0.06, rate: 0.2 mm/s, n: 1, tag: equibiaxial}
"""
MEBIBYTE: Final = 2**20
PATIENCE: Final = 1200
"""Longest time of a trial [s]."""


class Ended(NamedTuple):
    """How a command ended: exit code (negative: a signal), what it printed, what it said."""

    code: int
    out: str
    err: str

    @property
    def verdict(self) -> str:
        """Return the column of the table that it counts in."""
        if "Traceback" in self.err or "Exception ignored" in self.err:
            return "traceback"
        if self.code < 0:
            return signal.Signals(-self.code).name
        if self.code == 0:
            return "done"
        lines = [line for line in self.err.splitlines() if not line.startswith("kernel cache:")]
        return "one line" if len(lines) == 1 else f"{len(lines)} lines"


def knitlab(*words: object, pictures: bool = False, prepare: Callable[[], None] | None = None) -> Ended:
    """Run a command in a process forked from this one."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = os.fork()
        if child == 0:
            os.dup2(out.fileno(), 1)
            os.dup2(err.fileno(), 2)
            _run([str(word) for word in words], pictures=pictures, prepare=prepare)
        signal.signal(signal.SIGALRM, lambda *_: os.kill(child, signal.SIGKILL))
        signal.alarm(PATIENCE)
        _, status = os.waitpid(child, 0)
        signal.alarm(0)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
    return Ended(os.waitstatus_to_exitcode(status), *texts)


def _run(words: list[str], *, pictures: bool, prepare: Callable[[], None] | None) -> None:
    """Be the command; never return."""
    from app.cli.main import main as cli

    code: object = 1
    try:
        if prepare is not None:
            prepare()
        plain = words[0] in {"run", "resume"} and not pictures
        sys.argv = ["knitlab", *words, *(["--no-pictures"] if plain else [])]
        cli()
        code = 0
    except SystemExit as left:
        code = left.code or 0
    except BaseException:
        import traceback

        traceback.print_exc()
    finally:
        with suppress(OSError):
            sys.stdout.flush()
        with suppress(OSError):
            sys.stderr.flush()
        # Not os._exit: HDF5 lets go of its files as a program ends, which is where it used to die.
        # Not the other ends of Python's either: they remove the folders of the process that this one is forked from.
        h5py._objects.nonlocal_close()  # noqa: SLF001
        ctypes.CDLL(None).exit(code if isinstance(code, int) else 1)


def flip(data: bytes, chance: random.Random) -> bytes:
    """Return bytes with one bit changed."""
    changed = bytearray(data)
    changed[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def garble(data: bytes, chance: random.Random) -> bytes:
    """Return bytes with 16 of them random."""
    begin = chance.randrange(max(1, len(data) - 16))
    return data[:begin] + chance.randbytes(min(16, len(data) - begin)) + data[begin + 16 :]


def blank(data: bytes, chance: random.Random) -> bytes:
    """Return bytes with one page of zeros, as a power cut leaves it."""
    begin = 4096 * chance.randrange(max(1, len(data) // 4096))
    return data[:begin] + bytes(min(4096, len(data) - begin)) + data[begin + 4096 :]


def truncate(data: bytes, chance: random.Random) -> bytes:
    """Return the first bytes, however many."""
    return data[: chance.randrange(len(data))]


def empty(_data: bytes, _chance: random.Random) -> bytes:
    """Return nothing."""
    return b""


def noise(data: bytes, chance: random.Random) -> bytes:
    """Return as many random bytes."""
    return chance.randbytes(len(data))


HARMS: Final = (flip, garble, blank, truncate)
CACHE_HARMS: Final = (empty, truncate, noise, garble)


def whole_run(folder: Path) -> Path:
    """Make a run that ended."""
    (folder / "disk.yaml").write_text(PROTOCOL, encoding="utf-8")
    ended = knitlab("run", folder / "disk.yaml", "--out", folder / "Whole", "-q")
    if ended.code:
        raise SystemExit(ended.err)
    return folder / "Whole"


def killed_run(folder: Path, rows: int = 8) -> Path:
    """Make a run that was killed after some rows, with a checkpoint."""

    def kill_late() -> None:
        from app.records.checkpoint import Keeper

        keep, kept = Keeper.keep, []

        def killed(*arguments: object) -> None:
            keep(*arguments)  # type: ignore[arg-type]
            kept.append(1)
            if len(kept) == rows:
                os.kill(os.getpid(), signal.SIGKILL)

        Keeper.keep = killed  # type: ignore[method-assign, assignment]

    knitlab("run", folder / "disk.yaml", "--out", folder / "Killed", "-q", prepare=kill_late)
    return folder / "Killed"


def damage(trials: int, seed: int) -> None:
    """Damage what commands read."""
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = whole_run(folder)
        killed = killed_run(folder)
        open_ended = shutil.copytree(whole, folder / "Unsealed")
        record = open_ended / "run.h5"
        from app.records.seal import sealed_size

        os.truncate(record, sealed_size(record) or record.stat().st_size)
        cases = list(_damage_cases(whole, open_ended, killed, folder / "disk.yaml"))
        truth = {
            label: _told(words(_copied(source, source.name, folder)), folder)[1] for label, source, _, words in cases
        }
        table: dict[str, Counter[str]] = {}
        for trial in range(trials):
            label, source, file, words = cases[trial % len(cases)]
            harm = HARMS[(trial // len(cases)) % len(HARMS)]
            copy = _copied(source, file, folder)
            place = copy / file if copy.is_dir() else copy
            place.write_bytes(harm(place.read_bytes(), chance))
            ended, told = _told(words(copy), folder)
            verdict = ended.verdict
            if verdict == "done" and told != truth[label]:
                verdict = "other" if "killed" in label or "resume" in label else "wrong"
            if verdict not in {"done", "one line"}:
                _show(trial, label, harm.__name__, ended, verdict)
            table.setdefault(label, Counter())[verdict] += 1
    show(table)


def _copied(source: Path, file: str, folder: Path) -> Path:
    """Return a copy of a run folder, or of a file."""
    copy = folder / "Trial"
    shutil.rmtree(copy, ignore_errors=True)
    if source.is_dir():
        return shutil.copytree(source, copy)
    copy.mkdir()
    return Path(shutil.copy(source, copy / file))


Words = Callable[[Path], tuple[object, ...]]
Case = tuple[str, Path, str, Words]


def _damage_cases(whole: Path, unsealed: Path, killed: Path, protocol: Path) -> Iterator[Case]:
    """Yield label, source, damaged file and command."""
    images: tuple[str, Words] = ("images", lambda run: ("images", run, "-q", "--out", run.parent / "Out"))
    commands: tuple[tuple[str, Words], ...] = (
        ("export", lambda run: ("export", run, "--out", run.parent / "Out")),
        ("analyse", lambda run: ("analyse", run, "--json")),
        ("plot", lambda run: ("plot", run, "--out", run.parent / "Out" / "plot.svg")),
        ("compare", lambda run: ("plot", whole, run, "--out", run.parent / "Out" / "plot.svg")),
    )
    for what, source in (("ended", whole), ("ended, unsealed", unsealed), ("killed", killed)):
        for name, words in (*commands, images) if source == unsealed else commands:
            yield f"{name}, run.h5 {what}", source, "run.h5", words
    for what in ("run.h5", "checkpoint.h5"):
        yield f"resume, {what} killed", killed, what, lambda run: ("resume", run, "-q")
    yield "resume, run.h5 ended", whole, "run.h5", lambda run: ("resume", run, "-q")
    yield "check, protocol", protocol, protocol.name, lambda one: ("check", one)
    fine = ("-q", "--format", "stl", "--chord-error", "60 um")
    yield "print, protocol", protocol, protocol.name, lambda one: ("print", *fine, one, "--out", one.parent)


def _told(words: tuple[object, ...], folder: Path) -> tuple[Ended, tuple[str, ...]]:
    """Return how a command ended, and what it came to: the values that it printed, the bytes that it wrote."""
    out = folder / "Out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    ended = knitlab(*words)
    files = [one for one in sorted(out.rglob("*")) if one.is_file() and one.suffix != ".svg"]
    printed = ended.out if words[0] in {"analyse", "check"} else ""
    return ended, (printed, *(f"{one.name} {hash(one.read_bytes())}" for one in files))


def cache(trials: int, seed: int) -> None:
    """Damage kernel caches; the environment of this process names the cache that is tried."""
    from knitlab_core.jit import CACHE_FOLDER

    chance = random.Random(seed)
    if CACHE_FOLDER is None:
        raise SystemExit("no kernel cache")
    table: dict[str, Counter[str]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        truth = (whole_run(folder) / "Disk.csv").read_bytes()
        kept = shutil.copytree(CACHE_FOLDER, folder / "kept")
        files = sorted(path.relative_to(kept) for path in kept.rglob("*.nb?"))
        for trial in range(trials):
            shutil.rmtree(CACHE_FOLDER)
            shutil.copytree(kept, CACHE_FOLDER)
            harm = CACHE_HARMS[trial % len(CACHE_HARMS)]
            suffix = (".nbi", ".nbc")[(trial // len(CACHE_HARMS)) % 2]
            some = [file for file in files if file.suffix == suffix]
            for file in chance.sample(some, chance.randint(1, 4)):
                (CACHE_FOLDER / file).write_bytes(harm((kept / file).read_bytes(), chance))
            shutil.rmtree(folder / "Run", ignore_errors=True)
            ended = knitlab("run", folder / "disk.yaml", "--out", folder / "Run", "-q")
            verdict = ended.verdict
            if verdict == "done":
                said = [line for line in ended.err.splitlines() if line.startswith("kernel cache:")]
                verdict = "done, said" if said else "done"
                if (folder / "Run" / "Disk.csv").read_bytes() != truth:
                    verdict = "wrong"
            if not verdict.startswith("done"):
                _show(trial, suffix, harm.__name__, ended, verdict)
            table.setdefault(f"{suffix}, {harm.__name__}", Counter())[verdict] += 1
    show(table)


def full(sizes: Sequence[float], seed: int) -> None:
    """Run into disks of some sizes [MiB] until they are full, then make room and go on; needs root on Linux."""
    del seed
    table: dict[str, Counter[str]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = whole_run(folder)
        truth = (whole / "Disk.csv").read_bytes()
        disk = folder / "Disk"
        disk.mkdir()
        for size in sizes:
            mount = ["mount", "-t", "tmpfs", "-o", f"size={round(size * 1024)}k", "knitlab-trial", str(disk)]
            subprocess.run(mount, check=True)
            try:
                ended = knitlab("run", folder / "disk.yaml", "--out", disk / "Run", "-q", pictures=True)
                kept = rows_of(disk / "Run")
                room = ["mount", "-o", "remount,size=64m", str(disk)]
                subprocess.run(room, check=True)
                verdict = ended.verdict
                if kept is None:
                    verdict += ", nothing recorded"
                elif ended.code != 0:
                    verdict += f", then resume: {knitlab('resume', disk / 'Run', '-q', pictures=True).verdict}"
                if kept is not None and (disk / "Run" / "Disk.csv").read_bytes() != truth:
                    verdict += ", data lost"
                sys.stdout.write(f"{size:6.2f} MiB: {kept} rows; {ended.err.strip()}\n")
                table.setdefault("run on a full disk", Counter())[verdict] += 1
            finally:
                subprocess.run(["umount", str(disk)], check=True)
    show(table)


def rows_of(run: Path) -> int | None:
    """Return how many rows the record of a run holds; None if it cannot be read."""
    from app.records.reader import RunReader
    from knitlab_core.errors import KnitlabError

    try:
        return len(RunReader(run / "run.h5").trace)
    except (KnitlabError, OSError):
        return None


def _show(trial: int, label: str, harm: str, ended: Ended, verdict: str) -> None:
    sys.stdout.write(f"{trial}: {label}, {harm}: {verdict} ({ended.code}): {ended.err[-600:]}\n")
    sys.stdout.flush()


def show(table: dict[str, Counter[str]]) -> None:
    """Print the counts."""
    verdicts = sorted({verdict for row in table.values() for verdict in row})
    total: Counter[str] = Counter()
    for label, row in [*table.items(), ("all", total)]:
        total.update(row if label != "all" else {})
        sys.stdout.write(f"| {label} | {' | '.join(f'{verdict}: {row[verdict]}' for verdict in verdicts)} |\n")


def main() -> None:
    """Run the trials that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("damage", "cache", "full"))
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--seed", type=int, default=25)
    asked = parser.parse_args()
    import app.runs.use_cases  # noqa: F401 (forked with every trial)

    if asked.what == "full":
        full([0.25 + 0.75 * k for k in range(14)], asked.seed)
    else:
        {"damage": damage, "cache": cache}[asked.what](asked.trials, asked.seed)


if __name__ == "__main__":
    main()
