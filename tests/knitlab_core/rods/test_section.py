from dataclasses import replace
from math import pi, sin

import numpy as np
import pytest

from knitlab_core.knits.fibres import Yarn, same_area
from knitlab_core.rods.rod import make_rods
from knitlab_core.rods.section import SOLID, Section, with_section, yarn_section

# EI of a glued yarn of n touching fibres over that of the single fibre of equal area, from the design notes.
GLUED = {2: 1.5, 3: 1.22, 4: 1.25, 6: 1.50, 8: 1.83}


def bend(yarn: Yarn) -> float:
    """Return EI of a yarn with E = 1."""
    return pi / 4.0 * yarn.contact_radius**4 * yarn_section(yarn).bend


def twist(yarn: Yarn) -> float:
    """Return GJ of a yarn with G = 1."""
    return pi / 2.0 * yarn.contact_radius**4 * yarn_section(yarn).twist


@pytest.mark.parametrize(("fibres", "ratio"), GLUED.items())
def test_steiner_gives_the_design_s_ratios(fibres: int, ratio: float) -> None:
    yarn = replace(same_area(0.05, fibres, gap=1e-9), bonding=1.0)
    assert bend(yarn) / (pi / 4.0 * 0.05**4) == pytest.approx(ratio, abs=5e-3)


@pytest.mark.parametrize("fibres", [3, 4, 6, 8])
def test_glued_is_the_sum_over_discs_about_any_axis(fibres: int) -> None:
    yarn = replace(same_area(0.05, fibres), bonding=1.0, phase=0.3)
    r = yarn.fibre_radius
    moment = sum(pi * r**4 / 4.0 + pi * r**2 * (yarn.winding_radius * sin(angle)) ** 2 for angle in yarn.phases)
    assert bend(yarn) == pytest.approx(moment)


@pytest.mark.parametrize("fibres", [2, 3, 7])
def test_loose_is_the_fibres_own(fibres: int) -> None:
    yarn = same_area(0.05, fibres)
    assert bend(yarn) == pytest.approx(fibres * pi / 4.0 * yarn.fibre_radius**4)
    assert twist(yarn) == pytest.approx(fibres * pi / 2.0 * yarn.fibre_radius**4)
    # Of equal area: one n-th of the single fibre's.
    assert bend(yarn) == pytest.approx(pi / 4.0 * 0.05**4 / fibres)


def test_bonding_goes_from_loose_to_glued_in_a_straight_line() -> None:
    yarn = same_area(0.05, 3)
    loose, half, glued = (bend(replace(yarn, bonding=b)) for b in (0.0, 0.5, 1.0))
    assert half == pytest.approx(0.5 * (loose + glued))


@pytest.mark.parametrize("bonding", [0.0, 0.4, 1.0])
def test_the_area_is_that_of_all_fibres_however_they_are_bonded(bonding: float) -> None:
    yarn = replace(same_area(0.05, 4), bonding=bonding)
    assert yarn_section(yarn).area * yarn.contact_radius**2 == pytest.approx(0.05**2)


@pytest.mark.parametrize("bonding", [0.0, 1.0])
def test_one_fibre_is_solid_to_the_last_bit(bonding: float) -> None:
    assert yarn_section(Yarn(fibre_radius=0.05, bonding=bonding)) == SOLID


def test_a_section_multiplies_the_stiffness_and_solid_changes_no_bit() -> None:
    turn = np.linspace(0.0, 1.0, 7)
    rods, _ = make_rods(10.0 * np.column_stack([np.cos(turn), np.sin(turn), turn]), (7,), poisson_ratio=0.37)
    for one, other in zip(rods, with_section(rods, SOLID), strict=True):
        np.testing.assert_array_equal(one, other)
    yarn = with_section(rods, Section(area=0.5, bend=0.25, twist=0.125))
    np.testing.assert_array_equal(yarn.stretch_stiffness, 0.5 * rods.stretch_stiffness)
    np.testing.assert_array_equal(yarn.bend_stiffness, 0.25 * rods.bend_stiffness)
    np.testing.assert_array_equal(yarn.twist_stiffness, 0.125 * rods.twist_stiffness)
    np.testing.assert_array_equal(yarn.rest_curvature, rods.rest_curvature)
