import threading
from collections.abc import Iterator

import pytest

from knitlab_core import threads


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    before = threads.thread_count()
    yield
    threads.use_threads(before)


@pytest.mark.parametrize(
    ("given", "processors", "wanted"),
    [(None, 8, 2), (None, 1, 1), (None, None, 1), ("1", 8, 1), ("2", 1, 2), ("0", 8, 1), ("16", 8, 2), ("many", 8, 2)],
)
def test_the_environment_says_how_many(given: str | None, processors: int | None, wanted: int) -> None:
    environment = {} if given is None else {threads.VARIABLE: given}
    assert threads.wanted_threads(environment, processors) == wanted


def test_one_thread_does_one_thing_after_the_other() -> None:
    threads.use_threads(1)
    assert threads.both(threading.get_ident, threading.get_ident) == (threading.get_ident(),) * 2


def test_two_threads_work_at_once() -> None:
    threads.use_threads(2)
    begun = threading.Event()

    def second() -> int:
        begun.set()
        return threading.get_ident()

    waited, other = threads.both(lambda: begun.wait(60.0), second)
    assert waited
    assert other != threading.get_ident()


def test_nobody_waits_for_a_thread_that_has_not_begun() -> None:
    threads.use_threads(2)
    threads.both(list, list)
    pool, busy = threads._Threads.pool, threading.Event()
    assert pool is not None
    blocker = pool.submit(busy.wait, 60.0)
    try:
        assert threads.both(list, threading.get_ident) == ([], threading.get_ident())
    finally:
        busy.set()
        blocker.result()


@pytest.mark.parametrize("count", [1, 2])
def test_an_error_in_either_is_raised(count: int) -> None:
    threads.use_threads(count)

    def fail() -> None:
        raise ValueError("no")

    for pair in ((fail, list), (list, fail)):
        with pytest.raises(ValueError, match="no"):
            threads.both(*pair)
