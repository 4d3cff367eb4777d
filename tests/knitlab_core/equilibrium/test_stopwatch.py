import pytest

from knitlab_core.equilibrium import stopwatch
from knitlab_core.equilibrium.stopwatch import Stopwatch


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Stopwatch:
    """Every look at the time finds it one second later than the one before."""
    ticks = iter(range(1000))
    monkeypatch.setattr(stopwatch, "perf_counter", lambda: float(next(ticks)))
    return Stopwatch()


def test_sums_seconds_and_calls_by_name(clock: Stopwatch) -> None:
    for part in ("factor", "solve", "factor"):
        with clock(part):
            pass
    assert clock.seconds == {"factor": 2.0, "solve": 1.0}
    assert clock.calls == {"factor": 2, "solve": 1}


def test_a_part_within_a_part_counts_in_the_inner_one_alone(clock: Stopwatch) -> None:
    with clock("outer"), clock("inner"):
        pass
    assert clock.seconds == {"outer": 2.0, "inner": 1.0}


def test_counts_what_ended_in_an_error(clock: Stopwatch) -> None:
    with pytest.raises(ValueError, match="no"), clock("factor"):
        raise ValueError("no")
    assert clock.calls == {"factor": 1}
