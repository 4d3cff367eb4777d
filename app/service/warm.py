"""Get the fork server ready: everything imported, every serial kernel called, one thread.

What is forked from it starts to compute at once. A process with threads must not fork, so the
numerical libraries are told to make none before they are imported.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Final

#: The smallest test that goes through the whole solver and its log.
PROTOCOL: Final = """\
schema: knitlab/protocol@1
name: warm
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
speed_ref: pair
others: hold
log: {rate: 1 Hz, noise: off}
steps:
  - cycle: {axes: [C, W], lower: 0, upper: 1 %, rate: 1 mm/s, n: 1}
"""


def one_thread() -> None:
    """Keep the numerical libraries from making threads of their own."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"
    os.environ.setdefault("MPLBACKEND", "agg")


def warm_up() -> None:
    """Run the small test in a folder that goes away; a failure leaves the jobs slower, not broken."""
    from app import cli  # noqa: F401, PLC0415 (the entry point, which every process imports)
    from app.schemas import loads  # noqa: PLC0415
    from app.service import child  # noqa: F401, PLC0415
    from app.usecases import run_loaded  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        run_loaded(loads(PROTOCOL), Path(folder) / "run", lambda _share, _text: None, pictures=False)
    gc.collect()
    gc.freeze()  # pages that the collector does not touch stay shared


def _prepare() -> None:
    # The supervisor stops the jobs one by one; the fork server leaves when the supervisor does.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    one_thread()
    try:
        warm_up()
    except Exception:  # noqa: BLE001 (the jobs will say it in their logs)
        traceback.print_exc(file=sys.stderr)


if __name__ != "__main__":
    _prepare()
