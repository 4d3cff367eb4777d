"""Print what becomes of jobs whose processes, workers and hosts die: `python -m benchmarks.durability`.

Real tests of a 2x2 knit, real workers, a real PostgreSQL. `--jobs 200` is the whole; fewer are quicker.
"""

from __future__ import annotations

import argparse
import tempfile
from contextlib import ExitStack
from pathlib import Path

from tests.service.databases import postgres, postgres_programs
from tests.service.lab import Lab
from tests.service.storm import Storm, Tally, endure

COLUMNS = ("submitted", "finished", "succeeded", "lost", "twice", "redone", "different")


def storms(jobs: int) -> dict[str, Storm]:
    """Return what is done, by the name of the row."""
    tenth = max(jobs // 10, 1)
    few = max(jobs // 40, 1)
    return {
        "SQLite: nothing happens": Storm(jobs=jobs),
        "SQLite: children killed": Storm(jobs=jobs, children_killed=2 * tenth),
        "SQLite: server killed, told to leave": Storm(jobs=jobs, workers_killed=few, workers_told_to_leave=few),
        "SQLite: all of it": Storm(jobs=jobs, children_killed=tenth, workers_killed=few, workers_told_to_leave=few),
        "PostgreSQL, two workers: all of it, two frozen": Storm(
            jobs=jobs,
            workers=2,
            children_killed=tenth,
            workers_killed=few,
            workers_frozen=2,
            workers_told_to_leave=few,
        ),
    }


def show(name: str, tally: Tally) -> None:
    """Print one row."""
    cells = " | ".join(str(getattr(tally, column)) for column in COLUMNS)
    print(f"| {name} | {cells} | {tally.seconds:.0f} s |", flush=True)


def main() -> None:
    """Run the storms and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=200)
    parser.add_argument("--only", default="", help="rows whose names contain this")
    asked = parser.parse_args()
    print(f"| what happens | {' | '.join(COLUMNS)} | took |\n|---|{'---|' * (len(COLUMNS) + 1)}", flush=True)
    for name, storm in storms(asked.jobs).items():
        many = name.startswith("PostgreSQL")
        if asked.only not in name or (many and postgres_programs() is None):
            continue
        with ExitStack() as stack:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            lab = Lab(Path(folder), stack.enter_context(postgres()) if many else "")
            stack.callback(lab.close)
            show(name, endure(lab, storm))


if __name__ == "__main__":
    main()
