from __future__ import annotations

import io
import logging
from typing import TYPE_CHECKING

import pytest

from app.service import log
from app.service.log import LONGEST, MOST, Bounded, FewAlike

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture
def written() -> Iterator[io.StringIO]:
    """Lend what is written of the logger `api`."""
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.addFilter(FewAlike())
    handler.setFormatter(Bounded())
    logger = logging.getLogger("api")
    logger.addHandler(handler)
    logger.propagate = False
    yield stream
    logger.removeHandler(handler)


def test_few_of_a_kind_are_written_and_the_others_counted(
    written: io.StringIO, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 100.0
    monkeypatch.setattr("app.service.log.time.monotonic", lambda: now)
    logger = logging.getLogger("api")

    def complain(which: object) -> None:
        logger.warning("found %s", which)

    for k in range(MOST + 25):
        complain(k)
    logger.warning("something else")
    lines = written.getvalue().splitlines()
    assert len(lines) == MOST + 1
    assert lines[-1].endswith("something else")
    now += log._MINUTE
    complain("one more")
    assert written.getvalue().splitlines()[-1].endswith("found one more (25 more like it were left out before)")


def test_a_long_entry_loses_its_middle(written: io.StringIO) -> None:
    logging.getLogger("api").warning("first %s last", "x" * 10**6)
    text = written.getvalue()
    assert len(text) < LONGEST + 20
    assert " first x" in text
    assert text.endswith("x last\n")
