"""Preload of the fork server: all modules imported, every serial kernel called, one thread.

What is forked from it starts to compute at once. A process with threads must not fork, so the
numerical libraries are told to make none before they are imported. All of this happens on import: the fork server
takes names of modules to begin with, and nothing else. Nobody else may import it.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import tempfile
import traceback
from pathlib import Path

from app.service.warmup_protocol import PROTOCOL


def one_thread() -> None:
    """Keep the solver and the numerical libraries from making threads; jobs are told how many they have."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "KNITLAB_THREADS"):
        os.environ[name] = "1"
    os.environ.setdefault("MPLBACKEND", "agg")


def warm_up() -> None:
    """Run the small test in a temporary folder; if it fails, jobs are only slower."""
    from app.runs.use_cases import run_protocol  # noqa: PLC0415
    from app.schemas import loads  # noqa: PLC0415
    from app.service import job_process  # noqa: F401, PLC0415
    from app.views.tube_images import prepare  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        run_protocol(loads(PROTOCOL), Path(folder) / "run", draw=None)
    prepare()
    gc.collect()
    gc.freeze()  # pages that the collector does not touch stay shared


def _prepare() -> None:
    # The supervisor stops the jobs one by one; the fork server ends with the supervisor.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    one_thread()
    try:
        warm_up()
    except Exception:  # noqa: BLE001 (the jobs will log it)
        traceback.print_exc(file=sys.stderr)


if __name__ != "__main__":
    _prepare()
