"""Labels of a specimen's yarn, of its options beyond elastic rods, and of tests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from knitlab_core.materials import DEFAULT_FRICTION, Value

if TYPE_CHECKING:
    from knitlab_core.knits import Yarn
    from knitlab_core.materials import MeasuredYarn
    from rigs.protocol.protocol import Protocol
    from rigs.protocol.specimen import SpecimenSpec

ELASTIC: Final = "nothing: linearly elastic rods, contact and friction"

MOST_LETTERS: Final = 32
"""Letters of the name of a test in a legend or the head of a table."""


def yarn_label(spec: SpecimenSpec) -> str:
    """Return the label of the yarn: its fibres."""
    if spec.measured is not None:
        return _measured_label(spec.measured)
    yarn: Yarn | None = spec.yarn
    if yarn is None:
        return "one fibre"
    count = "one fibre" if yarn.fibres == 1 else f"{yarn.fibres} fibres"
    size = f"radius {_mm(yarn.fibre_radius, spec)}, wound at {_mm(yarn.winding_radius, spec)}"
    seen = "each a rod of its own" if yarn.model == "bundle" else f"as one rod, bonding {yarn.bonding:g}"
    return f"{count} of {size}, twist {yarn.twist:g} rad per loop width, {seen}"


def _measured_label(yarn: MeasuredYarn) -> str:
    """Return the label of a yarn by measurement: its numbers, those that are assumed marked."""

    def told(value: Value, factor: float, unit: str) -> str:
        return f"{factor * value.value:.4g} {unit}{_assumed(value)}"

    return (
        f"by measurement: EI {told(yarn.bending, 1e6, 'N mm²')}, EA {told(yarn.axial, 1.0, 'N')}, GJ "
        f"{told(yarn.twisting, 1e6, 'N mm²')}, radius {told(yarn.radius, 1e3, 'mm')}, core "
        f"{told(yarn.core, 1e3, 'mm')}, pressed halfway by {told(yarn.rigidity, 1e-3, 'N/mm')}, exponent "
        f"{yarn.exponent.value:.4g}{_assumed(yarn.exponent)} ({yarn.exponent.source})"
    )


def grips_label(protocol: Protocol) -> str:
    """Return the label of what holds the edges: one word, or one for each axis."""
    grips = protocol.grips
    return grips if isinstance(grips, str) else ", ".join(f"{axis} {grip}" for axis, grip in grips.items())


def material_label(spec: SpecimenSpec) -> str:
    """Return the label of the material: its elastic constants, or that the yarn itself was measured."""
    if spec.measured is not None:
        return f"{spec.measured.name}: a yarn by measurement, without a Young's modulus"
    material = spec.solid
    return f"{material.name}: E = {material.young_modulus}, Poisson's ratio {material.poisson_ratio}"


def friction_value(spec: SpecimenSpec) -> Value:
    """Return the coefficient of friction of the yarn with its source."""
    measured = None if spec.measured is None else spec.measured.friction
    for known in (measured, DEFAULT_FRICTION):
        if known is not None and spec.friction == known.value:
            return known
    return Value(value=spec.friction, unit="1", source="the protocol")


def beyond_elastic(spec: SpecimenSpec) -> dict[str, str]:
    """Return the options that go beyond elastic rods, and what each is set to; those that are off are left out."""
    found = {}
    if spec.rest_shape != "as-printed":
        found["rest shape"] = f"{spec.rest_shape}: the yarn is bent into the knit before the test"
    if spec.viscoelastic:
        material = spec.solid
        lost = sum(term.share.value for term in material.relaxation)
        times = ", ".join(f"{term.time.value:g} s" for term in material.relaxation)
        assumed = _assumed(*(value for term in material.relaxation for value in (term.share, term.time)))
        found["viscoelastic"] = f"on: {lost:.3g} of the stiffness relaxes, in {times}{assumed}; contacts stay elastic"
    if spec.yields:
        material = spec.solid
        first = material.yield_curve[0]
        assumed = _assumed(*(value for point in material.yield_curve for value in (point.strain, point.stress)))
        found["yield"] = f"on: from a strain of {first.strain.value:.3g}{assumed}; contacts stay elastic"
    if spec.fused is not None:
        law = spec.fused
        shear = "" if law.shear_strength is None else f", in shear {1e-6 * law.shear_strength:.4g} MPa"
        found["fused points"] = (
            f"on: where printed nearer than {1e3 * law.fuse_gap:.4g} mm, necks of radius {1e3 * law.patch_radius:.4g} "
            f"mm, strength {1e-6 * law.strength:.4g} MPa{shear} (assumed)"
        )
    limit = None if spec.rupture == "off" else spec.solid.breaking_strain
    if limit is not None:
        found["rupture"] = f"{spec.rupture}: a fibre breaks at a strain of {limit.value:.4g}{_assumed(limit)}"
    return found


def _mm(loop_widths: float, spec: SpecimenSpec) -> str:
    return f"{1e3 * loop_widths * spec.loop_width:.4g} mm"


def _assumed(*values: Value) -> str:
    return " (assumed)" if any(value.assumed for value in values) else ""


def shortened(name: str) -> str:
    """Return a name in at most `MOST_LETTERS` letters: what is left out stands in its middle as an ellipsis.

    Examples
    --------
    >>> shortened("course.csv"), shortened("a sample with a name that nobody types_RawData_1.csv")
    ('course.csv', 'a sample with a…es_RawData_1.csv')
    """
    half = MOST_LETTERS // 2
    return name if len(name) <= MOST_LETTERS else f"{name[: half - 1]}…{name[-half:]}"
