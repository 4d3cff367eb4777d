"""How processor time grows with the size of a knit: `python -m benchmarks.growth [KIND] [size ...]`.

Kinds are planar and volumetric specimens, and periodic cells (`cell`, `volumetric-cell`).

With `KNITLAB_THREADS=1` it is the time on a machine at rest, nearly whatever else runs.
"""

from __future__ import annotations

import sys
from time import process_time
from typing import Final

import numpy as np

from app.checks.dry_run import build_specimen
from app.schemas import loads
from app.schemas.machine_data import machines_of
from benchmarks.main_job import PROTOCOL, peak_memory
from benchmarks.volumetric import EXAMPLES
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.record import Equilibrium

SIZES: Final = {
    "planar": (3, 6, 10, 14, 20),
    "volumetric": (2, 3, 4, 6, 8),
    "cell": (1, 2, 3, 4, 6, 8),
    "volumetric-cell": (1, 2, 3, 4),
}
TEXTS: Final = {
    "planar": (PROTOCOL, "[6, 6]", "[{0}, {0}]", "n: 2", "n: 1"),
    "volumetric": (EXAMPLES / "fig4c_pile_4.yaml", "[4, 4, 4]", "[{0}, {0}, {0}]", "n: 1", "n: 1"),
    "cell": (EXAMPLES.parent / "cell.yaml", "[2, 2]", "[{0}, {0}]", "n: 1", "n: 1"),
    "volumetric-cell": (EXAMPLES.parent / "volumetric_cell.yaml", "[1, 1, 2]", "[{0}, {0}, 2]", "n: 1", "n: 1"),
}


def cycle(kind: str, size: int) -> tuple[int, int, float]:
    """Run one cycle to 40 % and back; return nodes, iterations and processor seconds from the first row on."""
    path, old, new, cycles, one = TEXTS[kind]
    text = path.read_text(encoding="utf-8").replace(old, new.format(size)).replace(cycles, one)
    loaded = loads(text)
    specimen = build_specimen(loaded)
    rig, state = mount(specimen, loaded.protocol, machines_of(loaded.protocol))
    began, iterations = process_time(), 0
    for event in perform(rig, state, loaded.protocol):
        if isinstance(event, Equilibrium):
            iterations += event.iterations
    return len(specimen.nodes), iterations, process_time() - began


def main(kind: str, sizes: tuple[int, ...]) -> None:
    """Print a line per size, and the exponents of iterations, time per iteration and time over nodes."""
    cycle(kind, 2)
    rows = []
    for size in sizes:
        nodes, iterations, seconds = cycle(kind, size)
        rows.append((nodes, iterations, seconds / iterations, seconds))
        each = 1e3 * seconds / iterations
        print(
            f"{kind} {size:2d}: {nodes:6d} nodes {iterations:5d} iterations {each:7.2f} ms each "
            f"{seconds:7.1f} s  {peak_memory():5.0f} MB so far",
            flush=True,
        )
    if len(rows) > 1:
        logs = np.log(np.array(rows))
        for name, column in (("iterations", 1), ("time of one", 2), ("time", 3)):
            print(f"  {name} grow as nodes^{np.polyfit(logs[:, 0], logs[:, column], 1)[0]:.2f}")


if __name__ == "__main__":
    chosen = sys.argv[1] if len(sys.argv) > 1 else "planar"
    main(chosen, tuple(int(size) for size in sys.argv[2:]) or SIZES[chosen])
