from __future__ import annotations

import csv
import io
import tracemalloc
from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np
import pytest
from openpyxl import load_workbook

from knitlab_core.errors import SpecificationError
from rigs.instruments.signals import stamps
from rigs.instruments.zeros import Zeroing
from rigs.logs.alemnis import clock_text, prefixed
from rigs.logs.biotester import cycle_text
from rigs.logs.catalogue import LOGS, defaults
from rigs.logs.dialect import Column, Dialect, Fact
from rigs.logs.locales import LOCALES, localised
from rigs.logs.logged import axis_of
from rigs.logs.sheet import write_sheet
from rigs.logs.units import in_units
from rigs.logs.writer import write_log
from tests.rigs.logs.golden_files import FOLDER, golden, written
from tests.rigs.logs.hand_made import frame, indenter, logged, stage

if TYPE_CHECKING:
    from rigs.axes import FloatArray
    from rigs.instruments.samples import Samples
    from rigs.logs.logged import Logged
    from rigs.record import Phase


def text(name: str, test: Logged, locale: str = "en", **units: str) -> bytes:
    log = LOGS[name]
    dialect = localised(in_units(log.shown(test), units), locale)
    return b"".join(write_log(dialect, *log.gather(test)))


@pytest.mark.parametrize(("dialect", "locale"), list(golden()))
def test_golden_file(dialect: str, locale: str) -> None:
    assert written(dialect, locale) == (FOLDER / f"{dialect}.{locale}").read_bytes()


# Worked out by hand, or given by the description of the dialect.
FIRST_LINES = {
    "biotester": (
        b"SetName,Cycle,Time_S,Temperature,XSize_um,YSize_um,XDisplacement_um,YDisplacement_um,XForce_mN,YForce_mN\r\n"
        b"22L.3,1-Preload,0.000,22.0,45000,40000,0,0,0.00,0.00\r\n"
        b"equibiaxial,1-Stretch,0.100,22.0,45010,40009,10,9,1.50,-2.25\r\n"
        b"equibiaxial,1-Hold,0.200,22.0,45020,40018,20,18,3000.00,12.35\r\n"
        b'"pull, again",2-Recover,0.300,22.0,45010,40009,10,9,1.00,0.00\r\n'
    ),
    # 45 mm by 40 mm and 1 mm: a shear of 6 mm is -0.15 of the wale, and 22.5 mN on 45 mm a stress of 0.5 kPa.
    "shear-stage": (
        b"Time,Displacement C,Force C,Strain C,Stress C,Displacement W,Force W,Strain W,Stress W,"
        b"Displacement WC,Force WC,Shear strain WC,Shear stress WC\r\n"
        b"(s),(mm),(N),(1),(kPa),(mm),(N),(1),(kPa),(mm),(N),(1),(kPa)\r\n"
        b"0.000,0.000,0.0000,0.000000,0.00000,0.000,0.0000,0.000000,0.00000,0.000,0.0000,0.000000,0.00000\r\n"
        b"24.000,9.000,0.0040,0.200000,0.10000,8.000,0.0000,0.200000,0.00000,0.000,0.0000,0.000000,0.00000\r\n"
        b"31.250,9.000,0.0055,0.200000,0.13750,8.000,0.0450,0.200000,1.00000,-6.000,-0.0225,-0.150000,-0.50000\r\n"
    ),
    "bluehill-universal": b"Time,Displacement,Force\r\n(s),(mm),(N)\r\n0,-2.0473,-4.319\r\n0.02,3.8871,0\r\n",
    "bluehill3": (
        b'Text Inputs : Specimen label,"22L.3"\r\nGeneral : Start Date,13/11/2018 5:14 PM\r\n\r\n'
        b"Time,Extension,Load,Segment ID,Total Cycle Count\r\n(sec),(mm),(N),,\r\n"
        b"0.00000,-2.04726,-4.31900,22476,0\r\n"
    ),
    "bluehill3-quoted": (
        b'Specimen number (included),1\r\nSpecimen ID,"22L.3"\r\n\r\n'
        b"Time,Extension,Load,Tensile strain (Strain 1),Tensile stress\r\n(s),(mm),(N),(%),(MPa)\r\n"
        # -2.04726 mm of 45 mm; -4.319 N on 40 mm x 1 mm.
        b'"0.00000","-2.04726","-4.31900","-4.5495","-0.1080"\r\n'
    ),
    "alemnis-tsv": (
        b"Time\tCorrected Displacement\tTime\tCorrected Load\tTime\tRaw Displacement\tTime\tRaw Load\r\n"
        b"-00:00:06.135\t0\t-00:00:06.132\t-0.002p\t-00:00:06.135\t0\t-00:00:06.132\t1m\r\n"
    ),
}


@pytest.mark.parametrize("name", FIRST_LINES)
def test_first_lines_are_those_of_the_instrument(name: str) -> None:
    assert text(name, logged()).startswith(FIRST_LINES[name])


def test_the_quoted_form_marks_thousands_inside_its_quotes() -> None:
    *_, last = text("bluehill3-quoted", logged()).splitlines()
    assert last == b'"1,234.50000","12.50000","1,234.56789","27.7778","30.8642"'
    *_, last = text("bluehill3-quoted", logged(), "de").splitlines()
    assert last == b'"1234,50000";"12,50000";"1234,56789";"27,7778";"30,8642"'


@pytest.mark.parametrize("name", ["bluehill3", "bluehill3-quoted", "bluehill3-results"])
def test_one_blank_line_and_no_footer(name: str) -> None:
    lines = text(name, logged()).split(b"\r\n")
    assert [k for k, line in enumerate(lines[:-1]) if not line] == [lines.index(b"")]
    assert lines[-1] == b""
    assert b"1,234.5" in lines[-2] or lines[-2].startswith(b"1234.5")


def test_the_results_are_those_of_the_largest_load() -> None:
    lines = text("bluehill3-results", logged()).decode().split("\r\n")
    assert lines[0] == "Results Table 1"
    headings, units, values = (next(csv.reader([line])) for line in lines[1:4])
    assert dict(zip(headings, zip(values, units, strict=True), strict=True)) == {
        "": ("1", ""),
        "Maximum Load": ("1,234.56789", "(N)"),
        "Extension at Maximum Load": ("12.50000", "(mm)"),
        "Tensile strain at Maximum Load": ("27.7778", "(%)"),
        "Tensile stress at Maximum Load": ("30.8642", "(MPa)"),
    }
    assert "\r\n".join(lines[5:]).encode() == text("bluehill3-quoted", logged()).split(b"\r\n\r\n")[1]


@pytest.mark.parametrize(
    ("hour", "en", "de"), [(0, "12:05 AM", "00:05"), (11, "11:05 AM", "11:05"), (12, "12:05 PM", "12:05")]
)
def test_noon_and_midnight_are_twelve(hour: int, en: str, de: str) -> None:
    moment = datetime.fromisoformat(f"2026-01-02T{hour:02d}:05:59+00:00")
    assert LOCALES["en"].date(moment) == f"02/01/2026 {en}"
    assert LOCALES["de"].date(moment) == f"02.01.2026 {de}"


def test_biotester_opens_in_a_plain_csv_reader() -> None:
    table = list(csv.DictReader(io.StringIO(text("biotester", logged()).decode(), newline="")))
    assert len(table) == 4
    reference = float(table[0]["XSize_um"])
    strain = [float(line["XSize_um"]) / reference - 1 for line in table]
    assert strain == pytest.approx([0.0, 10 / 45000, 20 / 45000, 10 / 45000])
    assert table[3]["SetName"] == "pull, again"


def test_zeroing_the_display_does_not_move_the_hooks() -> None:
    zeroed = stage()
    zeroed.offset["XDisplacement"][:] = 5e-3
    ((channels,), _) = LOGS["biotester"].gather(logged(biaxial_hook=zeroed))
    assert channels["XSize"][0] == pytest.approx(50e-3)
    assert channels["XDisplacement"][0] == 0.0


@pytest.mark.parametrize("phase", ["Preload", "Stretch", "Recover", "Hold", "Zero"])
def test_cycle_is_text(phase: Phase) -> None:
    assert cycle_text(1, phase) == f"1-{'Preload' if phase == 'Zero' else phase}"


def test_the_merged_table_is_on_the_frames_clock() -> None:
    # The stage's clock shows 0.3 s when the frame's starts, and runs 1 % fast; its travel is 2 mm/s of true time.
    true: FloatArray = 0.1 * np.arange(40.0)
    own = replace(stage(), time=stamps(true, 0.3, 0.01), clock_offset=0.3, clock_skew=0.01)
    own = replace(own, measured=dict.fromkeys(own.measured, 0.002 * true))
    short = replace(frame(), time=np.array([0.0, 0.55, 1.21, 3.9]))
    short = replace(short, measured={name: values[:4] for name, values in short.measured.items()})
    ((channels,), _) = LOGS["triaxial"].gather(logged(biaxial_hook=own, uniaxial_frame=short))
    assert channels["Time"] == [0.0, 0.55, 1.21, 3.9]
    assert channels["biaxial-hook.XDisplacement"] == pytest.approx([0.0, 1.1e-3, 2.42e-3, 7.8e-3])
    assert channels["biaxial-hook.Time"] == pytest.approx([0.3, 0.8555, 1.5221, 4.239])


def test_displacement_is_corrected_for_the_frame_and_load_for_zero() -> None:
    test = logged()
    ((channels,), _) = LOGS["alemnis"].gather(test)
    assert [len(column) for column in channels.values()] == [3] * 6
    # 1.2345678 um less 1 um/N x 2.5 N, and the load's zero, 1 mN.
    assert (channels["Corrected displacement"][2], channels["Raw displacement"][2]) == ("-1.26543u", "1.23457u")
    assert (channels["Corrected load"][2], channels["Raw load"][2]) == (2.5, 2.501)


def test_no_time_stamp_is_repeated() -> None:
    fast = replace(indenter(), time=4e-4 * np.arange(4.0))
    ((channels,), _) = LOGS["alemnis"].gather(logged(nanoindenter=fast))
    for name in ("Displacement time", "Load time"):
        assert len(set(channels[name])) == len(channels[name]) == 2


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (655e-9, "655n"),
        (1.42e-3, "1.42m"),
        (-1.42e-3, "-1.42m"),
        (0.0, 0),
        (-0.0, 0),
        (1e-3, "1m"),
        (9.999999e-4, "1m"),
        (0.9999999, 1.0),
        (123.4567891, 123.457),
        (2e-15, "0.002p"),
        (1e-17, 0),
    ],
)
def test_values_carry_their_prefix(value: float, shown: object) -> None:
    assert prefixed(value) == shown


@pytest.mark.parametrize(
    ("time", "shown"),
    [(-6.135, "-00:00:06.135"), (-0.0004, "00:00:00.000"), (59.9996, "00:01:00.000"), (36000.001, "10:00:00.001")],
)
def test_times_are_texts(time: float, shown: str) -> None:
    assert clock_text(time) == shown


def test_the_workbook_has_one_sheet_with_the_columns_of_the_text() -> None:
    log, test = LOGS["alemnis"], logged()
    ((channels,), _) = log.gather(test)
    made = write_sheet(log.dialect, [channels], test.start())
    assert made == write_sheet(log.dialect, [channels], test.start())
    book = load_workbook(io.BytesIO(made))
    assert len(book.worksheets) == 1
    rows = [["" if cell is None else str(cell) for cell in row] for row in book.active.iter_rows(values_only=True)]
    lines = text("alemnis-tsv", test).decode().split("\r\n")[:-1]
    assert rows == [line.split("\t") for line in lines]
    assert isinstance(book.active["B2"].value, int)
    assert book.active["A2"].data_type == book.active["D3"].data_type.replace("n", "s") == "s"


def test_the_description_decides_the_bytes() -> None:
    dialect = Dialect(
        name="tabs",
        preamble=(("who", Fact(fact="name", quoted=True)), ()),
        columns=(Column(name="µ", channel="a", unit="um", form=".0f"), Column(name="t", channel="b")),
        delimiter="\t",
        line_end="\n",
        quote="'",
        encoding="cp1252",
    )
    lines = b"".join(write_log(dialect, [{"a": [1e-6, -1e-9], "b": ["x", "it's"]}], {"name": "é"}))
    assert lines == b"who\t'\xe9'\n\n\xb5\tt\n1\tx\n0\t'it''s'\n"


def test_other_units_lose_no_digit() -> None:
    lines = text("bluehill-universal", logged(), force="mN", length="um").splitlines()
    assert lines[1] == b"(s),(um),(mN)"
    assert lines[2] == b"0,-2047.3,-4319"
    assert text("bluehill3", logged(), force="kN").splitlines()[5] == b"0.00000,-2.04726,-0.00431900,22476,0"
    assert text("biotester", logged(), length="mm").splitlines()[1].startswith(b"22L.3,1-Preload,0.000,22.0,45.000,")
    assert text("biotester", logged(), force="N").splitlines()[0].endswith(b",XForce_N,YForce_N")


@pytest.mark.parametrize(
    ("name", "units", "message"),
    [
        ("biotester", {"weight": "kg"}, "units: found 'weight', allowed one of time, length"),
        ("biotester", {"force": "kg"}, r"units\.force: found 'kg', allowed one of N, mN"),
        ("biotester", {"stress": "Pa"}, r"units\.stress: found 'Pa', allowed none: biotester says no unit"),
        ("biotester", {"time": "ms"}, "says no unit of time"),
        ("alemnis-tsv", {"force": "mN"}, "says no unit of force"),
    ],
)
def test_other_units_are_refused_in_one_line(name: str, units: dict[str, str], message: str) -> None:
    with pytest.raises(SpecificationError, match=message):
        in_units(LOGS[name].dialect, units)


def test_other_locales_are_refused_in_one_line() -> None:
    with pytest.raises(SpecificationError, match="locale: found 'tlh', allowed one of en, de, fr"):
        localised(LOGS["biotester"].dialect, "tlh")
    with pytest.raises(SpecificationError, match="allowed en for alemnis, the same everywhere"):
        localised(LOGS["alemnis"].dialect, "de")


def test_every_machine_has_a_default() -> None:
    assert defaults(["biaxial-hook"]) == ["biotester"]
    assert defaults(["uniaxial-frame"]) == ["bluehill-universal"]
    assert defaults(["nanoindenter"]) == ["alemnis"]
    assert defaults(["biaxial-hook", "uniaxial-frame"]) == ["biotester", "bluehill-universal", "triaxial"]
    assert defaults(["shear-stage"]) == ["shear-stage"]
    assert defaults([]) == []


def test_a_missing_channel_fact_or_date_is_named() -> None:
    with pytest.raises(SpecificationError, match="'Cycle'"):
        list(write_log(LOGS["biotester"].dialect, [{"SetName": []}]))
    with pytest.raises(SpecificationError, match="a fact 'label'"):
        list(write_log(LOGS["bluehill3"].dialect, []))
    with pytest.raises(SpecificationError, match=r"run\.started: found 'nothing'"):
        LOGS["bluehill3"].gather(replace(logged(), facts={}))


def test_channels_must_be_of_one_length() -> None:
    dialect = Dialect(name="d", columns=(Column(name="a", channel="a"), Column(name="b", channel="b")))
    with pytest.raises(SpecificationError, match="one length"):
        list(write_log(dialect, [{"a": [1], "b": [1, 2]}]))


def test_a_workbook_takes_no_more_memory_the_longer_it_is() -> None:
    dialect = LOGS["alemnis"].dialect

    def peak(parts: int) -> int:
        tracemalloc.start()
        many = ({column.channel: [0.25] * 100 for column in dialect.columns} for _ in range(parts))
        write_sheet(dialect, many, datetime(2026, 1, 1, tzinfo=UTC))
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(1)
    # A row in memory was 2 kB.
    assert peak(15) - peak(5) < 200_000


def test_a_gauge_length_taken_at_a_zero_counts_from_there_and_stands_above_the_table() -> None:
    moment = 10.05
    zero = Zeroing(
        time=moment, kinds=frozenset({"displacement"}), travel={"C": 4e-3}, force={"C": 0.1}, gauges={"C": 50e-3}
    )
    taken = replace(logged(), zeroings=(zero,))
    before, after = (text("bluehill3-quoted", one).splitlines() for one in (logged(), taken))
    # Four samples before the zero as they were; 12.5 mm of 50 mm after it. Its sides are free: 40 mm x 1 mm stay.
    assert after[:9] == before[:9]
    assert after[-1] == b'"1,234.50000","12.50000","1,234.56789","25.0000","30.8642"'
    assert b'"25.0000","30.8642"' in text("bluehill3-results", taken).splitlines()[3]
    lines, plain = (text("bluehill3", one).splitlines() for one in (taken, logged()))
    assert lines[2:5] == [
        b"Dimension : Length,50.00000,mm",
        b"Number Inputs : Length as printed,45.00000,mm",
        b"Number Inputs : Extension from printed to zero,4.00000,mm",
    ]
    assert lines[:2] + lines[5:] == plain
    for name in ("bluehill-universal", "biotester"):
        assert text(name, taken) == text(name, logged())


# The last field of the first line of numbers: a distance of 14.0625 mm in the unit and the digits of the dialect.
PINNED = {
    "biotester": ("ExtensometerC_um", "14062"),
    "bluehill-universal": ("Extensometer C", "14.0625"),
    "bluehill3": ("Extensometer C", "14.06250"),
    "bluehill3-quoted": ("Extensometer C", '"14.06250"'),
    "bluehill3-results": ("Extensometer C", '"14.06250"'),
    "triaxial": ("biaxial-hook.ExtensometerC", "14.0625"),
    "alemnis-tsv": ("Extensometer C", "14.0625m"),
}


def pinned(made: Samples) -> Samples:
    """Return samples with those of an extensometer along the course, which the frame's do not drive."""
    further = {"ExtensometerC": np.full(len(made), 14.0625e-3)}
    return replace(
        made,
        measured={**made.measured, **further},
        clean={**made.clean, **further},
        offset={**made.offset, "ExtensometerC": np.zeros(len(made))},
        units={**made.units, "ExtensometerC": "m"},
        reads={"ExtensometerC": "pin_distance_C", **made.reads},
    )


@pytest.mark.parametrize("name", PINNED)
def test_an_extensometer_has_the_last_column_of_a_log_and_changes_no_other(name: str) -> None:
    log, machine = LOGS[name], LOGS[name].machines[-1]
    test = replace(logged(), samples={**logged().samples, machine: pinned(logged().samples[machine].part(0, 8))})
    plain = text(name, logged()).decode().splitlines()
    lines = b"".join(write_log(log.shown(test), *log.gather(test))).decode().splitlines()
    heading, number = PINNED[name]
    mark = log.dialect.delimiter
    assert any(line.endswith(f"{mark}{heading}") for line in lines)
    assert lines[-1].endswith(f"{mark}{number}")
    assert len(lines) == len(plain)
    assert all(line == before or line.startswith(f"{before}{mark}") for line, before in zip(lines, plain, strict=True))
    assert log.shown(logged()) == log.dialect


def test_the_axis_of_a_frame_is_the_one_that_it_pulls_whatever_its_extensometer_measures() -> None:
    made = frame()
    wale = replace(made, reads={name: read.replace("_C", "_W") for name, read in made.reads.items()})
    assert axis_of(pinned(wale)) == "W"
