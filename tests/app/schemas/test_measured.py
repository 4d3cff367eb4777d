from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas.errors import ProtocolError
from app.schemas.measured import load_mapping, mapping_beside
from rigs.readers.mapping import FileMapping

if TYPE_CHECKING:
    from pathlib import Path

WHOLE = """schema: knitlab/measured@1
axis: W
gauge_length: 4.5 cm
width: 40 mm
thickness: 0.5 mm
delimiter: semicolon
decimal: comma
columns:
  Fz: {is: force, unit: kN}
  3: {is: travel, unit: mm, axis: C}
"""


def test_a_mapping_says_what_a_file_does_not(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text(WHOLE, encoding="utf-8")
    found = load_mapping(path)
    assert (found.axis, found.delimiter, found.decimal) == ("W", ";", ",")
    assert (found.gauge_length, found.width, found.thickness) == pytest.approx((0.045, 0.04, 0.5e-3))
    assert (found.headings["Fz"].quantity, found.headings["Fz"].unit) == ("force", "kN")
    assert found.headings["3"].axis == "C"
    path.write_text("schema: knitlab/measured@1\n", encoding="utf-8")
    assert np.isnan(load_mapping(path).gauge_length)
    assert load_mapping(path).thickness == 1e-3


FAULTS = [
    ("columns: {}\n", "1:1: schema: found nothing, allowed knitlab/measured@1"),
    ("schema: knitlab/measured@1\nwidht: 3 mm\n", "2:1: widht: found an unknown field, allowed"),
    ("schema: knitlab/measured@1\nwidth: 3\n", "2:8: width: found 3, allowed a length with its unit"),
    ("schema: knitlab/measured@1\nwidth: 0 mm\n", "2:8: width: found 0 m, allowed a length above 0 m"),
    ("schema: knitlab/measured@1\ndecimal: dot\n", "2:10: decimal: found 'dot', allowed comma or point"),
    (
        "schema: knitlab/measured@1\ncolumns:\n  a: {is: load}\n",
        "3:11: columns.a.is: found 'load', allowed one of time, travel",
    ),
    (
        "schema: knitlab/measured@1\ncolumns:\n  a: {is: force, unit: mm}\n",
        "3:24: columns.a.unit: found 'mm', allowed a unit of force",
    ),
]


@pytest.mark.parametrize(("text", "expected"), FAULTS)
def test_mistakes_are_one_line_with_their_place(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "m.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ProtocolError, match=re.escape(f"{path}:{expected}")):
        load_mapping(path)


def test_what_is_said_goes_before_what_stands_beside_the_file(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    assert np.isnan(mapping_beside(path).width)
    path.with_suffix(".yaml").write_text(WHOLE, encoding="utf-8")
    found = FileMapping(axis="P", width=0.02).over(mapping_beside(path))
    assert (found.axis, found.width, found.delimiter) == ("P", 0.02, ";")
    assert found.gauge_length == pytest.approx(0.045)
    assert set(found.headings) == {"Fz", "3"}
