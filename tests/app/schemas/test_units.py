from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.schemas.units import COMMON, Dimension, parse, registry, write
from knitlab_core.errors import UnitError


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("8 mm", "length", 8e-3),
        ("8mm", "length", 8e-3),
        ("50 µm", "length", 50e-6),
        ("50 um", "length", 50e-6),
        ("0.2 mm/s", "speed", 2e-4),
        ("12 mm/min", "speed", 2e-4),
        ("50 mN", "force", 0.05),
        ("1 kg*m/s^2", "force", 1.0),
        ("2 min", "time", 120.0),
        ("10 Hz", "frequency", 10.0),
        ("40 %", "strain", 0.4),
        ("1 mm/m", "strain", 1e-3),
        (0.4, "strain", 0.4),
        (0, "strain", 0.0),
    ],
)
def test_quantities_become_si(text: object, dimension: Dimension, value: float) -> None:
    assert parse(text, dimension) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("unit", "dimension"), [(unit, dimension) for dimension, units in COMMON.items() for unit in units]
)
def test_a_common_unit_is_to_the_last_bit_what_pint_makes_of_it(unit: str, dimension: Dimension) -> None:
    for number in (1.0, 0.1, 3.0, 8.0, 12.5, 0.0123, 99.99, 1234567.0, 4.4e-7, 40.0, 44.0, 0.7):
        by_pint = registry().Quantity(number, registry().parse_units(f"1{unit}" if unit[0] == "/" else unit))
        si = {"strain": "dimensionless", "memory": "byte"}.get(dimension) or by_pint.to_base_units().units
        si = {"stress": "Pa", "force": "N", "frequency": "Hz", "force rate": "N/s"}.get(dimension) or si
        assert parse(f"{number!r} {unit}", dimension) == by_pint.to(si).magnitude


@pytest.mark.parametrize(
    ("text", "dimension"),
    [
        (8, "length"),
        ("8", "length"),
        ("8 s", "length"),
        ("mm", "length"),
        ("8 parsnips", "length"),
        ("8 mm mm", "length"),
        ("inf mm", "length"),
        ("1e400 m", "length"),
        ("9**9**9 mm", "length"),
        ("8 m**9**9", "length"),
        ("(8) mm", "length"),
        ("8 mm" + " " * 200, "length"),
        ("20 degC", "length"),
        ("600 rpm", "frequency"),
        ("10 deg", "strain"),
        ("0.4", "strain"),
        (True, "strain"),
        (float("nan"), "strain"),
        (None, "strain"),
    ],
)
def test_anything_else_is_refused(text: object, dimension: Dimension) -> None:
    with pytest.raises(UnitError, match=r"^rate: found .*, allowed a "):
        parse(text, dimension, "rate")


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(["length", "speed", "time", "force"]))
def test_what_is_written_reads_back_to_the_last_bit(value: float, dimension: Dimension) -> None:
    if abs(value) < 1e300:
        assert parse(write(value, dimension), dimension) == value


def test_there_is_one_registry() -> None:
    assert registry() is registry()


@pytest.mark.parametrize("text", ["-0 mm", "0 mm"])
def test_zero_has_one_sign_whoever_asked_first(text: str) -> None:
    parse("-0.0 mm", "length")
    assert math.copysign(1.0, parse(text, "length")) == 1.0
