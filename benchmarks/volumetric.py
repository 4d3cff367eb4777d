"""A volumetric knit's pile cycle to 40 % with free sides, timed: `python -m benchmarks.volumetric [size]`."""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

from app.checks.dry_run import build_specimen
from app.schemas import loads
from app.schemas.machine_data import machines_of
from benchmarks.main_job import PARTS, peak_memory
from rigs.control.experiment import perform
from rigs.machines.mounting import mount
from rigs.record import Equilibrium, Outcome

EXAMPLES = Path(__file__).resolve().parent.parent / "examples" / "fig4c"


def main(size: int) -> None:
    """Run the pile cycle of a knit of so many stitches each way once, and print where its seconds went."""
    text = (EXAMPLES / "fig4c_pile_4.yaml").read_text(encoding="utf-8")
    loaded = loads(text.replace("[4, 4, 4]", f"[{size}, {size}, {size}]"))
    began = perf_counter()
    specimen = build_specimen(loaded)
    rig, state = mount(specimen, loaded.protocol, machines_of(loaded.protocol))
    built = perf_counter() - began
    rows, outcome, before = [], None, {}
    for event in perform(rig, state, loaded.protocol):
        if isinstance(event, Equilibrium):
            rows.append(event)
            if len(rows) == 1:
                # The first row compiles what is not yet compiled on this machine.
                began, before = perf_counter(), dict(rig.work.clock.seconds)
        if isinstance(event, Outcome):
            outcome = event
    wall = perf_counter() - began
    n = sum(row.iterations for row in rows)
    solved = sum(row.iterations > 0 for row in rows)
    made = sum(row.factorisations for row in rows)
    peak = max(row.force["P"] for row in rows)
    print(f"volumetric {size}x{size}x{size}, pile cycle to 40 %: {outcome.end if outcome else 'no outcome'}")
    print(f"  {len(specimen.nodes)} nodes, built in {built:.1f} s, {peak_memory():.0f} MB at most, peak {peak:.4g} N")
    print(f"  {wall:.1f} s, {solved} equilibria, {n} iterations ({n / solved:.1f} each)")
    print(f"  {made} factorisations; failed searches are in all counts")
    spent = {part: rig.work.clock.seconds.get(part, 0.0) - before.get(part, 0.0) for part in PARTS}
    for part, seconds in spent.items():
        print(f"  {part:12s} {seconds:7.1f} s {seconds / wall:6.1%}")
    rest = wall - sum(spent.values())
    print(f"  {'outside':12s} {rest:7.1f} s {rest / wall:6.1%}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 6)
