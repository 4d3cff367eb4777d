"""Server of a live rig: one client at a time sends lines of commands over TCP, from this machine alone."""

from __future__ import annotations

import asyncio
import signal
import socket
import sys
import threading
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

from app.live.command_errors import CommandError
from app.live.commands import ABORTS, RESETS, WAITS, CommandedRig
from app.service.address import is_loopback
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from app.live.rig import LiveRig

PORT: Final = 5025
"""Port of raw sockets to instruments, as registered for SCPI."""

LONGEST_LINE: Final = 4096
"""Bytes that a line may have."""

MOST_LINES: Final = 256
"""Lines of a client that may wait to be done."""

_LOOK: Final = 0.01
"""Time between two looks whether the rig has stopped [s]."""

_OCCUPIED: Final = b'-221,"Settings conflict;another client drives the rig: one at a time"\n'


class CommandServer:
    """Server of the commands of one rig, in a thread of its own.

    Parameters
    ----------
    rig : CommandedRig
        The rig.
    listener : socket
        Where it listens; see `listen`. It is closed at the end.
    idle : float
        Time after which a client that is silent while nothing moves is disconnected [s].
    """

    def __init__(self, rig: CommandedRig, listener: socket.socket, *, idle: float) -> None:
        self._rig, self._listener, self._idle = rig, listener, idle
        self._occupied = False
        self._ready, self._ended = threading.Event(), asyncio.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin to serve."""
        self._thread = threading.Thread(target=lambda: asyncio.run(self._listen()), name="knitlab-live", daemon=True)
        self._thread.start()
        self._ready.wait()

    def stop(self) -> None:
        """Disconnect the client, and listen no more."""
        if self._loop is not None and self._thread is not None:
            self._loop.call_soon_threadsafe(self._ended.set)
            self._thread.join()

    async def _listen(self) -> None:
        """Serve clients until the server is stopped."""
        self._loop = asyncio.get_running_loop()
        server = await asyncio.start_server(self._serve, sock=self._listener, limit=LONGEST_LINE)
        self._ready.set()
        await self._ended.wait()
        server.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a client until it leaves; another one meanwhile is told so."""
        try:
            if self._occupied:
                await self._send(writer, _OCCUPIED)
            else:
                self._occupied = True
                try:
                    await self._converse(reader, writer)
                finally:
                    self._occupied = False
            writer.close()
        except (ConnectionError, TimeoutError, asyncio.CancelledError):
            # A server that is stopped cancels its clients, and asyncio 3.11 would show a task that ends so.
            writer.transport.abort()

    async def _send(self, writer: asyncio.StreamWriter, answer: bytes) -> None:
        """Send an answer.

        Raises
        ------
        TimeoutError
            If the client does not take it.
        """
        writer.write(answer)
        await asyncio.wait_for(writer.drain(), self._idle)

    async def _converse(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Read the lines of a client beside doing them, so that one that waits for a move can abort it."""
        lines: asyncio.Queue[str | None] = asyncio.Queue(MOST_LINES)
        reading = asyncio.create_task(self._read(reader, lines))
        try:
            while (line := await lines.get()) is not None:
                answers = [answer for one in line.split(";") if (answer := await self._do(one, lines)) is not None]
                if answers:
                    await self._send(writer, ";".join(answers).encode("ascii", "replace") + b"\n")
        finally:
            reading.cancel()

    async def _do(self, command: str, lines: asyncio.Queue[str | None]) -> str | None:
        """Do one command of a line."""
        text = command.strip()
        if not text:
            return None
        if ABORTS.fullmatch(text) or RESETS.fullmatch(text):
            await self._abort()
        if ABORTS.fullmatch(text):
            return None
        if WAITS.fullmatch(text):
            while self._rig.busy:
                if _taken_out(lines, ABORTS.fullmatch):
                    await self._abort()
                await asyncio.sleep(_LOOK)
        return self._rig.do(text)

    async def _abort(self) -> None:
        """Stop what moves, and wait until it has."""
        while self._rig.busy:
            self._rig.abort()
            await asyncio.sleep(_LOOK)

    async def _read(self, reader: asyncio.StreamReader, lines: asyncio.Queue[str | None]) -> None:
        """Put the lines of a client into a queue; None where it has left, or was silent too long."""
        with suppress(ConnectionError, asyncio.IncompleteReadError, TimeoutError):
            while True:
                line = await self._line(reader)
                if line is not None:
                    await lines.put(line)
        await lines.put(None)

    async def _line(self, reader: asyncio.StreamReader) -> str | None:
        """Return the next line; None if it was refused.

        Raises
        ------
        IncompleteReadError, TimeoutError
            If the client has left, or was silent too long; what is no whole line is dropped.
        """
        overrun = False
        while True:
            try:
                line = await self._until_newline(reader)
                break
            except asyncio.LimitOverrunError as error:
                overrun = True
                await reader.readexactly(max(error.consumed, 1))
        if overrun:
            self._rig.refuse(CommandError(-363, f"a line has {LONGEST_LINE} bytes or fewer"))
            return None
        try:
            text = line.decode("ascii").strip()
        except UnicodeDecodeError:
            text = "\0"
        if any(not " " <= sign <= "~" and sign != "\t" for sign in text):
            self._rig.refuse(CommandError(-101, "a line is of printed ASCII characters"))
            return None
        return text.replace("\t", " ")

    async def _until_newline(self, reader: asyncio.StreamReader) -> bytes:
        """Return the bytes up to the end of a line; while the rig moves a client may be silent."""
        reading = asyncio.ensure_future(reader.readuntil(b"\n"))
        try:
            while True:
                done, _ = await asyncio.wait({reading}, timeout=self._idle)
                if done:
                    return reading.result()
                if not self._rig.busy:
                    raise TimeoutError
        finally:
            reading.cancel()


def _taken_out(lines: asyncio.Queue[str | None], wanted: Callable[[str], object]) -> bool:
    """Return whether a line that waits is wanted, and take all such out."""
    waiting: list[str | None] = []
    while not lines.empty():
        waiting.append(lines.get_nowait())
    left = [line for line in waiting if line is None or not wanted(line)]
    for line in left:
        lines.put_nowait(line)
    return len(left) < len(waiting)


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens at an address of this machine's own; port 0 is a free one.

    Raises
    ------
    SpecificationError
        If other machines could reach it.
    OSError
        If the port is taken.
    """
    if not is_loopback(host):
        raise SpecificationError("host", host, "a loopback address: who reaches the port drives the rig")
    return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)


def serve_rig(mount: Callable[[], LiveRig], host: str, port: int, *, idle: float) -> LiveRig:
    """Serve a rig until Ctrl-C or SIGTERM; return it, closed.

    Parameters
    ----------
    mount : callable
        Mounts a specimen, at the start and on ``*RST``.
    host, port : str, int
        Where to listen; see `listen`.
    idle : float
        As `CommandServer` has it [s].
    """
    with _interrupted_by_signals(), listen(host, port) as listener:
        commanded = CommandedRig(mount=mount, rig=mount())
        try:
            _serve_until_interrupted(commanded, listener, idle)
        except BaseException as error:
            commanded.rig.close(error)
            raise
        commanded.rig.close()
    return commanded.rig


def _serve_until_interrupted(commanded: CommandedRig, listener: socket.socket, idle: float) -> None:
    """Serve a rig until Ctrl-C; a move that it interrupts ends the test."""
    host, port = listener.getsockname()[:2]
    address, rig = f"[{host}]" if ":" in host else host, commanded.rig
    server = CommandServer(commanded, listener, idle=idle)
    server.start()
    sys.stderr.write(f"knitlab live on {address}:{port}, {rig.protocol.rig}; run in {rig.folder}\n")
    sys.stderr.flush()
    try:
        with suppress(KeyboardInterrupt):
            commanded.work(lambda: True)
    finally:
        server.stop()


@contextmanager
def _interrupted_by_signals() -> Iterator[None]:
    """Take SIGTERM for Ctrl-C in this block, and Ctrl-C also where it was ignored, as in the background of a shell."""
    handlers = {
        signal.SIGINT: signal.default_int_handler,
        signal.SIGTERM: lambda *_: signal.raise_signal(signal.SIGINT),
    }
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
