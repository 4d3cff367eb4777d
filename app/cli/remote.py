"""Commands that talk to a service."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.exit_codes import INTERRUPTED
from app.cli.terminal import ProtocolPath, Token, complain
from app.service.address import DEFAULT_SERVER
from app.service.jobs import State  # noqa: TC001 (typer reads the annotations)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.client import Client, Job

JobId = Annotated[str, typer.Argument(metavar="ID", help="Id of a job, as `knitlab submit` prints it.")]
Server = Annotated[
    str, typer.Option(envvar="KNITLAB_SERVER", help="Address of the service.", show_envvar=True, metavar="URL")
]
Out = Annotated[
    Path | None,
    typer.Option(help="Folder for the logs.", show_default="a new one under runs/", file_okay=False),
]
All = Annotated[bool, typer.Option("--all", help="Fetch the whole run folder, not the logs alone.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]

remote = typer.Typer()
jobs = typer.Typer(
    invoke_without_command=True,
    short_help="List the jobs of a service; pause, resume or show one.",
    epilog="\b\nExamples:\n  knitlab jobs --state running\n  knitlab jobs pause 3f2a9c0d41e65b78",
    rich_markup_mode=None,
)
remote.add_typer(jobs, name="jobs")


@remote.command(
    short_help="Submit a protocol to a service as a job.",
    epilog="\b\nExamples:\n  knitlab submit examples/biaxial_cycle.yaml --watch\n"
    "  knitlab submit sweep.yaml --timeout 2h --memory 4GiB --no-pictures",
)
def submit(
    protocol: ProtocolPath,
    *,
    follow: Annotated[bool, typer.Option("--watch", help="Follow the job to its end, and fetch its logs.")] = False,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Leave plot and pictures out.")] = False,
    timeout: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Longest time that a job may run, such as 2h.", show_default="none"),
    ] = None,
    memory: Annotated[
        str | None,
        typer.Option(metavar="SIZE", help="Most memory that a job may hold, such as 4GiB.", show_default="8GiB"),
    ] = None,
    out: Out = None,
    everything: All = False,
    server: Server = DEFAULT_SERVER,
    token: Token = None,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Submit a protocol as a job and print its id; with --watch follow it, as `knitlab watch` does.

    Every point of a `sweep:` becomes a job, all or none; the id is the sweep's, for `knitlab jobs --sweep`.
    The job goes on when this command is interrupted, and when the service is started again. Exit code 5: no service.
    """
    from app.schemas import load  # noqa: PLC0415
    from app.schemas.units import parse  # noqa: PLC0415
    from knitlab_core.errors import SpecificationError  # noqa: PLC0415

    loaded = load(protocol)
    if loaded.points and follow:
        raise SpecificationError("--watch", f"a sweep of {len(loaded.points)} points", "one test")
    asked: dict[str, Any] = {
        "name": loaded.protocol.name,
        "materials": loaded.materials,
        "timeout": None if timeout is None else parse(timeout, "time", "--timeout"),
        "memory": None if memory is None else round(parse(memory, "memory", "--memory")),
        "pictures": not no_pictures,
    }
    with _client(server, token) as client:
        if loaded.points:
            _print_sweep(client.sweep(loaded.text, **asked), as_json=as_json)
            return
        job = client.submit(loaded.text, **asked)
        if follow:
            _follow(client, job, out, everything=everything, quiet=quiet, as_json=as_json)
        else:
            _print_job(job, job.id, as_json=as_json)


@remote.command(
    short_help="Follow a job to its end; fetch its logs.",
    epilog="\b\nExample:\n  knitlab watch 3f2a9c0d41e65b78 --out runs/first",
)
def watch(
    job: JobId,
    *,
    out: Out = None,
    everything: All = False,
    server: Server = DEFAULT_SERVER,
    token: Token = None,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Follow a job to its end, over restarts of the service, and fetch its logs. The exit code is the test's own."""
    with _client(server, token) as client:
        _follow(client, client.job(job), out, everything=everything, quiet=quiet, as_json=as_json)


@remote.command(
    short_help="Cancel a job.",
    epilog="\b\nExample:\n  knitlab cancel 3f2a9c0d41e65b78",
)
def cancel(job: JobId, *, server: Server = DEFAULT_SERVER, token: Token = None, as_json: AsJson = False) -> None:
    """Ask a job to end; what it recorded is kept."""
    with _client(server, token) as client:
        _print_state(client.cancel(job), as_json=as_json)


@remote.command(
    short_help="Delete jobs that have ended, and their files.",
    epilog="\b\nExample:\n  knitlab delete 3f2a9c0d41e65b78 8b1e4d7706f3a25c",
)
def delete(
    jobs: Annotated[list[str], typer.Argument(metavar="ID...", help="Ids of jobs, as `knitlab jobs` lists them.")],
    *,
    server: Server = DEFAULT_SERVER,
    token: Token = None,
    as_json: AsJson = False,
) -> None:
    """Delete jobs that have ended, and their files, for good; one that has not ended is to be cancelled first.

    Each id is tried; exit code 2 if some job is not deleted.
    """
    from app.cli.exit_codes import USAGE  # noqa: PLC0415
    from app.service.errors import ServiceError  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    gone = []
    with _client(server, token) as client:
        for job in jobs:
            try:
                client.delete(job)
            except ServiceError as error:
                complain(str(error))
                continue
            gone.append(job)
            if not as_json:
                sys.stdout.write(f"deleted {job}\n")
    if as_json:
        print_json({"deleted": gone})
    if len(gone) < len(jobs):
        raise typer.Exit(USAGE)


@jobs.callback()
def _list(
    context: typer.Context,
    *,
    limit: Annotated[int, typer.Option(help="Most jobs to list.", min=1, max=1000)] = 20,
    state: Annotated[State | None, typer.Option(help="Only jobs in this state.", show_default=False)] = None,
    sweep: Annotated[str | None, typer.Option(help="Only jobs of this sweep.", show_default=False)] = None,
    server: Server = DEFAULT_SERVER,
    token: Token = None,
    as_json: AsJson = False,
) -> None:
    """List the jobs of a service, newest first."""
    if context.invoked_subcommand is not None:
        return
    from app.cli.tables import jobs_data, print_jobs  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    with _client(server, token) as client:
        page = client.jobs(limit=limit, state=state, sweep=sweep)
    if as_json:
        print_json(jobs_data(page.jobs))
    else:
        print_jobs(page.jobs)


@jobs.command()
def show(job: JobId, *, server: Server = DEFAULT_SERVER, token: Token = None, as_json: AsJson = False) -> None:
    """Show one job."""
    with _client(server, token) as client:
        _print_state(client.job(job), as_json=as_json)


@jobs.command()
def pause(job: JobId, *, server: Server = DEFAULT_SERVER, token: Token = None, as_json: AsJson = False) -> None:
    """Ask a job to rest at its checkpoint."""
    with _client(server, token) as client:
        _print_state(client.pause(job), as_json=as_json)


@jobs.command()
def resume(job: JobId, *, server: Server = DEFAULT_SERVER, token: Token = None, as_json: AsJson = False) -> None:
    """Let a paused job go on; `knitlab resume` goes on with a run of this machine's own."""
    with _client(server, token) as client:
        _print_state(client.resume(job), as_json=as_json)


def _client(server: str, token: str | None) -> Client:
    """Return a client of a service."""
    from app.client import Client  # noqa: PLC0415

    return Client(server, token)


def _print_state(job: Job, *, as_json: bool) -> None:
    """Print one job, its state first."""
    _print_job(job, f"{job.state} {job.id} {job.name} {job.progress.share:.0%} {job.message}".rstrip(), as_json=as_json)


def _print_sweep(jobs: Sequence[Job], *, as_json: bool) -> None:
    """Print the id of a sweep, or its jobs as JSON."""
    from app.cli.tables import jobs_data  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    if as_json:
        print_json(jobs_data(jobs))
    else:
        sys.stdout.write(f"{jobs[0].sweep}\n")
        complain(f"{len(jobs)} jobs: knitlab jobs --sweep {jobs[0].sweep}")


def _print_job(job: Job, text: str, *, as_json: bool) -> None:
    """Print a job as a line, or as JSON."""
    from app.cli.tables import jobs_data  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    if as_json:
        print_json(jobs_data([job])[0])
    else:
        sys.stdout.write(text + "\n")


def _follow(client: Client, job: Job, out: Path | None, *, everything: bool, quiet: bool, as_json: bool) -> None:
    """Follow a job to its end, fetch its logs, and exit with the code of its test."""
    from app.cli.exit_codes import job_exit_code  # noqa: PLC0415
    from app.cli.tables import jobs_data  # noqa: PLC0415
    from app.cli.watching import fetch_logs, watch_job  # noqa: PLC0415
    from app.file_names import file_stem  # noqa: PLC0415
    from app.records.folder import make_run_folder  # noqa: PLC0415
    from app.views.progress_bar import Bar  # noqa: PLC0415
    from app.views.tables import print_json  # noqa: PLC0415

    try:
        with Bar(hidden=quiet) as bar:
            ended = watch_job(client, job, bar.show)
    except KeyboardInterrupt:
        sys.stderr.write(f"job {job.id} goes on: knitlab watch {job.id}\n")
        raise typer.Exit(INTERRUPTED) from None
    folder = make_run_folder(Path("runs") / file_stem(ended.name) if out is None else out)
    fetched = fetch_logs(client, job.id, folder, everything=everything)
    if as_json:
        print_json({**jobs_data([ended])[0], "folder": str(folder), "files": [str(path) for path in fetched]})
    else:
        sys.stdout.write(f"{ended.state}: {ended.end}; folder: {folder}\n")
        sys.stdout.writelines(f"log: {path}\n" for path in fetched)
    if ended.message:
        sys.stderr.write(f"{ended.id}: {ended.message}\n")
    raise typer.Exit(job_exit_code(ended))
