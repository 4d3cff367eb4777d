from __future__ import annotations

import random
import re
from typing import TYPE_CHECKING

import numpy as np
import pytest
from openpyxl import Workbook

from knitlab_core.errors import FormatError
from rigs.readers.headings import Heading
from rigs.readers.mapping import FileMapping
from rigs.readers.measured import read_measured
from rigs.readers.source import decoded, delimiter_of
from rigs.readers.table import read_table

if TYPE_CHECKING:
    from pathlib import Path

GERMAN = """Prüfling;Nr. 7
Messlänge;45,5;mm

Prüfzeit;Standardweg;Standardkraft
s;mm;kN
0,0;0,00;0,0001
0,1;1.000,50;0,0025
Prüfzeit;Standardweg;Standardkraft
s;mm;kN
0,2;2,25;1,5
"""


def written(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "file.csv"
    path.write_text(text, encoding=encoding)
    return path


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_german_file_with_repeated_headings(tmp_path: Path, encoding: str) -> None:
    table = read_table(written(tmp_path, GERMAN, encoding))
    assert [one.heading.quantity for one in table.columns] == ["time", "travel", "force"]
    assert table.columns[1].values == pytest.approx([0.0, 1.0005, 2.25e-3])
    assert table.columns[2].values == pytest.approx([0.1, 2.5, 1500.0])
    assert table.gauge_length == pytest.approx(45.5e-3)
    assert table.lines == (6, 7, 10)
    (test,) = read_measured(tmp_path / "file.csv")
    assert test.strain == pytest.approx(test.travel / 45.5e-3)


FAULTS = [
    ("Time (s),Load (N),Extension (mm)\n0,1,2\n0.1,x1,3\n", 3, "a number in column 2 (Load (N)), found 'x1'"),
    ("Time (s),Load (N),Extension (mm)\n0,1,2\n0.1,2\n", 3, "3 columns, found 2"),
    ("Time (s),Load (N),Extension (mm)\n0,1,2,9\n", 2, "3 columns, found 4"),
    ("Time,Load,Extension\n(s),(mm),(mm)\n0,1,2\n", 2, "a unit of force in column 2 (Load), found 'mm'"),
    ("Time,Load,Extension\n0,1,2\n", 1, "the unit of column 2 (Load)"),
    ("Time (s),Extension (mm)\n0,1\n", 2, "a column of force among Time (s), Extension (mm)"),
    ("Time (s),Load (N)\n0,1\n", 2, "a column of displacement beside that of force"),
    ("Time (s),Load (N),Extension (mm)\n", 1, "rows of numbers below the headings"),
    ("1,2\n3,4\n", 1, "headings with time, displacement or force"),
    ("", 1, "a table of numbers, but the file is empty"),
    ('Time (s),Load (N)\n0,"1\n', 2, "fields between ','"),
]


@pytest.mark.parametrize(("text", "line", "expected"), FAULTS)
def test_a_mistake_is_named_by_line_and_column(tmp_path: Path, text: str, line: int, expected: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(FormatError, match=re.escape(f"{path}:{line}: expected {expected}")) as raised:
        read_measured(path)
    assert "\n" not in str(raised.value)


def test_bytes_that_are_no_text_are_refused() -> None:
    with pytest.raises(FormatError, match="log:2: expected text"):
        decoded(b"a\nb\0c", "log")
    with pytest.raises(FormatError, match="0x81"):
        decoded(b"\x81", "log")


@pytest.mark.parametrize(
    ("text", "delimiter"),
    [("a;b\n1,5;2,5\n", ";"), ("a\tb\n1,5\t2\n", "\t"), ("a;b,1-Stretch,1.5,2.5\n", ","), ("1,234;2,5;3,5\n", ";")],
)
def test_what_stands_between_fields_is_told_from_the_numbers(text: str, delimiter: str) -> None:
    assert delimiter_of(text) == delimiter


def test_columns_may_be_mapped_by_name_or_number(tmp_path: Path) -> None:
    rows = "0;0,5;9\n1;1,5;9\n2;2,5;9\n"
    wanted = FileMapping(
        headings={
            "a": Heading(text="a", quantity="travel", unit="mm"),
            "b": Heading(text="b", quantity="force", unit="mN", axis="W"),
        },
        gauge_length=0.1,
        width=0.05,
    )
    (test,) = read_measured(written(tmp_path, "a;b;c\n" + rows), wanted)
    assert test.axis == "W"
    assert test.force == pytest.approx([0.5e-3, 1.5e-3, 2.5e-3])
    assert test.strain == pytest.approx([0.0, 0.01, 0.02])
    assert test.stress == pytest.approx(test.force / (0.05 * 1e-3))
    numbered = FileMapping(headings={"1": wanted.headings["a"], "2": wanted.headings["b"]})
    (bare,) = read_measured(written(tmp_path, rows), numbered)
    assert bare.force == pytest.approx(test.force)
    with pytest.raises(FormatError, match="a column 'a', as the mapping says"):
        read_measured(written(tmp_path, "Time (s);Load (N)\n" + "0;1\n"), wanted)
    with pytest.raises(FormatError, match="columns by number, 1 to 3"):
        read_measured(written(tmp_path, rows), wanted)


def test_a_workbook_is_read_as_text_is(tmp_path: Path) -> None:
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    for row in (["Time", "Extension", "Load"], ["(s)", "(mm)", "(N)"], [0, 0, 0.5], [0.5, 1.25, "655n"]):
        sheet.append(row)
    book.save(tmp_path / "book.xlsx")
    (test,) = read_measured(tmp_path / "book.xlsx")
    assert test.travel == pytest.approx([0.0, 1.25e-3])
    assert test.force == pytest.approx([0.5, 655e-9])
    (tmp_path / "none.xlsx").write_bytes(b"PK no workbook")
    with pytest.raises(FormatError, match="a workbook that can be read"):
        read_measured(tmp_path / "none.xlsx")


def test_repeats_and_distances(tmp_path: Path) -> None:
    text = "repeat,force_N,clamp_distance_mm,width_at_middle_mm\n1,0,50,30\n1,1,55,27\n2,0,51,30\n2,2,61.2,24\n"
    first, second = read_measured(written(tmp_path, text), FileMapping(width=0.02, axis="C"))
    assert (first.name, second.name) == ("file, repeat 1", "file, repeat 2")
    assert first.strain == pytest.approx([0.0, 0.1])
    assert second.strain == pytest.approx([0.0, 0.2])
    assert second.transverse == pytest.approx([0.0, -0.2])
    assert second.stress == pytest.approx([0.0, 2.0 / 0.02 / 1e-3])
    assert np.isnan(first.time).all()
    assert first.axis == "C"


def test_the_biotester_gives_strain_stress_and_phases(tmp_path: Path) -> None:
    path = tmp_path / "stage.csv"
    path.write_text(
        "SetName,Cycle,Time_S,Temperature,XSize_um,YSize_um,XDisplacement_um,YDisplacement_um,XForce_mN,YForce_mN\n"
        "s,1-Preload,0,22,20000,40000,0,0,0,0\ns,1-Stretch,1,22,21000,40000,1000,0,100,5\n"
        "s,1-Recover,2,22,20000,40000,0,0,0,0\n",
        encoding="utf-8",
    )
    course, wale = read_measured(path)
    assert (course.axis, wale.axis) == ("C", "W")
    assert course.strain == pytest.approx([0.0, 0.05, 0.0])
    assert course.stress[1] == pytest.approx(0.1 / (40e-3 * 1e-3))
    assert wale.stress[1] == pytest.approx(5e-3 / (20e-3 * 1e-3))
    assert course.phase == ("Preload", "Stretch", "Recover")


def test_an_indenters_force_is_read_at_the_times_of_its_displacement(tmp_path: Path) -> None:
    path = tmp_path / "tip.tsv"
    head = "Time\tCorrected Displacement\tTime\tCorrected Load\tTime\tRaw Displacement\tTime\tRaw Load"
    rows = [f"00:00:0{k}.000\t{k}u\t00:00:0{k}.500\t{k}m\t00:00:0{k}.000\t0\t00:00:0{k}.500\t0" for k in range(5)]
    path.write_text("\n".join([head, *rows]), encoding="utf-8")
    (test,) = read_measured(path)
    # The load is k mN half a second late, so that it is k - 1/2 at k.
    assert test.force[1:] == pytest.approx([0.5e-3, 1.5e-3, 2.5e-3, 3.5e-3])
    assert test.travel == pytest.approx([0.0, 1e-6, 2e-6, 3e-6, 4e-6])


# In the forms of files that laboratories published; the numbers are our own.
BLUEHILL = {
    "2, with facts and an extensometer": (
        'Course,"AE 1"\nCrosshead Rate,4.00,mm/min\nStart Date,1/2/2026 10:54 AM\nHeat treatment,""\nArea,40.0,mm^2\n'
        "Gage Length (Extensometer),25.00,mm\nMaximum Load,22840,N\nTensile strain at Maximum Load,0.07,mm/mm\n\n"
        "Time,Extension,Load,Strain 1\n(sec),(mm),(N),(mm/mm)\n0.00,0.00,-4.0,-0.00001\n0.50,0.03,1152,0.0100\n"
    ),
    "3, German": (
        'Texteingaben : Proben-beschriftung;"P 6-1"\nAllgemein : Startdatum;16.08.2026 16:07:51\n'
        "Abmessung : Querschnitt;40,00000;mm^2\n\nZeit;Traversenweg;Last;Dehnung 1;Zugspannung\n"
        "(sec);(mm);(kN);(%);(MPa)\n0,00000;0,0000;-0,004;-0,001;-0,10\n0,50000;0,0300;1,152;1,00000;28,80\n"
    ),
    "Universal, Chinese": (
        "时间,位移,载荷,压缩应变 (位移),压缩应力,循环计数\n(s),(mm),(N),(%),(MPa),\n"
        "0,0,-4,-0.001,-0.1,0\n0.5,0.03,1152,1,28.8,0\n"
    ),
    "3, Polish, read as Windows-1252": (
        'W³aœciwoœci próbki : D³ugoœæ;"3,00000";mm\n\nGodzina;Przemieszczenie;Obci¹¿enie;Odkszta³cenie 1\n'
        '(s);(mm);(N);(mm/mm)\n"0,00000";"0,00000";"-4,00000";"-0,00001"\n"0,50000";"0,03000";"1152,00000";"0,01000"\n'
    ),
    "Universal, units in the headings": (
        "Time measurement (s),Primary load measurement (N),Extension (mm),Strain 1 (%)\n"
        "0,-4,0,-0.001\n0.5,1152,0.03,1\n"
    ),
    "3, gauge length of the extension": (
        'Strain : Tensile strain (Extension) gauge length,"3.00000",mm\n\nTime,Extension,Load\n(s),(mm),(N)\n'
        '"0.00000","0.00000","-4.00000"\n"0.50000","0.03000","1,152.00000"\n'
    ),
    "UStretch": (
        "SetName\tCycle\tTime_S\tSize_mm\tDisplacement_mm\tForce_N\n"
        "s\t1-Stretch\t0\t3\t0\t-4\ns\t1-Stretch\t0.5\t3.03\t0.03\t1152\n"
    ),
}


@pytest.mark.parametrize("form", BLUEHILL)
def test_files_in_the_forms_of_other_laboratories(tmp_path: Path, form: str) -> None:
    (test,) = read_measured(written(tmp_path, BLUEHILL[form]))
    assert test.time == pytest.approx([0.0, 0.5])
    assert test.travel == pytest.approx([0.0, 3e-5])
    assert test.force == pytest.approx([-4.0, 1152.0])
    assert test.strain[1] == pytest.approx(0.01)
    if form in {"2, with facts and an extensometer", "3, German", "Universal, Chinese"}:
        assert test.stress[1] == pytest.approx(28.8e6)
    else:
        assert np.isnan(test.stress).all()
    assert test.name == ("P 6-1" if form == "3, German" else "file")


def test_units_below_tell_what_unknown_words_mean(tmp_path: Path) -> None:
    (test,) = read_measured(written(tmp_path, "aika;venymä;kuorma;muuta\n(s);(mm);(kN);\n0;0;0;1\n1;2;3;4\n"))
    assert test.travel == pytest.approx([0.0, 2e-3])
    assert test.force == pytest.approx([0.0, 3e3])


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_on_any_system(tmp_path: Path, end: str) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(end.join(["Time [s],Load [N],Extension [mm]", "0,0,0", "1,0.5,1", "2,2,2", ""]).encode())
    (found,) = read_measured(path)
    assert found.force.tolist() == [0.0, 0.5, 2.0]


def test_a_damaged_file_is_read_or_refused_in_one_line(tmp_path: Path) -> None:
    chance = random.Random(5)  # noqa: S311 (not for secrets)
    lines = [f"{k},{0.2 * k * k:.4f},{0.5 * k}" for k in (*range(12), *range(11, -1, -1))]
    whole = "\n".join(["Time [s],Load [N],Extension [mm]", *lines]).encode()
    path = tmp_path / "log.csv"
    read, refusals = 0, []
    for _ in range(300):
        content = bytearray(whole)
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(content))
            content[at : at + chance.choice([0, 1, 8])] = chance.choice(
                [b"\r", b'"', b"nan", b"1e308", b"\x00", b"\xff", b";", b"\n", b"-", bytes(content[at : at + 60])]
            )
        path.write_bytes(content)
        try:
            read += bool(read_measured(path))
        except FormatError as error:
            refusals.append(str(error))
    assert read > 0
    assert read + len(refusals) == 300
    assert not any("\n" in said for said in refusals)


def test_a_column_of_too_many_repeats_is_none(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("repeat,Time [s],Load [N],Extension [mm]\n" + "".join(f"{k},0,0,0\n" for k in range(1001)))
    with pytest.raises(FormatError, match=r"log.csv:2: expected at most 1000 repeats in a column of them, not 1001"):
        read_measured(path)
