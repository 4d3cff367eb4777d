"""What a log shows, a reader gets back to the printed digits: in every dialect and locale, and however altered."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigs.logs.alemnis import clock_text, prefixed
from rigs.logs.catalogue import LOGS
from rigs.logs.locales import LOCALES, localised
from rigs.logs.units import in_units
from rigs.logs.writer import write_log
from rigs.readers.measured import read_measured
from rigs.readers.table import read_table
from tests.rigs.logs.golden_files import golden

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigs.axes import Axis
    from rigs.logs.dialect import Column, Dialect
    from rigs.readers.table import ReadTable

FACTS = {
    "label": "22L.3",
    "started": "noon",
    "gauge length": None,
    "printed length": None,
    "zero": None,
    **dict.fromkeys(("Load", "Extension", "Strain", "Stress"), 1.5),
}
UNITS: tuple[dict[str, str], ...] = ({}, {"force": "kN"}, {"force": "mN", "length": "um"}, {"length": "m"})
CASES = sorted(golden())
AXES: tuple[Axis, ...] = ("C", "W", "WC")
NUMBERS = st.floats(-1e4, 1e4)
TEXTS = st.sampled_from(["equibiaxial", "pull, again", "22L.3", "a;b", "1 x 2"])


SPECIAL: dict[str, st.SearchStrategy[object]] = {
    "SetName": TEXTS,
    "Cycle": st.sampled_from(["1-Preload", "1-Stretch", "2-Recover", "3-Hold"]),
    "Segment": st.sampled_from([22476, 22412]),
    "Count": st.integers(0, 40),
}


def fields_of(column: Column) -> st.SearchStrategy[object]:
    """Return what a column may hold."""
    if column.channel in SPECIAL:
        return SPECIAL[column.channel]
    if column.channel.endswith(" time"):
        return st.floats(-1e4, 1e5).map(clock_text)
    return st.floats(-10.0, 10.0).map(prefixed) if column.form is None else NUMBERS


@st.composite
def logs(draw: st.DrawFn, dialect: Dialect) -> dict[str, list[object]]:
    """Draw the channels of a log of some rows."""
    rows = draw(st.integers(2, 6))
    return {
        column.channel: draw(st.lists(fields_of(column), min_size=rows, max_size=rows)) for column in dialect.columns
    }


def written_again(dialect: Dialect, table: ReadTable) -> dict[str, list[object]]:
    """Return the channels that were read, as the writer takes them."""
    found: dict[str, list[object]] = {}
    for column, read in zip(dialect.columns, table.columns, strict=True):
        assert read.heading.text == column.name.format(unit=column.unit)
        if column.channel.endswith(" time"):
            found[column.channel] = [clock_text(value) for value in read.values.tolist()]
        elif column.form is not None:
            found[column.channel] = read.values.tolist()
        elif dialect.name.startswith("alemnis"):
            found[column.channel] = [prefixed(value) for value in read.values.tolist()]
        else:
            found[column.channel] = list(read.texts)
    return found


def text(dialect: Dialect, channels: Mapping[str, list[object]]) -> bytes:
    return b"".join(write_log(dialect, [channels], FACTS))


@pytest.mark.parametrize(("name", "locale"), CASES)
@given(data=st.data())
@settings(deadline=None, max_examples=8)
def test_export_and_read_is_the_identity(
    name: str, locale: str, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    wanted = data.draw(st.sampled_from(UNITS))
    plain = LOGS[name].of_axes(AXES)
    says = any("{unit}" in f"{column.name}{column.below}" for column in plain.columns)
    dialect = localised(in_units(plain, wanted) if says else plain, locale)
    order = data.draw(st.permutations(dialect.columns)) if says else dialect.columns
    dialect = replace(dialect, columns=tuple(order))
    channels = data.draw(logs(dialect))
    path = tmp_path_factory.getbasetemp() / "log.csv"
    once = text(dialect, channels)
    path.write_bytes(altered(once, data.draw(st.sampled_from(["", "bom", "utf-16", "repeated", "lf"])), dialect))
    assert text(dialect, written_again(dialect, read_table(path))) == once


def altered(data: bytes, how: str, dialect: Dialect) -> bytes:
    """Return a log with what other programs do to it."""
    if how == "bom":
        return b"\xef\xbb\xbf" + data
    if how == "utf-16":
        return data.decode().encode("utf-16")
    if how == "lf":
        return data.replace(b"\r\n", b"\n")
    if how == "repeated":
        # The headings, and the units below them, once more before the last row.
        *body, last, end = data.split(b"\r\n")
        start = text(replace(dialect, preamble=()), {column.channel: [] for column in dialect.columns})
        return b"\r\n".join([*body, start.removesuffix(b"\r\n"), last, end])
    return data


@pytest.mark.parametrize(("name", "locale"), CASES)
@given(data=st.data())
@settings(deadline=None, max_examples=4)
def test_a_log_without_its_headings_is_told_by_its_columns(
    name: str, locale: str, data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    dialect = localised(LOGS[name].of_axes(AXES), locale)
    channels = data.draw(logs(dialect))
    whole, headings = text(dialect, channels), text(dialect, {column.channel: [] for column in dialect.columns})
    path = tmp_path_factory.getbasetemp() / "bare.csv"
    path.write_bytes(whole.removeprefix(headings))
    assert text(dialect, written_again(dialect, read_table(path))) == whole


@pytest.mark.parametrize(("name", "locale"), CASES)
def test_every_golden_file_is_a_measurement(name: str, locale: str, tmp_path: Path) -> None:
    from tests.rigs.logs.golden_files import FOLDER  # noqa: PLC0415

    path = tmp_path / "log.csv"
    path.write_bytes((FOLDER / f"{name}.{locale}").read_bytes())
    found = read_measured(path)
    axes = {"biotester": ["C", "W"], "triaxial": ["P", "C", "W"], "alemnis-tsv": ["P"], "shear-stage": [*AXES]}.get(
        name, [""]
    )
    assert [one.axis for one in found] == axes
    assert all(len(one) > 2 for one in found)
    assert set(LOCALES) >= {locale}
