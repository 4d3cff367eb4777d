"""Let calls to the disk fail in the middle of runs: a quota is met, the disk has an I/O error, a file handle is stale.

    python -m benchmarks.disk_faults --trials 96

Needs Linux and a C compiler: a library of the C calls that write (and, for a share of the trials, read) is loaded
before all others, and lets those below the run's folder fail from a random one on, or once. Each trial is a process of
its own that runs one command; then nothing fails any more, and `resume` goes on. Counted is how both ended, as in
`benchmarks.disks`, and whether rows or log differ from those of a run without faults.
"""

from __future__ import annotations

import argparse
import ctypes
import errno
import os
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Final

from benchmarks.disks import knitlab, rows_of, show, whole_run

SOURCE: Final = Path(__file__).with_suffix(".c")
FAULTS: Final = (errno.EDQUOT, errno.EIO, errno.ESTALE)
ALL: Final = -1


def begin(folder: Path, number: int, first: int, count: int, *, reads: bool) -> None:
    """Let calls of this process below a folder fail with an error number, from the one numbered `first` on."""
    ctypes.CDLL(None).fault_begin(os.fsencode(folder), number, ctypes.c_long(first), ctypes.c_long(count), int(reads))


def calls() -> int:
    """Return how many calls of this process there were that could have failed."""
    count = ctypes.CDLL(None).fault_calls
    count.restype = ctypes.c_long
    return int(count())


def preloaded(folder: Path) -> bool:
    """Start this program again with the library before all others, unless it is; return whether it is."""
    if "disk_faults" in os.environ.get("LD_PRELOAD", ""):
        return True
    library = folder / "disk_faults.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", str(library), str(SOURCE), "-ldl"], check=True)
    again = [sys.executable, "-m", "benchmarks.disk_faults", *sys.argv[1:]]
    done = subprocess.run(again, env={**os.environ, "LD_PRELOAD": str(library)}, check=False)
    sys.exit(done.returncode)


def trials(count: int, seed: int) -> None:
    """Try faults at random calls of a run."""
    chance = random.Random(seed)
    table: dict[str, Counter[str]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        truth = (whole_run(folder) / "Disk.csv").read_bytes()
        rows = rows_of(folder / "Whole")
        most = {reads: _calls_of(folder, reads=reads) for reads in (False, True)}
        for trial in range(count):
            number = FAULTS[trial % len(FAULTS)]
            reads = trial // len(FAULTS) % 4 == 3  # every fourth
            times = ALL if trial // (2 * len(FAULTS)) % 2 else 1
            first = chance.randrange(most[reads])
            place = folder / f"Run{trial}"
            ended = knitlab(
                *("run", folder / "disk.yaml", "--out", place, "-q"),
                prepare=lambda: begin(place, number, first, times, reads=reads),  # noqa: B023 (called before the next)
            )
            kept = rows_of(place)
            verdict = ended.verdict
            if kept is None:
                verdict += ", nothing recorded" if "nothing was recorded" in ended.err else ", RECORD LOST"
            elif ended.code != 0:
                resumed = knitlab("resume", place, "-q")
                verdict += f", then resume: {resumed.verdict}"
                sys.stdout.write(resumed.err if resumed.code else "")
                said = f"{kept} rows", "what was recorded cannot be read now"
                if "knitlab resume" not in ended.err or not any(words in ended.err for words in said):
                    verdict += ", NOT SAID"
            log = place / "Disk.csv"
            if kept is not None and (not log.exists() or log.read_bytes() != truth or rows_of(place) != rows):
                verdict += ", DATA LOST"
            label = f"{errno.errorcode[number]}, {'once' if times == 1 else 'from then on'}{', reads too' * reads}"
            sys.stdout.write(
                f"{trial}: {label}, call {first} of {most[reads]}: {kept} rows, {ended.code}; {ended.err}\n"
            )
            table.setdefault(label, Counter())[verdict] += 1
    show(table)


def _calls_of(folder: Path, *, reads: bool) -> int:
    """Return how many calls of a whole run could fail."""
    place, told = folder / f"Calls{reads:d}", folder / "calls"

    def count() -> None:
        import h5py

        begin(place, 0, 0, 0, reads=reads)
        closed = h5py._objects.nonlocal_close  # noqa: SLF001 (called last, see `benchmarks.disks`)
        h5py._objects.nonlocal_close = lambda: (told.write_text(str(calls())), closed())  # noqa: SLF001

    knitlab("run", folder / "disk.yaml", "--out", place, "-q", prepare=count)
    return int(told.read_text())


def main() -> None:
    """Run the trials."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=96)
    parser.add_argument("--seed", type=int, default=12)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        preloaded(Path(name))
    import app.runs.use_cases  # noqa: F401 (forked with every trial)

    trials(asked.trials, asked.seed)


if __name__ == "__main__":
    main()
