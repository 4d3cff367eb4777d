"""Run a small test on each kind of specimen and keep its rows, to compare them between processors and threads.

    python -m tests.reproducible_runs              # one process for each target of code, then a table of differences
    python -m tests.reproducible_runs --out FILE   # this process alone: rows of every specimen, as JSON

Compiled kernels are kept for each target, so a second run needs no compilation.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from app.schemas import load
from app.schemas.machine_data import machines_of
from knitlab_core.knits import NAMED_STITCHES
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Cycle, Protocol, Ramp, Target, Zero
from rigs.record import Equilibrium
from rigs.trace import trace_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from rigs.axes import Axis
    from rigs.protocol.step import Step

    Rows: TypeAlias = dict[str, list[float]]
    Runs: TypeAlias = dict[str, Rows]

ROOT: Final = Path(__file__).parents[1]
EXAMPLES: Final = ROOT / "examples"

OLD_C_LIBRARY: Final = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"}
OLD_BLAS: Final = {"OPENBLAS_CORETYPE": "Nehalem"}
OLD_NUMPY: Final = {"NPY_DISABLE_CPU_FEATURES": "X86_V3"}
OLD_LIBRARIES: Final = {**OLD_C_LIBRARY, **OLD_BLAS, **OLD_NUMPY}

TARGETS: Final[Mapping[str, Mapping[str, str]]] = {
    "host": {},
    "two threads": {"KNITLAB_THREADS": "2"},
    "generic kernels": {"NUMBA_CPU_NAME": "generic"},
    "BLAS of Nehalem": OLD_BLAS,
    "C library without FMA": OLD_C_LIBRARY,
    "NumPy without AVX2": OLD_NUMPY,
    "all of these": {"KNITLAB_THREADS": "2", "NUMBA_CPU_NAME": "generic", **OLD_LIBRARIES},
    "all but kernels": {"KNITLAB_THREADS": "2", **OLD_LIBRARIES},
}
"""Environment of the process that runs the specimens, by the name of the target; the first is the one compared with.

Unless said otherwise it has one thread. On processors other than x86-64 some of these change nothing.
"""

QUICK: Final = ("planar 2x2", "fused", "viscoelastic", "yielding")
"""Specimens that take a few seconds together."""


def _pulled(to: float, *axes: Axis) -> tuple[Step, ...]:
    return Zero(), Ramp(axes=axes or ("C", "W"), to=Target(kind="strain", value=to), rate=2e-4)


def _cycled(upper: float, *axes: Axis) -> tuple[Step, ...]:
    return Zero(), Cycle(axes=axes or ("C", "W"), lower=0.0, upper=upper, rate=2e-4, n=1)


def _planar(knit: str, size: int, steps: tuple[Step, ...]) -> Protocol:
    protocol = load(EXAMPLES / "biaxial_small.yaml").protocol
    quiet = replace(protocol.log, noise=False)
    specimen = replace(protocol.specimen, knit=NAMED_STITCHES[knit], rows=size, loops=size, nodes_per_loop=32)
    return replace(protocol, specimen=specimen, steps=steps, log=quiet, max_strain_increment=0.025)


def _volumetric() -> Protocol:
    protocol = load(EXAMPLES / "fig4c" / "fig4c_pile_4.yaml").protocol
    specimen = replace(protocol.specimen, rows=2, loops=2, layers=2, nodes_per_loop=32)
    quiet = replace(protocol.log, noise=False)
    return replace(protocol, specimen=specimen, steps=_cycled(0.1, "P"), log=quiet, max_strain_increment=0.02)


def _example(name: str, steps: tuple[Step, ...] | None = None, **specimen: int) -> Protocol:
    protocol = load(EXAMPLES / f"{name}_small.yaml").protocol
    made = replace(protocol.specimen, **specimen)  # type: ignore[arg-type]
    return replace(protocol, specimen=made, steps=steps or protocol.steps, max_strain_increment=0.025)


def _of_fibres() -> Protocol:
    protocol = _example("bundle", _cycled(0.2))
    yarn = protocol.specimen.yarn
    assert yarn is not None
    return replace(protocol, specimen=replace(protocol.specimen, yarn=replace(yarn, model="yarn")))


def _cell() -> Protocol:
    protocol = load(EXAMPLES / "cell.yaml").protocol
    specimen = replace(protocol.specimen, nodes_per_loop=24)
    return replace(protocol, specimen=specimen, steps=_cycled(0.36), max_strain_increment=0.025)


SPECIMENS: Final[Mapping[str, Callable[[], Protocol]]] = {
    "planar 2x2": lambda: _planar("stockinette-default", 2, _cycled(0.25)),
    "paper-fit 3x3": lambda: _planar("paper-fit", 3, _cycled(0.3)),
    "plain-knit 2x2": lambda: _planar("plain-knit", 2, _cycled(0.25)),
    "volumetric 2x2x2": _volumetric,
    "bundle of 2 fibres": lambda: _example("bundle", _pulled(0.1), nodes_per_loop=32),
    "yarn of 2 fibres": _of_fibres,
    "cotton": lambda: _example("cotton", _cycled(0.1), rows=2, loops=2, nodes_per_loop=24),
    "fused": lambda: _example("fused", nodes_per_loop=32),
    "wire hooks": lambda: _example("wire", _cycled(0.25), rows=2, loops=2),
    "viscoelastic": lambda: _example("creeping", nodes_per_loop=32),
    "yielding": lambda: _example("yielding", _cycled(0.3), nodes_per_loop=32),
    "yarn by measurement": lambda: _example("yarn", _cycled(0.3)),
    "periodic cell": _cell,
    "fabric at rest, pulled": lambda: load(EXAMPLES / "fabric" / "stockinette_wale.yaml").protocol,
}
"""A short test on each kind of specimen."""


def run(names: Collection[str] = SPECIMENS) -> Runs:
    """Carry out the tests of some specimens; return displacements [m], forces [N] and friction's work [J] of rows."""
    found = {}
    for name in names:
        begun = time.perf_counter()
        protocol = SPECIMENS[name]()
        rig, state = mount(make_specimen(protocol.specimen), protocol, machines_of(protocol))
        trace = trace_of([event for event in perform(rig, state, protocol) if isinstance(event, Equilibrium)])
        kept = [f"{kind}_{axis}" for axis in trace.axes for kind in ("displacement", "force")]
        found[name] = {column: trace.columns[column].tolist() for column in ("time", *kept, "friction_work")}
        print(f"{name}: {len(trace)} rows, {time.perf_counter() - begun:.1f} s", file=sys.stderr)  # noqa: T201
    return found


def run_as(target: str, names: Collection[str] = SPECIMENS) -> Runs:
    """Carry out the tests in a process of their own, made for a target."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "rows.json"
        words = [sys.executable, "-m", "tests.reproducible_runs", "--out", str(out), *names]
        # A service in the same process may have set PYTHONSAFEPATH, which leaves the folder of work out.
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "KNITLAB_THREADS": "1", **TARGETS[target]}
        subprocess.run(words, cwd=ROOT, env=environment, check=True)  # noqa: S603
        runs: Runs = json.loads(out.read_text(encoding="utf-8"))
    return runs


@dataclass(frozen=True, slots=True)
class Difference:
    """Hold how far two runs of one test are apart.

    Attributes
    ----------
    share : float
        Largest difference of forces, relative to the largest force of its axis [1].
    same_bits : bool
        Whether all rows are equal to the last bit.
    """

    share: float
    same_bits: bool


def difference(one: Rows, other: Rows) -> Difference:
    """Compare two runs at the times that both have a row at."""
    shares = []
    for column in (name for name in one if name.startswith("force")):
        # Of rows at one time, as where strands snap, the last one counts.
        force, beside = (dict(zip(np.round(run["time"], 6).tolist(), run[column], strict=True)) for run in (one, other))
        apart = max(abs(force[time] - beside[time]) for time in force.keys() & beside.keys())
        shares.append(apart / max(map(abs, one[column])))
    return Difference(share=max(shares), same_bits=one == other)


def table(runs: Mapping[str, Runs]) -> str:
    """Return a table of what the targets found: equal bits, or the largest difference relative to the peak."""
    first, *others = runs
    lines = [f"| specimen | rows | {' | '.join(others)} |", "|---|---|" + "---|" * len(others)]
    for name, wanted in runs[first].items():
        found = [difference(wanted, runs[other][name]) for other in others]
        cells = ["equal bits" if one.same_bits else f"{one.share:.1e}" for one in found]
        lines.append(f"| {name} | {len(wanted['time'])} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="specimens; all by default")
    parser.add_argument("--out", type=Path, help="file for the rows of this process; no table")
    given = parser.parse_args()
    chosen = given.names or list(SPECIMENS)
    if given.out is None:
        print(table({target: run_as(target, chosen) for target in TARGETS}))  # noqa: T201
    else:
        given.out.write_text(json.dumps(run(chosen)), encoding="utf-8")
