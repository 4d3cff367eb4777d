from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigs.readers.numbers import decimal_of, number


@pytest.mark.parametrize(
    ("text", "decimal", "value"),
    [
        ("12", ".", 12.0),
        ("-0.5", ".", -0.5),
        (".5", ".", 0.5),
        ("1e-3", ".", 1e-3),
        ("1.5E+02", ".", 150.0),
        ("1,234,567.8", ".", 1234567.8),
        ("1 234,5", ",", 1234.5),
        ("1\u202f234,5", ",", 1234.5),
        ("1\u00a0234", ".", 1234.0),
        ("1'234.5", ".", 1234.5),
        ("0,123", ",", 0.123),
        ("\u22122.5", ".", -2.5),
        ("655n", ".", 655e-9),
        ("-0.002p", ".", -2e-15),
        ("1.5 k", ".", 1500.0),
        ("-00:00:06.135", ".", -6.135),
        ("01:01:01.500", ".", 3661.5),
        ("00:00:02,5", ",", 2.5),
    ],
)
def test_numbers_of_many_countries(text: str, decimal: str, value: float) -> None:
    assert number(text, decimal) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "text", ["abc", "1,23.4", "1.2.3", "1,2345", "0,123", "12:99:00", "1 2", "--1", "n", "1_000", "nan"]
)
def test_what_is_no_number_with_a_point(text: str) -> None:
    assert number(text, ".") is None


def test_an_empty_field_is_not_known() -> None:
    value = number("", ".")
    assert value is not None
    assert value != value  # noqa: PLR0124 (nan)


@settings(deadline=None, max_examples=30)
@given(
    values=st.lists(st.floats(-1e6, 1e6), min_size=3),
    digits=st.integers(1, 5),
    decimal=st.sampled_from(".,"),
    grouped=st.booleans(),
)
def test_the_mark_of_decimals_is_told_from_the_numbers(
    *, values: list[float], digits: int, decimal: str, grouped: bool
) -> None:
    # One number that only this country writes so is enough.
    texts = [f"{value:{',' if grouped else ''}.{digits}f}" for value in [*values, 0.25]]
    if decimal == ",":
        texts = [text.translate({ord("."): ",", ord(","): "."}) for text in texts]
    assert decimal_of(texts, ";") == decimal
    found = [number(text, decimal) for text in texts]
    assert found == pytest.approx([*values, 0.25], abs=0.5000001 * 10.0**-digits)
