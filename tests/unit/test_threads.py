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


@pytest.mark.parametrize("count", [1, 2])
def test_both_return_what_they_return(count: int) -> None:
    threads.use_threads(count)
    names = threads.both(threading.get_ident, threading.get_ident)
    assert names[0] == threading.get_ident()
    assert (names[1] == names[0]) is (count == 1)


@pytest.mark.parametrize("count", [1, 2])
def test_an_error_in_either_is_raised(count: int) -> None:
    threads.use_threads(count)

    def fail() -> None:
        raise ValueError("no")

    for pair in ((fail, list), (list, fail)):
        with pytest.raises(ValueError, match="no"):
            threads.both(*pair)
