"""Lab software drives a rig over TCP: answers, errors, stops, and clients that misbehave."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Self

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import knitlab as kl
from app.live.commands import MOST_ERRORS, MOST_MOVES, CommandedRig
from app.live.server import LONGEST_LINE, CommandServer, listen
from tests.app.live.test_rig import HEAD, log_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from app.live.rig import LiveRig

WAIT = 120.0
"""Time after which a test gives up [s]."""


class Client:
    """Lab software with one connection."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=WAIT)
        self._lines = self.socket.makefile("r", encoding="ascii", newline="\n")

    def send(self, line: str | bytes) -> None:
        self.socket.sendall(line if isinstance(line, bytes) else f"{line}\n".encode())

    def ask(self, line: str) -> str:
        self.send(line)
        return self.answer()

    def answer(self) -> str:
        return self._lines.readline().rstrip("\n")

    def errors(self) -> list[int]:
        """Return the numbers of all errors, and take them out."""
        found = []
        while not (said := self.ask("SYST:ERR?")).startswith("0,"):
            found.append(int(said.partition(",")[0]))
        return found

    def close(self) -> None:
        self._lines.close()
        self.socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Bench:
    """A rig that is served, with its motions done in a thread."""

    def __init__(self, folder: Path, *, idle: float = WAIT, pace: float | None = None) -> None:
        self.folder = folder
        self._pace = pace
        self.rig = CommandedRig(mount=self._mount, rig=self._mount())
        listener = listen("127.0.0.1", 0)
        self.port = listener.getsockname()[1]
        self.server = CommandServer(self.rig, listener, idle=idle)
        self.server.start()
        self._going = True
        self._motions = threading.Thread(target=self.rig.work, args=[lambda: self._going])
        self._motions.start()

    def _mount(self) -> LiveRig:
        return kl.Rig(HEAD, self.folder / "live", draw=None, pace=self._pace)

    def client(self) -> Client:
        """Return a client, once the one before has been let go."""
        while True:
            client = Client(self.port)
            if client.ask("SYST:VERS?") == "1999.0":
                return client
            client.close()

    def close(self) -> LiveRig:
        self._going = False
        self._motions.join()
        self.server.stop()
        self.rig.rig.close()
        return self.rig.rig


@contextmanager
def bench(folder: Path, *, idle: float = WAIT, pace: float | None = None) -> Iterator[Bench]:
    opened = Bench(folder, idle=idle, pace=pace)
    try:
        yield opened
    finally:
        opened.close()


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with bench(tmp_path_factory.mktemp("bench")) as opened:
        yield opened


def test_a_client_drives_the_rig_and_the_record_is_that_of_the_protocol(tmp_path: Path) -> None:
    with bench(tmp_path) as served, served.client() as client:
        maker, model, folder, version = client.ask("*IDN?").split(",")
        assert (maker, model, folder, version) == ("knitlab", "biaxial-hook", "live", kl.__version__)
        client.send("ZERO;:move:absolute C,0.2 mm,2e-4;MOVE:STR C,W,0.02,1e-3 1/s")
        client.send("MOVE:FORC W,0.01,0.005")
        client.send("HOLD 2")
        assert client.ask("*OPC?") == "1"
        assert client.ask("RIG:STAT?;RIG:AXES?;MEAS:TIME?").split(";")[:2] == ["IDLE", "C,W"]
        assert float(client.ask("MEASURE:STRAIN? c")) == pytest.approx(0.02)
        assert float(client.ask("MEAS:DISP? C")) == pytest.approx(0.02 * 16e-3)
        assert float(client.ask("MEAS:FORC? W")) == served.rig.rig.read().force["W"]
        assert client.errors() == []
        first = served.rig.rig
        client.send("*RST")
        assert client.ask("*OPC?;MEAS:TIME?") == "1;0.0000000000000000E+00"
        assert client.ask("RIG:FOLD?") == str(tmp_path / "live-2")
    strained, released = kl.Target(kind="strain", value=0.02), kl.Target(kind="force", value=0.01)
    assert kl.open_run(tmp_path / "live").test.steps == (
        kl.Zero(),
        kl.Ramp(axes=("C",), to=kl.Target(kind="displacement", value=2e-4), rate=2e-4),
        kl.Ramp(axes=("C", "W"), to=strained, rate=kl.StrainRate(value=1e-3)),
        kl.Ramp(axes=("W",), to=released, rate=kl.ForceRate(value=0.005)),
        kl.Hold(duration=2.0),
    )
    assert first.result.outcome == "target"


WRONG = {
    "MEAS:TORQ? C": -113,
    "MEASU:FORC? C": -113,
    "*SAV 1": -113,
    "MEAS:FORC?": -109,
    "MEAS:FORC? C,W": -108,
    "MEAS:FORC? X": -224,
    "MOVE:ABS C,5e-3": -109,
    "MOVE:ABS C,five,1e-4": -104,
    "MOVE:ABS C,5 kg,1e-4": -131,
    "MOVE:ABS C,1,1e-4": -222,
    "MOVE:FORC C,1e6,1": -222,
    "MOVE:ABS C,nan,1e-4": -222,
    "MOVE:ABS X,1e-3,1e-4": -224,
    "HOLD -1": -222,
    "HOLD": -109,
    "??": -102,
    "\x07": -101,
    "é": -101,
    "MEAS:FORC? " + "C" * LONGEST_LINE: -363,
}


def test_what_is_wrong_is_an_error_of_the_queue(shared: Bench) -> None:
    with shared.client() as client:
        for line, number in WRONG.items():
            client.send(line)
            assert client.ask("*OPC?") == "1"
            assert client.errors() == [number], line
        client.send("MOVE:ABS C,1,1e-4")
        client.ask("*OPC?")
        said = client.ask("SYST:ERR?")
        assert said.startswith('-222,"Data out of range;ramp: found ')
        assert "travel: axis C would go 1000 mm, limit 100 mm" in said
        assert client.ask("SYST:ERR?") == '0,"No error"'
        for _ in range(MOST_ERRORS + 5):
            client.send("NONE")
        assert client.ask("SYST:ERR:COUN?") == str(MOST_ERRORS)
        assert client.errors() == [-113] * (MOST_ERRORS - 1) + [-350]
        client.send("NONE;*CLS")
        assert client.errors() == []


def test_one_client_at_a_time_and_others_are_told(shared: Bench) -> None:
    with shared.client() as client:
        with Client(shared.port) as other:
            assert other.answer() == '-221,"Settings conflict;another client drives the rig: one at a time"'
            assert other.answer() == ""  # disconnected
        assert client.ask("*TST?") == "0"


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=3 * LONGEST_LINE), whole=st.booleans())
def test_no_bytes_break_the_server(shared: Bench, data: bytes, whole: bool) -> None:  # noqa: FBT001 (an example)
    with shared.client() as client:
        client.send(data + (b"\n" if whole else b""))
    with shared.client() as client:
        client.send("ABOR;*CLS")
        assert client.ask("*IDN?").startswith("knitlab,biaxial-hook,")
    assert shared.rig.rig.outcome is None


def test_an_abort_stops_what_moves_and_drops_what_waits_also_while_a_client_waits(tmp_path: Path) -> None:
    with bench(tmp_path, pace=1.0) as served, served.client() as client:
        client.send("MOVE:STR C,0.1,1e-6;HOLD 100")
        assert client.ask("RIG:STAT?") == "MOVING"
        client.send("*OPC?")
        client.send("ABOR")
        assert client.answer() == "1"
        assert client.ask("RIG:STAT?") == "IDLE"
        assert client.errors() == []
        rig = served.rig.rig
        assert [type(step).__name__ for step in rig.protocol.steps] in ([], ["Ramp"])
        client.send("MOVE:STR C,0.2,1e-6;ABOR;ZERO")
        assert client.ask("*OPC?") == "1"
    assert {step.end for step in rig.result.steps[:-1]} <= {"abort"}
    assert (rig.result.outcome, rig.result.steps[-1].end) == ("target", "target")


def test_a_client_that_leaves_in_a_move_leaves_the_record_whole(tmp_path: Path) -> None:
    with bench(tmp_path) as served:
        with served.client() as client:
            client.send(b"ZERO\nMOVE:STR C,0.03,2e-4\nMOVE:ABS C,0.01")
        with served.client() as client:
            assert client.ask("*OPC?") == "1"
            assert float(client.ask("MEAS:STR? C")) == pytest.approx(0.03)
        rig = served.rig.rig
    record = kl.open_run(rig.folder)
    assert [step.end for step in record.steps] == ["target", "target"]
    assert record.strain("C")[-1] == pytest.approx(0.03)
    assert log_of(rig.folder)


def test_a_silent_client_is_disconnected_but_not_while_its_move_goes_on(tmp_path: Path) -> None:
    with bench(tmp_path, idle=0.05, pace=4.0) as served, Client(served.port) as client:
        client.send("HOLD 2;*OPC?")
        assert client.answer() == "1"
        assert client.answer() == ""  # disconnected


def test_moves_that_wait_are_bounded(shared: Bench) -> None:
    gate = threading.Event()

    def wait() -> None:
        gate.wait(WAIT)

    with shared.client() as client:
        shared.rig.queue(wait)
        while shared.rig.waiting:
            time.sleep(0.001)
        client.send(";".join(["HOLD 1"] * (MOST_MOVES + 2)))
        assert client.errors() == [-223, -223]
        client.send("ABOR")
        gate.set()
        assert client.ask("*OPC?") == "1"


def test_other_machines_cannot_reach_it() -> None:
    for host in ("0.0.0.0", "192.168.1.2", "::", "example.org"):  # noqa: S104 (refused)
        with pytest.raises(kl.SpecificationError, match=r"host: found '.*', allowed a loopback address"):
            listen(host, 0)
