"""Interrupts of a run are raised in the solver's work alone, and none is lost."""

from __future__ import annotations

import signal
import threading
from contextlib import suppress

import pytest

from app.runs.interrupts import interrupts_held


@pytest.fixture(autouse=True)
def usual_handler() -> None:
    # A shell's background jobs ignore SIGINT, and children inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def press() -> None:
    signal.raise_signal(signal.SIGINT)


def test_an_interrupt_in_a_window_is_raised_at_once() -> None:
    done = []
    with interrupts_held() as window:
        with pytest.raises(KeyboardInterrupt), window():  # noqa: PT012 (what is interrupted)
            press()
            done.append("more work")
        with window():  # and only once
            done.append("next")
    assert done == ["next"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_while_files_are_written_waits_for_the_next_window() -> None:
    done = []
    with interrupts_held() as window:
        press()
        done.append("written")
        with pytest.raises(KeyboardInterrupt), window():
            done.append("worked")
    assert done == ["written"]


def test_an_interrupt_after_the_last_window_is_raised_when_all_is_written() -> None:
    done = []
    with pytest.raises(KeyboardInterrupt), interrupts_held() as window:  # noqa: PT012 (what is interrupted)
        with window():
            pass
        press()
        done.append("written")
    assert done == ["written"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_that_is_swallowed_in_a_window_is_raised_at_its_end() -> None:
    with (
        interrupts_held() as window,
        pytest.raises(KeyboardInterrupt),
        window(),
        suppress(KeyboardInterrupt),  # as Python does in a finaliser
    ):
        press()


def test_the_handlers_of_others_stay() -> None:
    pressed = []
    signal.signal(signal.SIGINT, lambda *_: pressed.append(1))
    with interrupts_held() as window, window():
        press()
    assert pressed == [1]
    failed: list[BaseException] = []

    def in_a_thread() -> None:
        try:
            with interrupts_held() as window, window():
                pass
        except BaseException as error:  # noqa: BLE001 (whatever it is)
            failed.append(error)

    thread = threading.Thread(target=in_a_thread)
    thread.start()
    thread.join()
    assert not failed
