"""The master curve of planar knits: designs that fill the ranges of their numbers, as cells pulled both ways."""

from __future__ import annotations

import csv
import io
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import TYPE_CHECKING, Final

import numpy as np

from app.records.folder import RECORD, write_whole
from app.records.reader import RunReader
from app.runs.use_cases import has_ended, run_protocol
from app.schemas import to_yaml
from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits import Stitch, Yarn, knit_cell, locking_strain, same_area, yarn_per_loop
from knitlab_core.materials import Material, Value
from rigs.analysis.master_curve import (
    Collapse,
    Design,
    PowerLaw,
    bending_factor,
    collapse,
    paper_factor,
    power_law,
)
from rigs.analysis.stress_strain import stress_strain
from rigs.protocol.protocol import LogSpec, Protocol
from rigs.protocol.specimen import SpecimenSpec
from rigs.protocol.steps import Ramp, Zero
from rigs.protocol.targets import Target

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from app.runs.publishing import Progress
    from rigs.axes import Axis

RANGES: Final[Mapping[str, tuple[float, float]]] = {
    "l": (4e-3, 12e-3),
    "a": (1.4, 1.7),
    "h": (0.62, 0.92),
    "gap": (0.05, 0.16),
    "d": (0.18, 0.32),
    "r": (0.032, 0.055),
    "n": (1.0, 5.0),
    "E": (0.5e9, 3.0e9),
}
"""Ends of the ranges: l [m] and E [Pa]; a and n [1]; h, d and r in loop widths, `gap` is w - h; n is 1 to 4 fibres."""

FITTED: Final = ("E", "r", "n", "d", "a", "h", "w", "l")
"""Parameters of the fit; lengths in metres."""

FRICTION: Final = 0.3
POISSON: Final = 0.37
TRIED: Final = 40
"""Designs tried for each that is wanted: many of the ranges overlap or do not hold each other."""

REACH: Final = 0.97
"""Strain of the pull, in the estimated locking strain of the design."""

FAR: Final = 0.94
"""Where exponents are fitted, in the locking strain."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """A design: its name, numbers in SI units, and its test."""

    name: str
    values: Mapping[str, float]
    lock: float
    protocol: Protocol


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """What the designs say.

    Attributes
    ----------
    designs : tuple of Design
        One an axis of each design that reached its strain.
    laws : Mapping
        Fit of each axis at `FAR` of the locking strain.
    collapses : tuple of Collapse
        How far the curves of both axes lie apart under each scaling.
    missed : tuple of str
        Designs that did not reach their strain, and why.
    """

    designs: tuple[Design, ...]
    laws: Mapping[Axis, PowerLaw]
    collapses: tuple[Collapse, ...]
    missed: tuple[str, ...]


def planned(points: int) -> list[Planned]:
    """Return so many designs of a Halton sequence, those that cannot exist left out; a larger plan begins with it."""
    from scipy.stats import qmc  # noqa: PLC0415 (imported when a study is wanted)

    found: list[Planned] = []
    shares = qmc.Halton(len(RANGES), rng=np.random.default_rng(1)).random(TRIED * points)
    for number, row in enumerate(shares):
        values = {
            name: low + share * (high - low) for (name, (low, high)), share in zip(RANGES.items(), row, strict=True)
        }
        design = _design(number, values)
        if design is not None:
            found.append(design)
        if len(found) == points:
            break
    return found


def _design(number: int, drawn: Mapping[str, float]) -> Planned | None:
    """Return a design of drawn numbers, None if it cannot exist."""
    rounded = {name: float(f"{value:.4g}") for name, value in drawn.items()}
    fibres = min(4, int(rounded["n"]))
    stitch = Stitch(
        curvature=rounded["a"],
        height=rounded["h"],
        depth=rounded["d"],
        row_spacing=float(f"{rounded['h'] + rounded['gap']:.4g}"),
        fibre_radius=rounded["r"],
    )
    # The fibres of a yarn share its area, and stick together.
    yarn = None if fibres == 1 else replace(same_area(stitch.fibre_radius, fibres), bonding=1.0)
    thick = stitch.fibre_radius if yarn is None else yarn.contact_radius
    lock = locking_strain(stitch, yarn_per_loop(stitch), thick)
    if not 0.15 < lock < 0.7:
        return None
    try:
        knit_cell(stitch, loop_width=rounded["l"], rows=2, loops=2, nodes_per_loop=32, yarn=yarn)
    except (GeometryError, SpecificationError):
        return None
    width = rounded["l"]
    values = {
        "l": width,
        "a": stitch.curvature,
        "h": stitch.height * width,
        "w": stitch.row_spacing * width,
        "d": stitch.depth * width,
        "r": (stitch.fibre_radius if yarn is None else yarn.fibre_radius) * width,
        "n": float(fibres),
        "E": rounded["E"],
        "L": yarn_per_loop(stitch) * width,
        "t": 0.0,
    }
    return Planned(
        name=f"design-{number:04d}", values=values, lock=lock, protocol=_protocol(stitch, yarn, values, REACH * lock)
    )


def _protocol(stitch: Stitch, yarn: Yarn | None, values: Mapping[str, float], strain: float) -> Protocol:
    """Return the test of a design: a cell of 2 x 2 loops pulled both ways to a strain."""
    resin = Material(
        name="resin",
        young_modulus=Value(value=values["E"], unit="Pa", source="varied in this study", assumed=True),
        poisson_ratio=Value(value=POISSON, unit="1", source="that of RGD8530-DM", assumed=True),
    )
    specimen = SpecimenSpec(
        knit=stitch,
        rows=2,
        loops=2,
        loop_width=values["l"],
        material=resin,
        friction=FRICTION,
        nodes_per_loop=32,
        yarn=yarn,
        periodic=True,
    )
    ramp = Ramp(axes=("C", "W"), to=Target(kind="strain", value=float(f"{strain:.4g}")), rate=2e-4)
    return Protocol(
        name="design",
        rig="biaxial-hook",
        specimen=specimen,
        speed_ref="pair",
        others="hold",
        log=LogSpec(rate=1.0, noise=False),
        steps=(Zero(channels=("force", "displacement")), ramp),
    )


def run_study(out: Path, progress: Progress, *, points: int = 32, jobs: int = 1) -> Study:
    """Run all designs that have not been run, and compare their curves.

    Parameters
    ----------
    out : Path
        Folder of the study; each design gets one in it, with its protocol.
    progress : callable
        Told the share done [1] and what is being done.
    points : int
        Designs, 12 to 1000.
    jobs : int
        Processes that run at once.

    Raises
    ------
    SpecificationError
        For another number of designs or processes.
    """
    if not 12 <= points <= 1000:
        raise SpecificationError("--points", points, "a whole number from 12 to 1000")
    if not 1 <= jobs <= 64:
        raise SpecificationError("--jobs", jobs, "a whole number from 1 to 64")
    out.mkdir(parents=True, exist_ok=True)
    progress(0.0, "looking for designs that can be knitted")
    designs = planned(points)
    todo = [one for one in designs if not _is_done(out / one.name)]
    for one in todo:
        write_whole(out / f"{one.name}.yaml", [to_yaml(one.protocol).encode()])
    done = len(designs) - len(todo)
    for name in _run_all(out, todo, jobs):
        done += 1
        progress(done / len(designs), f"{name} done")
    return _judged(out, designs)


def _is_done(folder: Path) -> bool:
    """Return whether a design was run to an end."""
    return (folder / RECORD).exists() and has_ended(RunReader(folder / RECORD)) is not None


def _run_all(out: Path, todo: list[Planned], jobs: int) -> Iterator[str]:
    """Run designs, and yield the name of each that is done."""
    if jobs == 1:
        for one in todo:
            _run_one(out, one.name)
            yield one.name
        return
    with ProcessPoolExecutor(max_workers=jobs, mp_context=get_context("spawn")) as pool:
        running = {pool.submit(_run_one, out, one.name): one.name for one in todo}
        for finished in as_completed(running):
            finished.result()
            yield running[finished]


def _run_one(out: Path, name: str) -> None:
    """Run one design in its folder."""
    run_protocol(out / f"{name}.yaml", out / name, exact=True, draw=None)


def _judged(out: Path, designs: list[Planned]) -> Study:
    """Return what the curves of the designs say."""
    curves: list[Design] = []
    locks: list[float] = []
    missed: list[str] = []
    for one in designs:
        run = RunReader(out / one.name / RECORD)
        if run.outcome.end != "target":
            missed.append(f"{one.name}: {run.outcome.end}: {run.outcome.message}")
            continue
        columns = run.trace.columns
        values = {**one.values, "t": run.size.extents["P"]}
        for axis in run.trace.axes:
            strain, stress = stress_strain(columns[f"displacement_{axis}"], columns[f"force_{axis}"], axis, run.size)
            curves.append(Design(name=one.name, axis=axis, values=values, strain=strain, stress=stress))
            locks.append(one.lock)
    scaled = [
        Design(name=one.name, axis=one.axis, values=one.values, strain=one.strain / lock, stress=one.stress)
        for one, lock in zip(curves, locks, strict=True)
    ]
    axes: tuple[Axis, ...] = ("C", "W")
    laws = {axis: power_law([one for one in scaled if one.axis == axis], FITTED, FAR) for axis in axes}
    return Study(
        designs=tuple(scaled), laws=laws, collapses=tuple(_collapses(curves, locks, laws)), missed=tuple(missed)
    )


def _collapses(curves: list[Design], locks: list[float], laws: Mapping[Axis, PowerLaw]) -> Iterator[Collapse]:
    """Yield how far the curves lie apart under each scaling, near their locking strain."""
    near = (0.9, REACH * 0.999)
    ones = [1.0] * len(curves)
    stiff = [1.0 / one.values["E"] for one in curves]
    paper = [paper_factor(one.values, one.axis) for one in curves]
    bending = [bending_factor(one.values, one.axis) for one in curves]
    yield collapse("stress over strain / locking strain", curves, ones, locks, between=near)
    yield collapse("stress / E over the same", curves, stiff, locks, between=near)
    yield collapse("xi stress (the paper) over the same", curves, paper, locks, between=near)
    yield collapse("t L l w stress / (E I) over the same", curves, bending, locks, between=near)
    fitted = [1.0 / laws[one.axis].stress(one.values) for one in curves]
    yield collapse("fitted powers of each axis over the same", curves, fitted, locks, between=near)


def table_of(study: Study) -> str:
    """Return the curves' parameters and stresses at `FAR` of the locking strain as CSV."""
    text = io.StringIO()
    writer = csv.writer(text)
    names = list(study.designs[0].values) if study.designs else []
    writer.writerow(["design", "axis", *names, f"stress at {FAR:g} of the locking strain [Pa]"])
    for one in study.designs:
        row = [f"{one.values[name]:.6g}" for name in names]
        writer.writerow([one.name, one.axis, *row, f"{float(one.stress_at(FAR)):.6g}"])
    return text.getvalue()
