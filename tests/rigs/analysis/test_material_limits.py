"""Say where a fibre passes a limit of its material, and keep it in the record."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import pytest

from app.records.reader import RunReader
from app.records.writer import RunWriter
from knitlab_core.materials import MATERIALS, Material, RelaxationTerm, Value
from rigs.analysis.material_limits import MaterialLimit, crossings, limits_of
from rigs.protocol.specimen import SpecimenSpec
from tests.synthetic_run import SIZE, make_run, rows

if TYPE_CHECKING:
    from pathlib import Path


def value(number: float, unit: str) -> Value:
    return Value(value=number, unit=unit, source="a test")


PLA = Material(
    name="pla",
    young_modulus=value(2.6e9, "Pa"),
    poisson_ratio=value(0.36, "1"),
    strength=value(55e6, "Pa"),
    elongation_at_break=value(0.04, "1"),
    relaxation=(RelaxationTerm(share=value(0.2, "1"), time=value(2.0, "s")),),
)
STRENGTH = MaterialLimit(name="strength", strain=0.0125, text="strength of 12.5 MPa")
ELONGATION = MaterialLimit(name="elongation at break", strain=0.03, text="elongation at break of 3 %")


def spec(
    material: Material, *, rupture: Literal["off", "stop", "go on"] = "off", viscoelastic: bool = False
) -> SpecimenSpec:
    return SpecimenSpec(
        knit="stockinette-default",
        rows=2,
        loops=2,
        loop_width=8e-3,
        material=material,
        rupture=rupture,
        viscoelastic=viscoelastic,
    )


def test_strength_and_elongation_are_limits_the_lower_strain_first() -> None:
    strength, elongation = limits_of(spec(PLA))
    assert (strength.name, elongation.name) == ("strength", "elongation at break")
    assert strength.strain == pytest.approx(55e6 / 2.6e9)
    assert elongation.strain == 0.04
    assert (strength.text, elongation.text) == ("strength of 55 MPa", "elongation at break of 4 %")
    brittle = replace(MATERIALS["RGD8530-DM"], elongation_at_break=None)
    assert [limit.text for limit in limits_of(spec(brittle))] == ["strength of 29 MPa (assumed)"]
    assert limits_of(spec(replace(MATERIALS["IP-Dip"], elongation_at_break=None))) == ()


def test_a_limit_that_the_model_keeps_to_is_none() -> None:
    # A fibre that breaks at 4 % is not strained beyond, but its stress passes the strength before.
    assert [limit.name for limit in limits_of(spec(PLA, rupture="stop"))] == ["strength"]
    assert limits_of(spec(replace(MATERIALS["RGD8530-DM"], elongation_at_break=None), rupture="go on")) == ()
    # The stress of a fibre that relaxes is less than Young's modulus times strain.
    assert [limit.name for limit in limits_of(spec(PLA, viscoelastic=True))] == ["elongation at break"]
    # That of one that yields follows its curve.
    resin = MATERIALS["RGD8530-DM"]
    assert [limit.name for limit in limits_of(replace(spec(resin), yields=True))] == ["elongation at break"]
    assert [limit.name for limit in limits_of(spec(replace(PLA, elongation_at_break=None), viscoelastic=True))] == [
        "strength"
    ]


def test_the_record_names_the_first_row_beyond_each_limit(tmp_path: Path) -> None:
    # The made-up fibre is strained by 0.3 strain², of rows 2 % apart: 1.25 % is not passed at 20 % but at 22 %.
    run = make_run(tmp_path / "run.h5", limits=[STRENGTH, ELONGATION])
    assert [(one.limit, one.row) for one in run.crossings] == [(STRENGTH, 11), (ELONGATION, 16)]
    first = run.crossings[0]
    assert first.time == rows()[11].time
    assert first.fibre_strain == pytest.approx(0.3 * 0.22**2)
    assert first.strain == {"C": pytest.approx(0.22), "W": pytest.approx(0.22)}
    assert crossings(run.trace, SIZE, [STRENGTH, ELONGATION]) == run.crossings
    assert str(first) == (
        "strength of 12.5 MPa passed at 49.5 s, strain C 22.0 %, W 22.0 %: a fibre is strained by 1.45 %, "
        "limit 1.25 %; from there on the elastic fibre carries more than the material does"
    )
    assert first.data()["row"] == 11


def test_a_limit_that_is_not_passed_is_not_named(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run.h5", rows()[:11], limits=[STRENGTH, ELONGATION])
    assert run.crossings == ()


def test_a_run_that_goes_on_finds_its_crossing_again(tmp_path: Path) -> None:
    path, made = tmp_path / "run.h5", rows()
    make_run(path, made[:10], limits=[STRENGTH, ELONGATION], sampled=False)
    with RunWriter(path) as writer:
        kept = writer.lengths()
        for row in made[10:14]:
            writer.append(row)
    assert [one.row for one in RunReader(path).crossings] == [11]
    with RunWriter(path, kept) as writer:
        assert writer.lengths()["equilibria/time"] == 10
    assert RunReader(path).crossings == ()
    with RunWriter(path, kept) as writer:
        for row in made[10:20]:
            writer.append(row)
    assert [(one.row, one.time) for one in RunReader(path).crossings] == [(11, made[11].time), (16, made[16].time)]


def test_the_crossings_are_no_columns_that_grow(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run.h5", limits=[STRENGTH])
    with RunWriter(run.path) as writer:
        assert not [name for name in writer.lengths() if name.startswith("limits")]
