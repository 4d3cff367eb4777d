"""One answer on every machine: the same rows whatever processor libraries and kernels are made for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.reproducible_runs import QUICK, SPECIMENS, TARGETS, difference, run_as

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.reproducible_runs import Runs

HOST, *OTHERS = TARGETS
SOURCE = "docs/reproducibility.md"


def compare(bar: Callable[..., None], one: Runs, other: Runs, target: str) -> None:
    assert one.keys() == other.keys()
    found = [difference(one[name], other[name]) for name in one]
    bar(
        f"curves, {target} against host, {len(found)} specimens, worst over peak",
        max(d.share for d in found),
        1e-3,
        "1",
        SOURCE,
    )
    bar(f"curves, {target} against host, specimens of other bits", sum(not d.same_bits for d in found), 0, "1", SOURCE)


def test_other_libraries_and_threads_find_the_same_bits(bar: Callable[..., None]) -> None:
    target = "all but kernels"
    compare(bar, run_as(HOST, QUICK), run_as(target, QUICK), f"{target}, quick")


@pytest.fixture(scope="module")
def on_host() -> Runs:
    return run_as(HOST)


@pytest.mark.slow
@pytest.mark.parametrize("target", OTHERS)
def test_every_target_finds_the_same_bits(bar: Callable[..., None], target: str, on_host: Runs) -> None:
    """Kernels for another processor are compiled once, in some minutes, and kept."""
    assert list(on_host) == list(SPECIMENS)
    compare(bar, on_host, run_as(target), target)
