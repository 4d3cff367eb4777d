"""Commands of a live rig in the manner of SCPI: lines of text, answers, and a queue of errors.

Moves are overlapped: a line that asks for one returns at once, and moves are done one after the other by `work`, in
the thread that called it. Measurements answer at once with what the rig shows. ``*OPC?`` and ``*WAI`` wait.

References
----------
SCPI-99, volume 1 (syntax) and volume 2, chapter 21.8 (errors).
"""

from __future__ import annotations

import queue
import re
import threading
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from app.live.command_errors import ERRORS, CommandError, as_command_error
from app.version import version_of
from knitlab_core.errors import KnitlabError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from app.live.moves import Quantity
    from app.live.rig import LiveRig
    from rigs.step_record import StepRecord

    Job = Callable[[], StepRecord | None]
    Command = tuple[int, int, Callable[["CommandedRig", list[str]], str | None]]

MOST_ERRORS: Final = 32
MOST_MOVES: Final = 64
"""Moves that may wait."""

LONGEST_TEXT: Final = 255
"""Characters of an error's text."""

_LOOK: Final = 0.2
"""Time between two looks whether to go on [s]."""


@dataclass(slots=True, kw_only=True, eq=False)
class CommandedRig:
    """A rig that does what lines of text say.

    Attributes
    ----------
    mount : callable
        Mounts a new specimen, and returns its rig.
    rig : LiveRig
        The rig with the specimen that is on it now.
    """

    mount: Callable[[], LiveRig]
    rig: LiveRig
    _errors: deque[str] = field(default_factory=deque)
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _jobs: queue.Queue[Job] = field(default_factory=lambda: queue.Queue(MOST_MOVES))

    @property
    def busy(self) -> bool:
        """Return whether a move is under way or waits."""
        return self._jobs.unfinished_tasks > 0

    @property
    def waiting(self) -> int:
        """Return how many moves wait."""
        return self._jobs.qsize()

    def work(self, goes_on: Callable[[], bool]) -> None:
        """Do moves as they come, as long as `goes_on` says so."""
        while goes_on():
            try:
                job = self._jobs.get(timeout=_LOOK)
            except queue.Empty:
                continue
            try:
                done = job()
                if done is not None and done.end not in {"target", "abort"}:
                    self.refuse(CommandError(-200, f"{done.end}: {done.message}"))
            except KnitlabError as error:
                self.refuse(as_command_error(error))
            finally:
                self._jobs.task_done()

    def abort(self) -> None:
        """Drop the moves that wait, and ask the one under way to stop; to be called until the rig is not `busy`."""
        with suppress(queue.Empty):
            while True:
                self._jobs.get_nowait()
                self._jobs.task_done()
        self.rig.stop()

    def refuse(self, error: CommandError) -> None:
        """Put an error into the queue."""
        text = f"{ERRORS[error.number]};{' '.join(error.detail.split())}"[:LONGEST_TEXT].replace('"', '""')
        with self._lock:
            if len(self._errors) < MOST_ERRORS:
                self._errors.append(f'{error.number},"{text}"')
            else:
                self._errors[-1] = f'-350,"{ERRORS[-350]}"'

    def do(self, command: str) -> str | None:
        """Do one command of a line, such as ``MEAS:FORC? C``; return the answer of a query.

        What is wrong with it is put into the queue of errors.
        """
        try:
            header, _, rest = command.strip().partition(" ")
            parameters = [one.strip() for one in rest.split(",")] if rest.strip() else []
            least, most, action = _command(header)
            _require_count(parameters, least, most)
            return action(self, parameters)
        except CommandError as error:
            self.refuse(error)
        except KnitlabError as error:
            self.refuse(as_command_error(error))
        return None

    def queue(self, job: Job) -> None:
        """Let a move wait for its turn."""
        try:
            self._jobs.put_nowait(job)
        except queue.Full:
            raise CommandError(-223, f"{MOST_MOVES} moves wait already") from None

    def next_error(self) -> str:
        """Return the oldest error, and take it out of the queue."""
        with self._lock:
            return self._errors.popleft() if self._errors else f'0,"{ERRORS[0]}"'

    def count_errors(self) -> int:
        """Return how many errors there are."""
        return len(self._errors)

    def clear(self) -> None:
        """Drop all errors."""
        with self._lock:
            self._errors.clear()


def _command(header: str) -> Command:
    """Return the command of a header."""
    for pattern, command in COMMANDS.items():
        if pattern.fullmatch(header):
            return command
    raise CommandError(-113 if _HEADER.fullmatch(header) else -102, header[:64])


def _require_count(parameters: list[str], least: int, most: int) -> None:
    if len(parameters) < least:
        raise CommandError(-109, f"{len(parameters)} given, {least} needed")
    if len(parameters) > most:
        raise CommandError(-108, f"{len(parameters)} given, {most} allowed")


def _quantity(text: str) -> Quantity:
    """Return a number in SI, or a text with its unit."""
    try:
        return float(text)
    except ValueError:
        if not text[:1].isdigit() and text[:1] not in {"+", "-", "."}:
            raise CommandError(-104, f"{text[:64]}: a number in SI, or one with its unit") from None
        return text


def _axis(rig: CommandedRig, text: str) -> str:
    name = text.upper()
    if name not in rig.rig.axes:
        raise CommandError(-224, f"axis {text[:64]}: this rig has {' and '.join(rig.rig.axes)}")
    return name


def _measured(what: str) -> Callable[[CommandedRig, list[str]], str]:
    def measure(rig: CommandedRig, parameters: list[str]) -> str:
        return _number(getattr(rig.rig.read(), what)[_axis(rig, parameters[0])])

    return measure


def _moved(method: str) -> Callable[[CommandedRig, list[str]], None]:
    def move(rig: CommandedRig, parameters: list[str]) -> None:
        *names, level, rate = parameters
        levels = {_axis(rig, name): _quantity(level) for name in names}
        speed = _quantity(rate)
        rig.queue(lambda: getattr(rig.rig, method)(rate=speed, **levels))

    return move


def _hold(rig: CommandedRig, parameters: list[str]) -> None:
    duration = _quantity(parameters[0])
    rig.queue(lambda: rig.rig.hold(duration))


def _zero(rig: CommandedRig, _: list[str]) -> None:
    rig.queue(rig.rig.zero)


def _reset(rig: CommandedRig, _: list[str]) -> None:
    def change() -> None:
        if rig.rig.protocol.steps:
            rig.rig.close()
            rig.rig = rig.mount()

    rig.queue(change)


def _clear(rig: CommandedRig, _: list[str]) -> None:
    rig.clear()


def _state(rig: CommandedRig, _: list[str]) -> str:
    return "MOVING" if rig.busy else "IDLE" if rig.rig.outcome is None else "ENDED"


def _number(value: float) -> str:
    return f"{value:.16E}"


def _pattern(header: str) -> re.Pattern[str]:
    """Return the pattern of a header whose short form is in capitals: ``MEASure:FORCe?``."""
    parts = [re.sub(r"[a-z]+", lambda rest: f"(?:{rest[0]})?", re.escape(part)) for part in header.split(":")]
    return re.compile(":?" + ":".join(parts), re.IGNORECASE)


_HEADER: Final = re.compile(r"[:*]?[A-Za-z][A-Za-z0-9_]*(?::[A-Za-z][A-Za-z0-9_]*)*\??")

WAITS: Final = re.compile(r"\*(OPC\?|WAI)", re.IGNORECASE)
"""Commands before which all moves must be done."""

ABORTS: Final = _pattern("ABORt")

RESETS: Final = _pattern("*RST")
"""A command before which all moves are aborted."""

COMMANDS: Final[Mapping[re.Pattern[str], Command]] = {
    _pattern(header): entry
    for header, entry in {
        "*IDN?": (0, 0, lambda rig, _: f"knitlab,{rig.rig.protocol.rig},{rig.rig.folder.name},{version_of('knitlab')}"),
        "*RST": (0, 0, _reset),
        "*CLS": (0, 0, _clear),
        "*OPC?": (0, 0, lambda *_: "1"),
        "*WAI": (0, 0, lambda *_: None),
        "*TST?": (0, 0, lambda *_: "0"),
        "SYSTem:ERRor?": (0, 0, lambda rig, _: rig.next_error()),
        "SYSTem:ERRor:NEXT?": (0, 0, lambda rig, _: rig.next_error()),
        "SYSTem:ERRor:COUNt?": (0, 0, lambda rig, _: str(rig.count_errors())),
        "SYSTem:VERSion?": (0, 0, lambda *_: "1999.0"),
        "MEASure:FORCe?": (1, 1, _measured("force")),
        "MEASure:DISPlacement?": (1, 1, _measured("displacement")),
        "MEASure:STRain?": (1, 1, _measured("strain")),
        "MEASure:TIME?": (0, 0, lambda rig, _: _number(rig.rig.read().time)),
        "MOVE:ABSolute": (3, 5, _moved("move")),
        "MOVE:STRain": (3, 5, _moved("move_strain")),
        "MOVE:FORCe": (3, 5, _moved("move_force")),
        "HOLD": (1, 1, _hold),
        "ZERO": (0, 0, _zero),
        "RIG:STATe?": (0, 0, _state),
        "RIG:AXES?": (0, 0, lambda rig, _: ",".join(rig.rig.axes)),
        "RIG:FOLDer?": (0, 0, lambda rig, _: str(rig.rig.folder)),
    }.items()
}
"""Each command with the fewest and the most parameters that it takes, and what it does."""
