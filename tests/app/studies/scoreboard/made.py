"""Records that no solver made, of which every score is known."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from app.studies.scoreboard.analysed import Analysed
from app.studies.scoreboard.plan import CHANGED, MATERIALS
from rigs.analysis.table import Table
from rigs.measurement import Measurement

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from rigs.analysis.table import Cell
    from rigs.axes import FloatArray

    Curve = Callable[[FloatArray, int], FloatArray]

ROWS = 41
STRAIN = np.linspace(0.0, 0.4, ROWS)


def cycles(
    axis: str, out: Curve, back: Curve | None = None, count: int = 1, strain: FloatArray = STRAIN
) -> Measurement:
    """Return cycles along an axis: stress [Pa] over strain on the way out, and back where it comes back."""
    strains, stresses, phases, numbers = [strain[:1]], [out(strain[:1], 1)], ["Zero"], [1]
    for number in range(1, count + 1):
        ways = [("Stretch", strain[1:], out)] + ([("Recover", strain[-2::-1], back)] if back is not None else [])
        for phase, way, stress in ways:
            strains.append(way)
            stresses.append(stress(way, number))
            phases += [phase] * len(way)
            numbers += [number] * len(way)
    x, y = np.concatenate(strains), np.concatenate(stresses)
    nothing = np.full(len(x), np.nan)
    return Measurement(
        name="made",
        axis=axis,
        time=np.arange(len(x), dtype=np.float64),
        travel=0.05 * x,
        force=1e-5 * y,
        strain=x,
        stress=y,
        transverse=nothing,
        cycle=np.array(numbers),
        phase=tuple(phases),  # type: ignore[arg-type]
        sampled=False,
    )


def record_of(
    name: str, curves: Sequence[Measurement] = (), facts: Mapping[str, float] = MappingProxyType({})
) -> Analysed:
    return Analysed(name=name, curves={one.axis: one for one in curves}, facts=facts)


def tables_of(name: str, tables: Mapping[str, Mapping[str, Sequence[Cell]]]) -> Analysed:
    """Return a test with tables alone, at the rows of one loading where they name no cycle."""
    made = {}
    for table, columns in tables.items():
        count = len(next(iter(columns.values())))
        rows: dict[str, Sequence[Cell]] = {"cycle": [1] * count, "phase": ["Stretch"] * count}
        made[table] = Table(name=table, columns={**rows, **columns})
    return Analysed(name=name, tables=made.__getitem__)


def line(slope: float) -> Curve:
    return lambda strain, _: slope * strain


def exponential(amplitude: float, rate: float) -> Curve:
    return lambda strain, _: amplitude * np.exp(rate * strain)


BASE = {"a": 1.55, "h": 4.88e-3, "d": 2e-3, "w": 5.36e-3, "r": 0.316e-3, "l": 8e-3, "n": 1.0, "L": 30e-3}
MODULI = dict(zip(MATERIALS, (0.82e9, 2.0e9), strict=True))


def designs(exponents: Mapping[str, float], *, wale: float = 1.0) -> dict[str, Analysed]:
    """Return all designs: stresses are powers of their numbers times exp(16.5 ε), `wale` times that along the wale."""
    numbers: dict[str, dict[str, float]] = {"fig3c": {**BASE, "E": 1.1e9}}
    for name, values in CHANGED.items():
        for value in values:
            scale = 1.0 if name in {"a", "n"} else 1e-3
            numbers[f"fig3c {name}={value:g}"] = {**BASE, "E": 1.1e9, name: scale * value}
    for material, modulus in MODULI.items():
        numbers[f"fig3c {material}"] = {**BASE, "E": modulus}
    found = {}
    for name, design in numbers.items():
        level = 1e3 * float(
            np.prod([(design[key] / numbers["fig3c"][key]) ** power for key, power in exponents.items()])
        )
        curves = [cycles("C", exponential(level, 16.5)), cycles("W", exponential(wale * level, 16.5))]
        facts = {**design, "young_modulus": design["E"], "thickness": 1e-3, "locking_strain": 0.6}
        found[name] = record_of(name, curves, facts)
    return found
