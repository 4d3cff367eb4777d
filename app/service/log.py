"""Log of the service, with bounds on the lines of a kind in a minute and on their length."""

from __future__ import annotations

import logging
import sys
import time
from typing import Final

MOST: Final = 10
"""Lines of one kind in a minute; a kind is a place in the source."""

LONGEST: Final = 8000
"""Characters of an entry, its stack trace included."""

_MINUTE: Final = 60.0


class FewAlike(logging.Filter):
    """Filter that passes a number of entries of a kind in a minute; the next says how many were dropped."""

    def __init__(self) -> None:
        super().__init__()
        self._kinds: dict[tuple[str, int], list[float]] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether an entry is written."""
        now = time.monotonic()
        began, count = self._kinds.get((record.pathname, record.lineno), (now, 0))
        left_out = 0
        if now - began >= _MINUTE:
            began, left_out, count = now, max(0, int(count) - MOST), 0
        self._kinds[record.pathname, record.lineno] = [began, count + 1]
        if left_out:
            record.msg, record.args = f"{record.getMessage()} ({left_out} more like it were left out before)", ()
        return count < MOST


class Bounded(logging.Formatter):
    """Formatter with time stamps that shortens very long entries in their middle."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(message)s")

    def format(self, record: logging.LogRecord) -> str:
        """Return the text of an entry."""
        text = super().format(record)
        half = LONGEST // 2
        return text if len(text) <= LONGEST else f"{text[:half]} [...] {text[-half:]}"


def set_up_log(service: int) -> None:
    """Send the log of the service and its libraries to stderr, the service's own from a level on."""
    handler = logging.StreamHandler(sys.stderr)
    handler.addFilter(FewAlike())
    handler.setFormatter(Bounded())
    logging.basicConfig(level=logging.WARNING, handlers=[handler])
    logging.getLogger("app.service").setLevel(service)
