"""Supervision of a delivery: start the job's process, watch it, stop it on request, record its end."""

from __future__ import annotations

import logging
import threading
import time
from contextlib import suppress
from multiprocessing import connection
from typing import TYPE_CHECKING, Final, Literal

from app.service import job_process
from app.service.folder import Result
from app.service.leases import orders, take_lease
from app.service.processes import (
    ask_to_stop,
    end_process,
    end_tree,
    how_it_ended,
    resident_memory,
    start_method,
    stop_event,
)
from app.service.tables import AWAY, first_line

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess

    from app.service.folder import JobFolder
    from app.service.jobs import JobSpec
    from app.service.leases import Lease, Order
    from app.service.store import Store

Stop = Literal["cancel", "pause", "drain", "lost", "timeout", "memory"]

ATTEMPTS: Final = 3
"""Crashes after which a job has failed."""

LOOK: Final = 0.2
"""Time between two looks at a process, and at what the store wants of it [s]."""

GRACE: Final = 4.0
"""Time that a process has to stop by itself [s]; what its checkpoint holds is kept in any case."""

_LONGEST_PAUSE: Final = 60.0
"""Longest time that a slot rests when its host cannot work [s]."""

_MEBIBYTE: Final = 1024.0**2
_log: Final = logging.getLogger(__name__)


class Supervisor:
    """Runner of deliveries, each in a process of its own.

    Parameters
    ----------
    store : Store
        Where the jobs are.
    threads : int
        Threads of each job's solver.
    """

    def __init__(self, store: Store, threads: int = 1) -> None:
        self.store = store
        self._threads = threads
        self.draining = threading.Event()
        self._closed = threading.Event()
        # Starting and reaping share state inside multiprocessing.
        self._processes = threading.Lock()
        self._orders: dict[str, Order] = {}
        self._running: set[str] = set()
        self._troubles = 0
        self._context = start_method()

    def get_ready(self) -> None:
        """Start the fork server and wait until its kernels are compiled."""
        process = self._context.Process(target=time.sleep, args=(0,), daemon=True)
        with self._processes:
            process.start()
        process.join()
        threading.Thread(target=self._listen, name="knitlab-orders", daemon=True).start()

    def close(self) -> None:
        """Stop polling the store."""
        self._closed.set()

    def deliver(self, delivery: str) -> None:
        """Work on a delivery until its job ends, pauses or belongs to another worker."""
        held = None
        try:
            held = take_lease(self.store, delivery, self.draining)
            if held is not None:
                self._running.add(held.job)
                self._run(held)
            self._troubles = 0
        except (*AWAY, OSError, EOFError) as error:
            self._wait_and_release(held, error)
        except Exception as error:  # noqa: BLE001 (a job must not stay `running` for ever)
            _log.exception("delivery %s", delivery)
            if held is not None:
                message = f"the service failed: {type(error).__name__}"
                held.settle(Result(end="error", message=message, failed=True))
        finally:
            if held is not None:
                self._running.discard(held.job)
                self._orders.pop(held.job, None)

    def _wait_and_release(self, held: Lease | None, error: BaseException) -> None:
        """Release a job that this host cannot run, and take no other one for a while.

        No fault of the job: the data folder is away, a disk is full, the database does not answer.
        """
        self._troubles += 1
        pause = min(2.0**self._troubles, _LONGEST_PAUSE)
        _log.error("cannot work: %s; trying again in %.0f s", first_line(error), pause)
        self.draining.wait(pause)
        if held is not None:
            with suppress(*AWAY):  # then other workers requeue it once this one is silent
                held.release()

    def _run(self, held: Lease) -> None:
        spec, files = held.retrying(lambda: self.store.spec(held.job)), self.store.files(held.job)
        files.write_spec(spec)
        while (result := files.result()) is None:
            if self.draining.is_set():
                held.release()
                return
            stop, code = self._attempt(held, spec, files)
            if files.result() is not None or stop == "drain":
                continue
            # Polled now: a process may have ended between two polls.
            stop = held.asked() or stop
            if stop == "lost":
                return
            if stop == "pause":
                held.release()
                return
            if stop is None and code == job_process.TROUBLE:
                raise OSError(f"job {held.job}: its process could not keep its files; job.log says more")
            if stop is None and code == job_process.LOCKED:
                self._free(files)
            elif (failed := self._verdict(held, spec, stop, code)) is not None:
                files.write_result(failed)
        held.settle(result)

    def _verdict(self, held: Lease, spec: JobSpec, stop: Stop | None, code: int) -> Result | None:
        """Return the end of a job whose process ended without a result; None to try again."""
        match stop:
            case "cancel":
                return Result(end="cancelled", message="", failed=False)
            case "timeout":
                return Result(end=stop, message=f"ran longer than its timeout of {spec.timeout:g} s", failed=True)
            case "memory":
                limit = (spec.memory or 0) / _MEBIBYTE
                return Result(end=stop, message=f"held more than its memory limit of {limit:.0f} MiB", failed=True)
        # The whole service may be stopped process by process.
        if code == job_process.STOPPED or self.draining.is_set():
            return None
        times = held.crashed()
        if times is None or times < ATTEMPTS:
            return None
        return Result(end="crash", message=_crash(times, code), failed=True)

    def _attempt(self, held: Lease, spec: JobSpec, files: JobFolder) -> tuple[Stop | None, int]:
        """Run the job's process once; return why it was stopped and its exit code."""
        told = stop_event(self._context)
        given = (str(files.path), self._threads, told)
        process = self._context.Process(target=job_process.work, args=given, daemon=True)
        with self._processes:
            process.start()
        began, ran, stop, counted = time.monotonic(), files.ran(), None, False
        try:
            while stop is None and not connection.wait([process.sentinel], timeout=LOOK):
                if not counted:
                    held.begin()
                    counted = True
                stop = self._reason(held, spec, process, ran + time.monotonic() - began)
            if stop in {"pause", "drain"}:
                ask_to_stop(process, told)
                connection.wait([process.sentinel], timeout=GRACE)
        finally:
            self._end(process)
        # A process that found the folder locked does not count as an attempt.
        if not counted and process.exitcode != job_process.LOCKED:
            held.begin()
        return stop, process.exitcode or 0

    def _end(self, process: BaseProcess) -> None:
        """Kill a process with all that it started, and wait until it is gone."""
        # The id of an ended process may have been given to another one.
        if not connection.wait([process.sentinel], timeout=0.0):
            end_tree(process)
        with self._processes:
            process.join()

    def _reason(self, held: Lease, spec: JobSpec, process: BaseProcess, ran: float) -> Stop | None:
        """Return why a running process must stop now."""
        order = self._orders.get(held.job)
        asked = None if order is None else order.to(held.owner)
        # "Lost" may have been read before this run began.
        if asked == "lost":
            asked = held.asked()
        if asked is not None:
            return asked
        if self.draining.is_set():
            return "drain"
        if spec.timeout is not None and ran > spec.timeout:
            return "timeout"
        if spec.memory is not None and resident_memory(process) > spec.memory:
            return "memory"
        return None

    def _free(self, files: JobFolder) -> None:
        """Stop the process of a run that lost the job's lease; wait if it is on another host."""
        holder = files.holder()
        if holder is not None:
            _log.warning("%s: process %d holds it for a run that is over; killed", files.path.name, holder)
            end_process(holder)
        time.sleep(LOOK if holder is not None else 5.0 * LOOK)

    def _listen(self) -> None:
        """Poll what the store asks of running jobs."""
        while not self._closed.wait(LOOK):
            running = list(self._running)
            if running:
                try:
                    self._orders = orders(self.store, running)
                except Exception as error:  # noqa: BLE001 (the database is away; jobs go on)
                    _log.warning("cannot look at the jobs: %s", error)


def _crash(times: int, code: int) -> str:
    """Return how a process ended abnormally."""
    return f"its process died {times} times, last {how_it_ended(code)}; job.log says more"
