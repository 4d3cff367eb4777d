"""Yarn by measurement: numbers that no yarn can have, its section, and contact of models made of it."""

from __future__ import annotations

import re

import numpy as np
import pytest

from knitlab_core.contact.stiffness import contact_hessian
from knitlab_core.equilibrium.pattern import make_pattern, multiply
from knitlab_core.equilibrium.strands import NARROW_SPACING
from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.rods.section import measured_section
from tests.contact_scenes import straight, touch
from tests.measured_yarns import ACRYLIC, measured_yarn, yarn_model


@pytest.mark.parametrize(
    ("changed", "field", "says"),
    [
        ({"bending": 0.0}, "yarn.bending", "above 0"),
        ({"axial": -1.0}, "yarn.axial", "above 0"),
        ({"radius": float("inf")}, "yarn.radius", "above 0"),
        ({"core": 0.74e-3}, "yarn.core", "0.666 mm or less"),
        ({"core": 0.7e-3}, "yarn.core", "0.666 mm or less"),
        ({"exponent": 1.9}, "yarn.compression.exponent", "from 2 to 6"),
        ({"rigidity": float("nan")}, "yarn.compression.rigidity", "above 0"),
        ({"friction": -0.1}, "yarn.friction", "from 0 to 2"),
        ({"friction": 2.1}, "yarn.friction", "from 0 to 2"),
        # A thin tube of the yarn's radius: EI = GJ = EA radius^2 / 2 = 27.38 N mm^2.
        ({"bending": 27.4e-6}, "yarn.bending", "27.38 N mm^2 or less"),
        ({"twisting": 27.4e-6}, "yarn.twisting", "27.38 N mm^2 or less"),
        ({"axial": 0.1}, "yarn.bending", "0.02738 N mm^2 or less"),
    ],
)
def test_numbers_of_no_yarn_are_refused(changed: dict[str, float], field: str, says: str) -> None:
    with pytest.raises(SpecificationError, match=re.escape(says)) as raised:
        measured_yarn(**changed)
    assert raised.value.field == field


def test_bounds_of_the_section_are_those_of_a_thin_tube() -> None:
    most = 0.5 * ACRYLIC["axial"] * ACRYLIC["radius"] ** 2
    assert measured_yarn(bending=most, twisting=most).bending.value == most


def test_a_solid_rod_s_own_stiffnesses_make_the_solid_section() -> None:
    modulus, radius = 2e9, 0.4e-3
    area, inertia = np.pi * radius**2, np.pi * radius**4 / 4.0
    yarn = measured_yarn(
        axial=modulus * area, bending=modulus * inertia, twisting=modulus * inertia, radius=radius, core=0.1e-3
    )
    assert yarn.reference_modulus == pytest.approx(modulus, rel=1e-12)
    section = measured_section(yarn)
    assert (section.area, section.bend, section.twist) == pytest.approx((1.0, 1.0, 1.0), rel=1e-12)


def test_the_stiffness_of_contact_is_the_slope_of_its_force() -> None:
    rng = np.random.default_rng(1)
    strands = [straight((0, 0, 1.3 * k), (np.cos(k), np.sin(k), 0), 8.0) for k in range(3)]
    strands = [x + rng.normal(0.0, 0.02, x.shape) for x in strands]
    model, state = yarn_model(strands, measured_yarn())
    scene, q, v = touch(model, state), state.q.copy(), rng.normal(0.0, 1.0, state.q.shape)
    assert len(scene.candidates.a) > 100
    pattern = make_pattern(len(q), scene.candidates)
    blocks, product = np.zeros((len(pattern.rows), 4, 4)), np.zeros_like(q)
    contact_hessian(scene.placed(q).points, scene.candidates, model.samples, model.law, 1.0, pattern, blocks)
    multiply(pattern, blocks, v, product)
    step = 1e-6
    expected = (scene.gradient(q + step * v) - scene.gradient(q - step * v)) / (2.0 * step)
    # psi'' begins as p^0.4 where two yarns begin to touch, so that a difference is not of second order.
    assert product == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
    slope = (scene.energy(q + step * v) - scene.energy(q - step * v)) / (2.0 * step)
    assert slope == pytest.approx(float((scene.gradient(q) * v).sum()), rel=1e-7)


@pytest.mark.parametrize("changed", [{"core": 0.6e-3}, {"exponent": 6.0}])
def test_a_thin_shell_and_a_steep_force_have_samples_nearer_to_each_other(changed: dict[str, float]) -> None:
    strands = [straight((0, 0, 0), (1, 0, 0), 8.0)]
    soft, narrow = (yarn_model(strands, measured_yarn(**one))[0] for one in ({}, changed))
    assert len(narrow.samples.weights) == 2 * len(soft.samples.weights) == round(2.0 / NARROW_SPACING)


def test_a_mesh_that_reaches_half_way_to_the_core_is_refused() -> None:
    strands = [straight((0, 0, 0), (1, 0, 0), 8.0), straight((0, 0, 1.85), (0, 1, 0), 8.0)]
    assert yarn_model(strands, measured_yarn(), printed=True)[0].law.distance == pytest.approx(1.85, abs=0.02)
    with pytest.raises(GeometryError, match=r"at most 0\.1 contact radii"):
        yarn_model(strands, measured_yarn(core=0.9 * 0.74e-3), printed=True)
