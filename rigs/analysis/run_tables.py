"""Tables that only a virtual test has: energies, contacts, hooks, fused points, and the shape of its yarn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from rigs.analysis.shapes import legs, middle_width, parts, poisson_ratio, yarn_elongation
from rigs.analysis.table import Table, table_of
from rigs.axes import COORDINATE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigs.analysis.table import Cell
    from rigs.axes import Axis, FloatArray
    from rigs.record import Frame, SpecimenSize
    from rigs.trace import Trace

STORED: Final = ("elastic_stretch", "elastic_bend", "elastic_twist", "contact_energy", "bond_energy")
"""Columns of energies that a knit stores; they sum up to what it has."""

LOST: Final = ("friction_work", "viscous_work", "plastic_work", "fracture_work", "snap_work", "bond_released")
"""Columns of energies that it has lost since the start."""

BINS: Final = 40
"""Bins of a histogram of breaks over strain."""


def strains_of(trace: Trace, size: SpecimenSize) -> dict[Axis, FloatArray]:
    """Return the strain of every driven axis from the specimen as mounted [1], (n,)."""
    return {axis: trace.columns[f"displacement_{axis}"] / size.gauge(axis) for axis in trace.axes}


def _base(trace: Trace, size: SpecimenSize) -> dict[str, Sequence[Cell]]:
    columns: dict[str, Sequence[Cell]] = {"time": trace.columns["time"].tolist()}
    columns |= {f"strain {axis}": strain.tolist() for axis, strain in strains_of(trace, size).items()}
    return {"cycle": trace.columns["cycle"].astype(np.int64).tolist(), "phase": list(trace.phase), **columns}


def _base_units(axes: Sequence[str]) -> dict[str, str]:
    return {"time": "s", **{f"strain {axis}": "1" for axis in axes}}


def shares(parts: Sequence[FloatArray]) -> list[FloatArray]:
    """Return parts (n,) over their sum [1], row by row; ``nan`` where that is not above 0."""
    total = np.sum(parts, axis=0)
    safe = np.where(total > 0.0, total, np.nan)
    return [part / safe for part in parts]


def energy_table(trace: Trace, size: SpecimenSize) -> Table:
    """Return the stored energies over their sum at every row, and what was lost over the work of the carriages.

    Stored are stretch, bending and twist of the yarn, contacts and fused points: their shares sum up to 1. Lost are
    friction, relaxation, yielding, breaks and snaps since the start, each over the external work since then.
    """
    columns, units = _base(trace, size), _base_units(trace.axes)
    stored = {name: trace.columns[name] for name in STORED if name in trace.columns}
    for name, share in zip(stored, shares(list(stored.values())), strict=True):
        columns[f"{name} of stored"] = share.tolist()
    work = trace.columns["external_work"] - trace.columns["external_work"][0]
    for column in (column for column in LOST if column in trace.columns):
        lost = trace.columns[column] - trace.columns[column][0]
        share = np.divide(lost, work, out=np.full(len(work), np.nan), where=work > 0.0)
        columns[f"{column} of external work"] = share.tolist()
    columns |= {"stored energy": np.sum(list(stored.values()), axis=0).tolist(), "external work": work.tolist()}
    units |= {name: "1" for name in columns if " of " in name} | {"stored energy": "J", "external work": "J"}
    return Table(name="energy", columns=columns, units=units)


def contacts_table(trace: Trace, size: SpecimenSize) -> Table:
    """Return the touching pairs of samples at every row, over strain, with the share of its largest number."""
    contacts = trace.columns["contacts"]
    most = float(contacts.max()) if len(contacts) else 0.0
    columns = _base(trace, size) | {
        "contacts": contacts.astype(np.int64).tolist(),
        "contacts of most": (contacts / most if most else contacts).tolist(),
        "contact energy": trace.columns["contact_energy"].tolist(),
    }
    units = _base_units(trace.axes) | {"contacts of most": "1", "contact energy": "J"}
    return Table(name="contacts", columns=columns, units=units)


def hooks_table(trace: Trace, size: SpecimenSize, hooks: Mapping[Axis, int]) -> Table:
    """Return the largest force of a hook along its pole over the mean one that it pulls with, at every row.

    The latter is the force of the axis that pulls most over its hooks on one side. 0 of a hook that slides freely.

    Parameters
    ----------
    trace, size
        The equilibria, and the specimen's lengths.
    hooks : mapping of Axis to int
        Hooks on a side of each axis.
    """
    pulls = [np.abs(trace.columns[f"force_{axis}"]) / hooks[axis] for axis in trace.axes if hooks.get(axis)]
    pull = np.max(pulls, axis=0) if pulls else np.full(len(trace), np.nan)
    lateral = trace.columns["lateral_force"]
    ratio = np.divide(lateral, pull, out=np.full(len(lateral), np.nan), where=pull > 0.0)
    columns = _base(trace, size) | {
        "lateral force": lateral.tolist(),
        "axial force of a hook": pull.tolist(),
        "lateral over axial": ratio.tolist(),
    }
    units = _base_units(trace.axes) | {"lateral force": "N", "axial force of a hook": "N", "lateral over axial": "1"}
    return Table(name="hooks", columns=columns, units=units)


def break_histogram(strain: FloatArray, broken: FloatArray, bins: int = BINS) -> tuple[FloatArray, FloatArray]:
    """Return how many fused points broke in each bin of strain.

    Parameters
    ----------
    strain, broken : FloatArray, shape (n,)
        Strain [1], and how many have broken so far, row by row.
    bins : int
        Bins between the least and the largest strain.

    Returns
    -------
    edges : FloatArray, shape (bins + 1,)
        [1].
    counts : FloatArray, shape (bins,)
        Those that broke at a row count at its strain; their sum is the number that broke.
    """
    news = np.diff(broken, prepend=broken[:1])
    counts, edges = np.histogram(strain, bins=bins, weights=news)
    return edges, counts


def bonds_table(trace: Trace, size: SpecimenSize) -> Table:
    """Return the histogram of breaks of fused points over the strain of each axis that was strained."""
    rows: list[Mapping[str, Cell]] = []
    broken = trace.columns["bonds_broken"]
    for axis, strain in strains_of(trace, size).items():
        if not broken.any() or np.ptp(strain) == 0.0:
            continue
        edges, counts = break_histogram(strain, broken)
        rows += [
            {"axis": axis, "from strain": float(low), "to strain": float(high), "broken": round(float(count))}
            for low, high, count in zip(edges[:-1], edges[1:], counts, strict=True)
        ]
    units = {"from strain": "1", "to strain": "1"}
    if not rows:
        return Table(name="bonds", columns={"axis": [], "from strain": [], "to strain": [], "broken": []}, units=units)
    return table_of("bonds", rows, units)


def shapes_table(frames: Sequence[Frame], strands: Sequence[int]) -> Table:
    """Return what the stored shapes tell: ΔL/L of the yarn, angles of legs, contraction across each axis.

    Widths are at the middle of the knit, and strains across count from the first shape.
    """
    rows: list[Mapping[str, Cell]] = []
    planar: tuple[Axis, ...] = ("C", "W")
    across: dict[Axis, Axis] = {"C": "W", "W": "C"}
    widths = {
        axis: [middle_width(one.nodes, COORDINATE[axis], COORDINATE[across[axis]]) for one in frames] for axis in planar
    }
    for number, frame in enumerate(frames):
        found = [legs(part) for part in parts(frame.nodes, strands)]
        angle, straight = (np.concatenate([one[k] for one in found]) for k in (0, 1))
        row: dict[str, Cell] = {"cycle": frame.cycle, "phase": frame.phase, "time": frame.time}
        row |= {f"strain {axis}": strain for axis, strain in frame.strain.items()}
        row["yarn elongation"] = yarn_elongation(frame.nodes, frame.axial_strain, strands)
        row["largest axial strain"] = float(np.nanmax(frame.axial_strain))
        row["median leg angle"] = float(np.degrees(np.median(angle))) if len(angle) else float("nan")
        row["leg angle deviation"] = float(np.degrees(angle.std())) if len(angle) else float("nan")
        row["median leg straightness"] = float(np.median(straight)) if len(straight) else float("nan")
        for axis in planar:
            # Where the other axis is driven too it does not contract by itself.
            if axis in frame.strain and across[axis] not in frame.strain:
                transverse = widths[axis][number] / widths[axis][0] - 1.0 if widths[axis][0] > 0.0 else float("nan")
                row[f"transverse strain of {axis}"] = transverse
                ratio = poisson_ratio(np.array([frame.strain[axis]]), np.array([transverse]))
                row[f"Poisson's ratio of {axis}"] = float(ratio[0])
        rows.append(row)
    units = {name: "deg" if "angle" in name else "1" for name in (rows[0] if rows else {})} | {"time": "s"}
    for name in ("cycle", "phase"):
        units.pop(name, None)
    return table_of("shapes", rows, units, "cycle", "phase")
