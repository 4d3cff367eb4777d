"""Scores of volumetric rows and of the constants on records with a known answer: reproduced, and not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.studies.scoreboard import constants, volumetric
from app.studies.scoreboard.analysed import Analysed, UnscorableError
from tests.app.studies.scoreboard.made import cycles, exponential, line, record_of, tables_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigs.analysis.table import Cell
    from tests.app.studies.scoreboard import made


def printed(strands: float, between_layers: float, clearance: float) -> dict[str, Analysed]:
    found = {}
    for name, rows, layers, per_layer in (("4x4x2", 4.0, 2.0, between_layers), ("6x6x6", 6.0, 6.0, 180.0)):
        facts = {"rows": rows, "loops": rows, "layers": layers, "strands": strands, "clearance": clearance}
        counts = {"clasps rows": (rows - 1.0) * rows * layers, "clasps layers": per_layer}
        found[f"topology {name}"] = record_of(name, facts={**facts, **counts, "fibre_radius": 0.4e-3})
    return found


@pytest.mark.parametrize(
    ("strands", "layers", "clearance", "verdict"),
    [
        (1.0, 16.0, 4e-4, "reproduced"),
        (2.0, 16.0, 4e-4, "differs"),
        (1.0, 15.0, 4e-4, "differs"),
        (1.0, 16.0, -1e-6, "differs"),
    ],
)
def test_a_topology_is_one_yarn_with_all_clasps(strands: float, layers: float, clearance: float, verdict: str) -> None:
    assert volumetric.topology(printed(strands, layers, clearance)).verdict == verdict


@pytest.mark.parametrize(("pile", "verdict"), [(3e5, "reproduced"), (0.9e5, "differs")])
def test_the_stiffest_direction_is_told(pile: float, verdict: str) -> None:
    slopes = {"C": 1e4, "W": 1e5, "P": pile}
    runs = {f"fig4c {axis}": record_of(axis, [cycles(axis, line(slope))]) for axis, slope in slopes.items()}
    assert volumetric.stiffest(runs).verdict == verdict


@pytest.mark.parametrize(("rate", "verdict"), [(16.5, "reproduced"), (2.0, "differs")])
def test_like_shapes_are_alike_whatever_their_size(rate: float, verdict: str) -> None:
    runs = {"fig3a": record_of("fig3a", [cycles(axis, exponential(900.0, 16.5)) for axis in "CW"])}
    strain = np.linspace(0.0, 0.3, 31)
    curves = [cycles(axis, exponential(10.0, rate * 4.0 / 3.0), strain=strain) for axis in "CW"]
    runs["volumetric"] = record_of("volumetric", curves)
    assert volumetric.equibiaxial(runs).verdict == verdict


@pytest.mark.parametrize(("slopes", "verdict"), [((1e4, 2e4, 4e4), "reproduced"), ((1e4, 4e4, 2e4), "differs")])
def test_a_pile_that_is_tuned_rises(slopes: tuple[float, ...], verdict: str) -> None:
    runs = {
        f"fig4d {pre:g}": record_of("fig4d", [cycles("P", line(slope), line(0.5 * slope))])
        for pre, slope in zip((0.0, 0.1, 0.2), slopes, strict=True)
    }
    assert volumetric.tuned_pile(runs).verdict == verdict


def rupture(micro: float, breaks: float) -> dict[str, Analysed]:
    """Return two knits whose σ/E is that of a square of strain up to 1, then falls; times `micro` of the micro one."""
    strain = np.linspace(0.0, 1.2, 121)

    def over_modulus(factor: float) -> made.Curve:
        return lambda at, _: factor * 2e-5 * np.where(at <= 1.0, at**2, 0.2)

    found = {}
    for name, factor, modulus in (("micro", micro, 3e9), ("macro", 1.0, 0.82e9)):
        curve = over_modulus(factor * modulus)
        found[f"fig5 {name}"] = record_of(name, [cycles("P", curve, strain=strain)], {"young_modulus": modulus})
    bonds: dict[str, Sequence[Cell]] = {
        "from strain": [0.3, breaks - 0.02],
        "to strain": [0.34, breaks + 0.02],
        "broken": [1, 5],
    }
    table = tables_of("micro", {"bonds": bonds}).tables
    one = found["fig5 micro"]
    found["fig5 micro"] = Analysed(name="fig5 micro", curves=one.curves, facts=one.facts, tables=table)
    return found


@pytest.mark.parametrize(
    ("micro", "breaks", "verdicts"),
    [
        (1.2, 1.0, ("reproduced", "reproduced", "reproduced")),
        (2.0, 0.4, ("differs", "differs", "differs")),
        (0.9, 1.0, ("reproduced", "differs", "reproduced")),
    ],
)
def test_micro_and_macro_are_compared_by_modulus(micro: float, breaks: float, verdicts: tuple[str, ...]) -> None:
    runs = rupture(micro, breaks)
    found = [one(runs) for one in (volumetric.same_response, volumetric.fused_points, volumetric.same_strength)]
    assert tuple(one.verdict for one in found) == verdicts
    assert found[1].values["peak of breaks"] == pytest.approx(breaks)
    assert found[2].values == pytest.approx({"slope": micro, "strength": micro}, rel=1e-6)


def test_no_fused_point_that_breaks_has_no_strain() -> None:
    runs = rupture(1.0, 1.0)
    none = tables_of("micro", {"bonds": {"from strain": [], "to strain": [], "broken": []}}).tables
    runs["fig5 micro"] = Analysed(name="fig5 micro", curves=runs["fig5 micro"].curves, tables=none)
    with pytest.raises(UnscorableError, match="no fused point broke"):
        volumetric.fused_points(runs)


@pytest.mark.parametrize(
    ("speed", "hooks", "verdict"), [(0.2e-3, 12, "reproduced"), (0.3e-3, 12, "differs"), (0.2e-3, 6, "differs")]
)
def test_constants_are_read_back(speed: float, hooks: int, verdict: str) -> None:
    planar_facts = {"speed C": speed, "loops": 6.0, "rows": 6.0, "pole_friction": 0.0}
    runs = {
        "fig3a": Analysed(name="fig3a", facts=planar_facts, hooks=lambda: {"C": 6, "W": hooks}),
        "fig3c RGD8530-DM": record_of("soft", facts={"young_modulus": 0.82e9}),
        "fig3c VeroUltraWhite": record_of("stiff", facts={"young_modulus": 2.0e9}),
        "fig5 micro": record_of(
            "micro", facts={"young_modulus": 3.0e9, "loop_width": 50e-6, "height": 100e-6, "speed P": 1.02e-7}
        ),
    }
    assert constants.constants(runs).verdict == verdict
