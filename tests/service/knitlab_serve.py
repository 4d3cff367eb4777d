"""Start `knitlab serve` in a process of its own, and talk to it with the command line."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

ROOT: Final = Path(__file__).parents[2]
#: A real test of few rows, with noise.
QUICK: Final = """\
schema: knitlab/protocol@1
name: quick
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
speed_ref: pair
others: hold
log: {rate: 10 Hz, noise: on, seed: 7}
max_strain_increment: 0.05
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C, W], lower: 0, upper: 5 %, rate: 0.2 mm/s, n: 1}
"""
_KNITLAB: Final = (sys.executable, "-P", "-c", "from app.cli.main import main; main()")


def environment(**more: str) -> dict[str, str]:
    """Return the variables under which these sources run."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("KNITLAB_") or "CACHE" in name}
    return {**kept, "PYTHONPATH": str(ROOT), **more}


def knitlab(*words: object, folder: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a command to its end."""
    return subprocess.run(  # noqa: S603 (our own program)
        [*_KNITLAB, *map(str, words)],
        cwd=folder,
        env=environment(**more),
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


@contextmanager
def serving(
    folder: Path, *words: object, within: Sequence[str] = (), **more: str
) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Lend the address and the process of a service whose data are in a folder; `within` starts its command."""
    command = [*within, *_KNITLAB, "serve", "--port", "0", "--data", str(folder), *map(str, words)]
    service = subprocess.Popen(  # noqa: S603 (our own program)
        command, cwd=ROOT, env=environment(**more), stderr=subprocess.PIPE, text=True
    )
    try:
        said = ""
        for line in service.stderr or ():
            said += line
            if match := re.search(r"serves on (http://\S+),", line):
                yield match[1], service
                break
        else:
            raise RuntimeError(f"no service: {said}")
    finally:
        service.send_signal(signal.SIGTERM)
        try:
            service.wait(timeout=30)
        finally:
            service.kill()
            if service.stderr is not None:
                service.stderr.close()
