"""The table of materials and how it is asked."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.materials import (
    DEFAULT_FRICTION,
    MATERIALS,
    CurvePoint,
    Material,
    RelaxationTerm,
    Value,
    material_named,
)


def pure(value: float) -> Value:
    return Value(value=value, unit="1", source="test")


def pascal(value: float) -> Value:
    return Value(value=value, unit="Pa", source="test")


def term(share: float, time: float) -> RelaxationTerm:
    return RelaxationTerm(share=pure(share), time=Value(value=time, unit="s", source="test"))


@pytest.mark.parametrize(
    ("name", "modulus"),
    [("RGD8530-DM", 0.82e9), ("VeroUltraWhite", 2.0e9), ("IP-Dip", 3.0e9)],
)
def test_moduli_are_the_papers(name: str, modulus: float) -> None:
    entry = material_named(name).young_modulus
    assert (entry.value, entry.unit, entry.assumed) == (modulus, "Pa", False)
    assert "the paper" in entry.source


@pytest.mark.parametrize("material", MATERIALS.values(), ids=MATERIALS)
def test_every_number_has_a_source_and_poisson_ratios_own_up(material: Material) -> None:
    for entry in (
        material.young_modulus,
        material.poisson_ratio,
        material.strength,
        material.elongation_at_break,
        material.density,
    ):
        assert entry is None or entry.source
    assert material.poisson_ratio.assumed
    assert material.note


def test_what_breaks_at_which_strain() -> None:
    strains = {name: material.breaking_strain for name, material in MATERIALS.items()}
    assert {name: strain.value for name, strain in strains.items() if strain is not None} == {
        "RGD8530-DM": 0.15,
        "VeroUltraWhite": 0.15,
        "IP-Dip": 0.10,
        "cotton-2-ply": 0.10,
    }
    assert all(strain is not None and strain.assumed for strain in strains.values())
    brittle = replace(MATERIALS["RGD8530-DM"], elongation_at_break=None).breaking_strain
    assert brittle is not None
    assert brittle.value == pytest.approx(29e6 / 0.82e9)
    assert brittle.assumed
    assert "brittle linear solid" in brittle.source
    assert "29-38 MPa" in brittle.source


def test_no_printed_resin_pretends_to_have_a_measured_relaxation_or_yield() -> None:
    for material in MATERIALS.values():
        numbers = [value for term in material.relaxation for value in (term.share, term.time)]
        numbers += [value for point in material.yield_curve for value in (point.strain, point.stress)]
        assert all(number.assumed and number.source for number in numbers)
        assert material.name == "cotton-2-ply" or (material.relaxation and material.yield_curve)


def test_elements_in_parallel_follow_the_yield_curve() -> None:
    for material in MATERIALS.values():
        modulus = material.young_modulus.value
        for point in material.yield_curve:
            strain = point.strain.value
            elastic = 1.0 - sum(element.share for element in material.yield_elements)
            carried = elastic * strain + sum(
                element.share * min(strain, element.strain) for element in material.yield_elements
            )
            assert modulus * carried == pytest.approx(point.stress.value)


def curve(*points: tuple[float, float]) -> tuple[CurvePoint, ...]:
    return tuple(CurvePoint(strain=pure(strain), stress=pascal(stress)) for strain, stress in points)


@pytest.mark.parametrize(
    ("points", "says"),
    [
        (
            [(0.01, 0.02)],
            "material.yield_curve[0].stress: found '0.02 Pa', allowed 0.026 Pa, Young's modulus times its str",
        ),
        ([(0.01, 0.026), (0.01, 0.03)], "material.yield_curve[1].strain: found 0.01, allowed above 0.01: strains rise"),
        ([(0.01, 0.026), (0.02, 0.02)], "material.yield_curve[1].stress: found '0.02 Pa', allowed 0.026 Pa or more"),
        (
            [(0.01, 0.026), (0.02, 0.03), (0.03, 0.04)],
            "material.yield_curve[2].stress: found '0.04 Pa', allowed 0.034 Pa or less: the curve may not bend upwards",
        ),
        ([(-0.01, 0.026)], "material.yield_curve[0].strain: found -0.01, allowed a number above 0"),
    ],
)
def test_a_curve_that_no_yielding_material_has(points: list[tuple[float, float]], says: str) -> None:
    with pytest.raises(SpecificationError) as raised:
        Material(name="x", young_modulus=pascal(2.6), poisson_ratio=pure(0.3), yield_curve=curve(*points))
    assert str(raised.value).startswith(says)


def test_friction_is_labelled_assumed_wherever_it_shows() -> None:
    assert str(DEFAULT_FRICTION) == "0.3 (assumed)"


@pytest.mark.parametrize("typed", ["RGD8530", "rgd8530-dm", "RGD8530-DN"])
def test_unknown_name_suggests_the_nearest_and_lists_all(typed: str) -> None:
    with pytest.raises(SpecificationError) as caught:
        material_named(typed)
    assert "did you mean RGD8530-DM?" in str(caught.value)
    assert all(name in str(caught.value) for name in MATERIALS)


def test_far_name_gets_no_suggestion() -> None:
    with pytest.raises(SpecificationError) as caught:
        material_named("unobtainium", field="yarn.material")
    assert "did you mean" not in str(caught.value)
    assert caught.value.field == "yarn.material"


@pytest.mark.parametrize(
    ("field", "numbers"),
    [
        ("material.young_modulus", {"young_modulus": pascal(0.0)}),
        ("material.young_modulus", {"young_modulus": pascal(float("nan"))}),
        ("material.strength", {"strength": pascal(-1.0)}),
        ("material.density", {"density": pascal(float("inf"))}),
        ("material.elongation_at_break", {"elongation_at_break": pure(0.0)}),
        ("material.relaxation[1].share", {"relaxation": (term(0.1, 1.0), term(-0.1, 1.0))}),
        ("material.relaxation[0].time", {"relaxation": (term(0.1, 0.0),)}),
        ("material.relaxation", {"relaxation": (term(0.5, 1.0), term(0.5, 2.0))}),
        ("material.poisson_ratio", {"poisson_ratio": pure(0.6)}),
        ("material.poisson_ratio", {"poisson_ratio": pure(-1.0)}),
    ],
)
def test_impossible_numbers_are_refused(field: str, numbers: dict[str, object]) -> None:
    sound = Material(name="test", young_modulus=pascal(1e9), poisson_ratio=pure(0.3))
    with pytest.raises(SpecificationError) as caught:
        replace(sound, **cast("dict[str, Any]", numbers))
    assert caught.value.field == field
