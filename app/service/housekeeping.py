"""Maintenance of a store: deletions are finished, old jobs and ended deliveries are deleted."""

from __future__ import annotations

import logging
import threading
import time
from typing import TYPE_CHECKING, Final

from app.service.deletion import clear, purge
from app.service.deliveries import forget_ended
from app.service.tables import AWAY, first_line

if TYPE_CHECKING:
    from collections.abc import Callable

    from app.service.store import Store

ENDED: Final = 3600.0
"""Time for which the queue remembers deliveries that have ended [s]."""

_SECONDS_BETWEEN_LOOKS: Final = 60.0

_log: Final = logging.getLogger(__name__)


class Housekeeping:
    """Thread that maintains a store: it finishes deletions, deletes old jobs and ended deliveries.

    Parameters
    ----------
    store : Store
        The store.
    keep : float or None
        Time after which ended jobs are deleted [s]; None keeps them.
    """

    def __init__(self, store: Store, keep: float | None) -> None:
        self._store, self._keep = store, keep
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._maintain, name="knitlab-housekeeping", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop after the part that is being done."""
        self._stopped.set()
        self._thread.join()

    def _maintain(self) -> None:
        while not self._stopped.is_set():
            try:
                self._look()
            except AWAY as error:
                _log.warning("cannot keep house: %s", first_line(error))
            except Exception:  # noqa: BLE001 (the next look may go well)
                _log.exception("cannot keep house")
            self._stopped.wait(_SECONDS_BETWEEN_LOOKS)

    def _look(self) -> None:
        store, now = self._store, time.time()
        self._while_any(lambda: clear(store))
        if self._keep is not None:
            before = now - self._keep
            self._while_any(lambda: purge(store, before))
        self._while_any(lambda: forget_ended(store.client, now - ENDED))

    def _while_any(self, do: Callable[[], int]) -> None:
        """Repeat an action part by part while it finds something and the service runs."""
        while not self._stopped.is_set() and do():
            pass
