"""Whatever finite numbers and texts are logged, a plain CSV reader gets them back."""

from __future__ import annotations

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from knitlab_core.errors import SpecificationError
from rigs.logs.alemnis import PREFIXES, clock_text, prefixed
from rigs.logs.dialect import Column, Dialect
from rigs.logs.locales import LOCALES, localised
from rigs.logs.units import factor
from rigs.logs.writer import write_log
from rigs.protocol.bounds import require_label

NUMBERS = st.floats(-1e9, 1e9)


def read(data: bytes, delimiter: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(data.decode(), newline=""), delimiter=delimiter))


@given(
    value=NUMBERS,
    unit=st.sampled_from(["", "mm", "mN", "MPa", "%"]),
    digits=st.integers(0, 6),
    comma=st.booleans(),
    trimmed=st.booleans(),
    locale=st.sampled_from(sorted(LOCALES)),
)
def test_a_number_comes_back_within_the_printed_digits(
    *, value: float, unit: str, digits: int, comma: bool, trimmed: bool, locale: str
) -> None:
    form = f"{',' if comma else ''}.{digits}f"
    column = Column(name="a", channel="a", unit=unit, form=form, trimmed=trimmed)
    dialect = localised(Dialect(name="d", columns=(column, Column(name="b", channel="b"))), locale)
    rows = read(b"".join(write_log(dialect, [{"a": [value], "b": ["x"]}])), dialect.delimiter)
    assert [len(row) for row in rows] == [2, 2]
    marks = LOCALES[locale]
    shown = rows[1][0].replace(marks.thousands or "\0", "").replace(marks.decimal, ".")
    scaled = value * factor(unit)
    assert float(shown) == pytest.approx(scaled, rel=1e-12, abs=0.5000001 * 10.0**-digits)
    assert shown == "0" or not shown.startswith("-0") or any(digit in shown for digit in "123456789")


@given(
    texts=st.lists(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"))),
    delimiter=st.sampled_from([",", ";", "\t"]),
    quoted=st.booleans(),
)
def test_any_text_comes_back(*, texts: list[str], delimiter: str, quoted: bool) -> None:
    columns = (Column(name="a", channel="a", quoted=quoted), Column(name="b", channel="a"))
    dialect = Dialect(name="d", columns=columns, delimiter=delimiter)
    rows = read(b"".join(write_log(dialect, [{"a": texts}])), delimiter)
    assert rows == [["a", "b"], *([text, text] for text in texts)]


@given(st.floats(-10.0, 10.0))
def test_a_prefixed_value_comes_back_to_six_digits(value: float) -> None:
    shown = prefixed(value)
    sizes = dict(PREFIXES)
    back = float(shown[:-1]) * sizes[shown[-1]] if isinstance(shown, str) else shown
    assert back == pytest.approx(value, rel=6e-6, abs=6e-16)


@given(st.floats(-1e5, 1e5))
def test_a_time_text_comes_back_to_the_millisecond(time: float) -> None:
    shown = clock_text(time)
    hours, minutes, seconds = (float(part) for part in shown.lstrip("-").split(":"))
    back = 3600 * hours + 60 * minutes + seconds
    assert back == pytest.approx(abs(time), abs=5.00001e-4)
    assert minutes < 60
    assert seconds < 60
    assert shown.startswith("-") == (time < 0 and back > 0)


@given(st.text(st.sampled_from("a,;\"'\r\n\t=+@/\\.. "), min_size=1))
def test_a_name_that_could_break_a_file_is_refused(name: str) -> None:
    try:
        require_label("name", name)
    except SpecificationError:
        return
    assert set(name) <= {"a", ".", " "}
    assert name[0] == "a"
