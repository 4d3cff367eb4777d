"""Command that serves a live rig to lab software."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 (typer reads it)
from typing import TYPE_CHECKING, Annotated, Final

import typer

from app.cli.exit_codes import exit_code
from app.cli.terminal import Chosen, ProtocolPath, complain, values_of

if TYPE_CHECKING:
    from app.live.rig import LiveRig

LIVE_HELP: Final = (
    "\b\nExample:\n  knitlab live examples/filament.yaml --port 5025\n"
    "  printf '*IDN?\\nMEAS:FORC? C\\n' | nc 127.0.0.1 5025"
)


def live(
    protocol: ProtocolPath,
    *,
    port: Annotated[int, typer.Option(help="Port; 0 for a free one.", min=0, max=65535)] = 5025,
    host: Annotated[str, typer.Option(help="Address to listen on, of this machine alone.")] = "127.0.0.1",
    out: Annotated[
        Path | None,
        typer.Option(help="Run folder to write.", show_default="a new one under runs/", file_okay=False),
    ] = None,
    chosen: Chosen = None,
    pace: Annotated[
        float | None,
        typer.Option(help="Seconds of the rig in one second: 1 is real time.", show_default="no waiting", min=1e-6),
    ] = None,
    idle: Annotated[float, typer.Option(help="Seconds that a client may be silent while nothing moves.", min=0.1)] = (
        600.0
    ),
    pictures: Annotated[bool, typer.Option("--pictures/--no-pictures", help="Draw the curves and the knit.")] = True,
) -> None:
    """Mount a protocol's specimen, do its steps, and let one client drive the rig over TCP until Ctrl-C.

    Commands are SCPI-like lines (*IDN?, MOVE:ABS C,5e-3,2e-4, MEAS:FORC? C, *OPC?, SYST:ERR?); docs/live.md lists
    them. At the end the run folder holds what `knitlab run` would have written of a protocol with these steps.
    """
    from app.live.rig import LiveRig  # noqa: PLC0415 (lazy, as in app.cli.main)
    from app.live.server import serve_rig  # noqa: PLC0415
    from app.schemas import load  # noqa: PLC0415
    from app.views.drawing import draw_here  # noqa: PLC0415

    loaded = load(protocol, values_of(chosen))

    def mount() -> LiveRig:
        return LiveRig(loaded, out, pace=pace, draw=draw_here if pictures else None)

    result = serve_rig(mount, host, port, idle=idle).result
    said = f"{': ' if result.message else ''}{result.message}"
    complain(f"{result.folder}: {len(result.steps)} steps, {result.outcome}{said}")
    raise typer.Exit(exit_code(result))
