"""Turns go to the cheapest request that waits, one at a time, and none is lost."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import anyio
import httpx
import pytest

from app.service.api import checking
from app.service.api.build import create_app
from app.service.api.concurrency import Turns
from app.service.api.context import Context
from app.service.api.problems import ProblemError
from tests.service.lab import until
from tests.service.serving import problem, served

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from app.service.store import Store

YAML = {"Content-Type": "application/yaml"}
CHECK, LOOK = "/v1/protocols:validate", "/v1/specimens:preview"


def run(script: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Run a script on a loop of its own thread: the tests of the console leave one in this thread."""
    with ThreadPoolExecutor(1) as thread:
        thread.submit(anyio.run, script).result()


def test_the_cheapest_goes_first_and_one_at_a_time() -> None:
    order: list[float] = []

    async def work(turns: Turns, cost: float) -> None:
        with turns.line():
            async with turns.turn(cost):
                order.append(cost)
                before = len(order)
                await anyio.sleep(0.001)
                assert len(order) == before

    async def all_of_them() -> None:
        turns = Turns(what="", again=1)
        async with anyio.create_task_group() as group:
            for cost in (5.0, 3.0, 4.0, 1.0, 3.0, 2.0):
                group.start_soon(work, turns, cost)
                await anyio.lowlevel.checkpoint()

    run(all_of_them)
    assert order == [5.0, 1.0, 2.0, 3.0, 3.0, 4.0]


def test_who_waits_too_long_is_refused_and_the_turn_goes_on() -> None:
    async def script() -> None:
        turns = Turns(what="busy", again=7, patience=0.05)
        async with turns.turn():
            with pytest.raises(ProblemError) as refused:
                async with turns.turn():
                    pytest.fail("two have a turn")
            assert (refused.value.kind, refused.value.headers) == ("busy", {"Retry-After": "7"})
        async with turns.turn():
            pass

    run(script)


@pytest.mark.parametrize("passed_on", [False, True])
def test_who_leaves_while_waiting_keeps_no_turn(passed_on: bool) -> None:  # noqa: FBT001 (a parameter)
    async def wait(turns: Turns) -> None:
        async with turns.turn():
            await anyio.sleep_forever()

    async def script() -> None:
        turns = Turns(what="", again=1)
        async with anyio.create_task_group() as group:
            async with turns.turn():
                group.start_soon(wait, turns)
                await anyio.sleep(0.01)
                if not passed_on:
                    group.cancel_scope.cancel()
                    await anyio.lowlevel.cancel_shielded_checkpoint()
            # Its turn has come, and it has not noticed yet.
            group.cancel_scope.cancel()
        with anyio.fail_after(1.0):
            async with turns.turn():
                pass

    run(script)


def test_a_full_line_refuses() -> None:
    turns = Turns(what="full", again=1, most=2)
    with turns.line(), turns.line(), pytest.raises(ProblemError, match="full"), turns.line():
        pass
    with turns.line():
        pass


def test_large_protocols_that_wait_hold_up_no_small_one(store: Store, protocol: str) -> None:
    # Somebody's large protocol is being looked at, and takes its time.
    context = Context(store=store, checking=Turns(what="large ones", again=10, patience=8.0, _taken=True))
    large = protocol.replace("[2, 2]", "[60, 60]")
    long = protocol + f"# {'x' * 20_000}\n"
    with served(create_app(context)) as at, ThreadPoolExecutor(45) as pool:
        wanted = [(path, text) for path in ("/v1/jobs", CHECK, LOOK) for text in (large, long)] * 7
        waiting = [
            pool.submit(httpx.post, at + path, content=text, headers=YAML, timeout=240.0) for path, text in wanted
        ]
        until(lambda: sum(one.done() for one in waiting) >= len(wanted) - context.checking.most)
        for path, status in (("/v1/jobs", 202), (CHECK, 200), (LOOK, 200)):
            assert httpx.post(at + path, content=protocol, headers=YAML, timeout=240.0).status_code == status
        for one in waiting:
            found = problem(one.result(), 503, "busy")
            assert found["detail"] == "large ones"
            assert int(one.result().headers["retry-after"]) > 0


@pytest.mark.parametrize("path", ["/v1/jobs", "/v1/protocols:validate", "/v1/specimens:preview"])
def test_a_large_protocol_has_its_turn(http: httpx.Client, protocol: str, path: str) -> None:
    large = protocol.replace("n: 1", "n: 800")
    assert 2 * 800 / checking._STROKES > checking.LARGE
    assert http.post(path, content=large, headers=YAML).is_success
