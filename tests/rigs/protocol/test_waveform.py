from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.schemas import ProtocolError, from_yaml, load, load_sweep, loads, to_yaml
from app.schemas.files_beside import TABLE
from knitlab_core.errors import SpecificationError
from rigs.control.plan import planned_duration
from rigs.protocol.protocol import Hold, Protocol, Ramp, SpecimenSpec, Target, Waveform, Zero
from rigs.protocol.waveform import MOST_POINTS
from tests.planned import planned_strokes

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import Axis

GAUGES: dict[Axis, float] = {"C": 0.05, "W": 0.04}
SPECIMEN = SpecimenSpec(knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM")
POINTS = ((0.0, 0.0), (10.0, 0.02), (15.0, 0.02), (20.0, 0.05), (40.0, -0.01))
TEXT = """\
schema: knitlab/protocol@1
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM}
others: hold
params: {wave: wave.csv}
steps:
  - zero: {channels: [force]}
  - repeat: {n: 2, steps: [{waveform: {axes: [C], table: wave.csv, kind: KIND, until: {force: 2 N}, tag: w}}]}
"""


def of(**values: object) -> Protocol:
    steps = (Waveform(**{"axes": ("C",), "points": POINTS, **values}),)  # type: ignore[arg-type]
    return Protocol(specimen=SPECIMEN, others="hold", steps=steps)


def test_each_piece_of_a_waveform_is_a_stroke() -> None:
    strokes = planned_strokes(of(), GAUGES)
    assert [stroke.end["C"] for stroke in strokes] == [0.05 * level for _, level in POINTS[1:]]
    assert [stroke.duration for stroke in strokes] == [10.0, 5.0, 5.0, 20.0]
    assert [stroke.phase for stroke in strokes] == ["Stretch", "Hold", "Stretch", "Recover"]
    assert {stroke.end["W"] for stroke in strokes} == {0.0}
    assert planned_duration(of(), GAUGES) == 40.0


def test_levels_count_from_the_last_zero_and_the_first_piece_begins_where_the_axes_are() -> None:
    there = Ramp(axes=("C",), to=Target(kind="displacement", value=0.004), rate=1e-3)
    wave = Waveform(axes=("C",), points=((0.0, 0.0), (1.0, 0.002), (2.0, 0.002)), kind="displacement")
    for steps, ends in (((there, wave), [0.004, 0.002, 0.002]), ((there, Zero(), wave), [0.004, 0.004, 0.006, 0.006])):
        strokes = planned_strokes(Protocol(specimen=SPECIMEN, others="hold", steps=steps), GAUGES)
        assert [stroke.end["C"] for stroke in strokes] == pytest.approx(ends)
        assert strokes[-1].phase == "Hold"


def test_forces_follow_too_and_are_held_where_the_line_is_level() -> None:
    wave = of(kind="force", points=((0.0, 0.0), (2.0, 0.1), (5.0, 0.1), (6.0, 0.0)))
    strokes = planned_strokes(wave, GAUGES)
    assert [stroke.force["C"] for stroke in strokes] == [(0.0, 0.1), (0.1, 0.1), (0.1, 0.0)]
    assert [stroke.phase for stroke in strokes] == ["Stretch", "Hold", "Recover"]


def test_a_held_piece_leaves_free_axes_free() -> None:
    strokes = planned_strokes(
        Protocol(specimen=SPECIMEN, others="free", steps=(of().steps[0], Hold(duration=1.0))), GAUGES
    )
    assert {stroke.free for stroke in strokes} == {("W",)}


@pytest.mark.parametrize(
    ("points", "says"),
    [
        (((0.0, 0.0),), "points: found '1 points', allowed 2 to 2000 points"),
        (((1.0, 0.0), (2.0, 0.0)), r"points\[0\]: found '1 s', allowed 0 s"),
        (((0.0, 0.0), (2.0, 0.0), (2.0, 0.1)), r"points\[2\]: found '2 s', allowed a time above 2 s"),
        (((0.0, 0.0), (2.0, 9.0)), r"points\[1\]: found 9.0, allowed a strain"),
    ],
)
def test_points_out_of_range_are_refused(points: tuple[tuple[float, float], ...], says: str) -> None:
    with pytest.raises(SpecificationError, match=says):
        of(points=points)


@pytest.mark.parametrize(
    ("kind", "table", "points"),
    [
        ("strain", "time (s),strain (%)\r\n0,0\r\n10,2\r\n", ((0.0, 0.0), (10.0, 0.02))),
        ("strain", '\ufeff"Time (min)","strain (1)"\n0,0.01\n 1.5 , -0.02 \n\n', ((0.0, 0.01), (90.0, -0.02))),
        ("displacement", "time (ms),displacement (mm)\n0,0\n20,1e-1\n", ((0.0, 0.0), (0.02, 1e-4))),
        ("force", "time (s),force (mN)\n0,0\n0.1,50\n", ((0.0, 0.0), (0.1, 0.05))),
    ],
)
def test_a_table_is_read_and_kept_in_the_text_of_a_record(
    kind: str, table: str, points: tuple[tuple[float, float], ...], tmp_path: Path
) -> None:
    (tmp_path / "wave.csv").write_text(table, encoding="utf-8", newline="")
    (tmp_path / "p.yaml").write_text(TEXT.replace("KIND", kind).replace("table: wave.csv", 'table: "${wave}"'))
    loaded = load(tmp_path / "p.yaml")
    wave = loaded.protocol.steps[1].steps[0]  # type: ignore[union-attr]
    assert isinstance(wave, Waveform)
    assert list(wave.points) == [pytest.approx(point) for point in points]
    # Without the table the text says the same, to the bit.
    assert from_yaml(loaded.text) == loaded.protocol == from_yaml(to_yaml(loaded.protocol))
    assert loaded.text.startswith("# p.yaml with wave.csv\n")


def test_points_may_stand_in_the_protocol() -> None:
    text = TEXT.replace("table: wave.csv", "points: [[0 s, 0 %], [1 min, 5 %]]").replace("kind: KIND, ", "")
    wave = from_yaml(text.replace("params: {wave: wave.csv}\n", "")).steps[1].steps[0]  # type: ignore[union-attr]
    assert wave.points == ((0.0, 0.0), (60.0, 0.05))  # type: ignore[union-attr]


HEAD = "time (s),strain (%)\n"


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("", "wave.csv:1:1: table: found nothing, allowed a head and two points or more, such as time (s),strain (%)"),
        (HEAD + "0,0\n", "wave.csv:1:1: table: found 1 points, allowed a head and two points or more, such as"),
        ("t,e\n0,0\n1,1\n", "wave.csv:1:1: table: found 't', allowed the name and the unit, such as time (s)"),
        ("time (s),force (N)\n0,0\n1,1\n", "wave.csv:1:10: table: found 'force (N)', allowed the name and the unit"),
        ("time (s),strain (mm)\n0,0\n1,1\n", "wave.csv:1:10: table: found 'strain (mm)', allowed the name and the u"),
        (
            "time (s)\n0\n1\n",
            "wave.csv:1:1: table: found 1 columns, allowed two columns with their units: time (s),stra",
        ),
        (HEAD + "1,0\n2,1\n", "wave.csv:2:1: table: found 1 s, allowed 0 s: the step begins there"),
        (HEAD + "0,0\n2,1\n2,2\n", "wave.csv:4:1: table: found 2 s, allowed a time above 2 s, that before it"),
        (HEAD + "0,0\n12,x\n", "wave.csv:3:4: table: found 'x', allowed a number, in %"),
        (HEAD + "0,0\nnan,1\n", "wave.csv:3:1: table: found 'nan', allowed a number, in s"),
        (HEAD + "0,0\n1,1,1\n", "wave.csv:3:1: table: found 3 columns, allowed two: a time and a level"),
        (HEAD + "0,0\n1,900\n", "wave.csv:3:3: table: found 9.0, allowed a strain from -0.9 to 5"),
        (HEAD + "0,0\n1e9,1\n", "wave.csv:3:1: table: found 1e+09 s, allowed a time above 0 and up to 1e7 s"),
        (HEAD + "0,0\n1,1\x00\n", "wave.csv:3:"),
        (HEAD + "0,0\n" * (MOST_POINTS + 1), f"wave.csv:{MOST_POINTS + 2}:1: table: found more, allowed {MOST_POINTS}"),
        ("x" * (TABLE.most + 1), f"wave.csv:1:1: table: found more, allowed {TABLE.most} bytes or fewer"),
    ],
)
def test_a_mistake_in_a_table_is_one_line_with_its_place(table: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "wave.csv").write_text(table, encoding="utf-8")
    (tmp_path / "p.yaml").write_text(TEXT.replace("params: {wave: wave.csv}\n", "").replace("KIND", "strain"))
    with pytest.raises(ProtocolError) as caught:
        load(tmp_path / "p.yaml")
    assert str(caught.value).startswith(f"{tmp_path}/{says}")
    assert not caught.value.more


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            "wave.csv",
            "../wave.csv",
            "p.yaml:7:58: steps[1].repeat.steps[0].waveform.table: found '../wave.csv', allowed a CSV f",
        ),
        (
            "wave.csv",
            "none.csv",
            "none.csv:1:1: table: found no such file or directory, allowed a CSV file that can be re",
        ),
        (
            "table: wave.csv",
            "points: [[0 s, 1 mm], [1 s, 0]]",
            "p.yaml:7:66: steps[1].repeat.steps[0].waveform.points[0][1]: ",
        ),
        (
            "table: wave.csv",
            "points: [[0 s], [1 s, 0]]",
            "p.yaml:7:60: steps[1].repeat.steps[0].waveform.points[0]: found a l",
        ),
        (
            "table: wave.csv, ",
            "",
            "p.yaml:7:39: steps[1].repeat.steps[0].waveform: found a mapping, allowed one of table and",
        ),
        (
            "kind",
            "points: [[0 s, 0], [1 s, 0]], kind",
            "p.yaml:7:39: steps[1].repeat.steps[0].waveform: found a mapping, a",
        ),
        (
            "table",
            "tabel",
            "p.yaml:7:51: steps[1].repeat.steps[0].waveform.tabel: found an unknown field, allowed axes, table,",
        ),
    ],
)
def test_a_mistake_in_the_step_is_one_line_with_its_place(old: str, new: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "wave.csv").write_text(HEAD + "0,0\n1,1\n")
    text = TEXT.replace("params: {wave: wave.csv}\n", "").replace("KIND", "strain").replace(old, new)
    (tmp_path / "p.yaml").write_text(text)
    with pytest.raises(ProtocolError) as caught:
        load(tmp_path / "p.yaml")
    assert str(caught.value).startswith(f"{tmp_path}/{says}")


def test_a_text_without_a_file_reads_no_table(tmp_path: Path) -> None:
    (tmp_path / "wave.csv").write_text(HEAD + "0,0\n1,1\n")
    text = TEXT.replace("params: {wave: wave.csv}\n", "").replace("KIND", "strain")
    with pytest.raises(ProtocolError, match=r"table: found 'wave\.csv', allowed points: a text without a file has no"):
        loads(text, str(tmp_path / "p.yaml"))


def test_a_sweep_may_go_through_tables(tmp_path: Path) -> None:
    for number in (1, 2):
        (tmp_path / f"{number}.csv").write_text(HEAD + f"0,0\n1,{number}\n")
    text = TEXT.replace("{wave: wave.csv}", "{wave: 1.csv}\nsweep: {wave: [1.csv, 2.csv]}").replace("KIND", "strain")
    (tmp_path / "p.yaml").write_text(text.replace("table: wave.csv", 'table: "${wave}"'))
    swept = [from_yaml(loaded.text) for _, loaded in load_sweep(tmp_path / "p.yaml")]
    assert [test.steps[1].steps[0].points[1][1] for test in swept] == [0.01, 0.02]  # type: ignore[union-attr]


def test_tables_that_no_record_could_hold_are_refused(tmp_path: Path) -> None:
    (tmp_path / "wave.csv").write_text(HEAD + "".join(f"{time},0\n" for time in range(MOST_POINTS)))
    wave = "  - waveform: {axes: [C], table: wave.csv}\n"
    text = TEXT.replace("params: {wave: wave.csv}\n", "").partition("  - repeat")[0]
    (tmp_path / "p.yaml").write_text(text + wave)
    assert load(tmp_path / "p.yaml").protocol.steps[1].stroke_count == MOST_POINTS - 1  # type: ignore[union-attr]
    (tmp_path / "p.yaml").write_text(text + wave * 2)
    with pytest.raises(
        ProtocolError, match="steps: found 12026 values, allowed 10000 or fewer in a protocol with its t"
    ):
        load(tmp_path / "p.yaml")
