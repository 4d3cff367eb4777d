"""Any text names a folder that every system takes, and what users name stays as they wrote it."""

from __future__ import annotations

import csv
import io
import unicodedata

from hypothesis import example, given
from hypothesis import strategies as st

from app.file_names import MOST_BYTES, MOST_SIGNS, file_stem
from app.runs.sweep_tables import safe_cell
from app.schemas import from_yaml
from app.schemas.sweep import label_of
from rigs.protocol.bounds import LONGEST_LABEL, as_label, is_label

#: What Windows refuses in a name, and the devices that it takes for none (Naming Files, Paths, and Namespaces).
FORBIDDEN = set('<>:"/\\|?*') | {chr(code) for code in range(32)}
DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{k}" for port in ("com", "lpt") for k in (*range(10), "¹", "²", "³"))}
FORMULAE = ("=", "+", "-", "@", "\t", "\r", "\uff1d", "\uff0b", "\uff0d", "\uff20")
TRICKY = st.text(st.sampled_from("aB1 ._-=,+/\\:*()[]ǘé日हि‍\u202e\U0001d49c\u200d\U000e0100con"), max_size=20)
WORDS = st.sampled_from(
    ["CON", "nul.txt", "..", ".", "a.", "a ", " ", "", "x" * 300, "日" * 100, "a-0123abcd", "É", "É"]
)
TEXTS = st.text(max_size=80) | TRICKY | WORDS
LABELS = TEXTS.filter(is_label)
PROTOCOL = """\
schema: knitlab/protocol@1
name: NAME
rig: uniaxial-frame
mount: W
specimen: {knit: stockinette-default, loops: [1, 1], loop: 8 mm, material: RGD8530-DM}
steps:
  - ramp: {axes: [W], to: 1 %, rate: 1 mm/s, tag: NAME}
"""


@given(TEXTS)
@example("../../etc/passwd")
@example("con.x.y")
@example("COM¹")
def test_any_text_names_a_folder_on_every_system(text: str) -> None:
    name = file_stem(text)
    assert name == file_stem(text) == unicodedata.normalize("NFC", name)
    assert file_stem(unicodedata.normalize("NFD", text)) == file_stem(unicodedata.normalize("NFC", text))
    assert 0 < len(name) <= MOST_SIGNS
    assert len(name.encode("utf-8")) <= MOST_BYTES
    assert not FORBIDDEN & set(name)
    assert all(unicodedata.category(sign)[0] != "C" for sign in name)
    assert name[0] not in " .-"
    assert name[-1] not in " ."
    assert name.partition(".")[0].strip().casefold() not in DEVICES
    # A suffix makes no device of it either, and a name is its own: it names one folder however often it is asked.
    assert f"{name}.csv".partition(".")[0].casefold() not in DEVICES


@given(TEXTS, TEXTS)
@example("knit (2)", "knit [2]")
@example("a/b", "a_b")
@example("knit (2)", "knit_2-2c4af33b")
@example("CON", "con-")
@example("a\u200db", "ab")
def test_different_texts_name_different_folders(one: str, other: str) -> None:
    left, right = (unicodedata.normalize("NFC", text) for text in (one, other))
    if left.casefold() != right.casefold():
        assert file_stem(one).casefold() != file_stem(other).casefold()
    elif left != right and file_stem(one) == file_stem(other):
        raise AssertionError(one, other)


@given(st.text(max_size=40))
def test_every_text_can_be_turned_into_a_label(text: str) -> None:
    label = as_label(text)
    assert is_label(label)
    assert len(label) <= LONGEST_LABEL
    if is_label(text):
        assert label == text


@given(LABELS)
@example("Prüfling")
@example("knit (2)")
@example("編み物 [3]")
@example("007")
@example("1.50")
@example("yes")
def test_a_label_is_kept_as_it_is_said(label: str) -> None:
    quoted = "'" + label + "'"
    protocol = from_yaml(PROTOCOL.replace("NAME", quoted))
    assert (protocol.name, getattr(protocol.steps[0], "tag", None)) == (label, label)
    assert not label.startswith(FORMULAE)


@given(
    st.integers(0, 10**30)
    | st.floats(0.0, 1e30).map(str)
    | st.from_regex(r"0[0-9]{1,5}(\.[0-9]{0,4})?0", fullmatch=True)
)
def test_a_number_names_a_test_with_the_very_digits_that_stand_there(number: object) -> None:
    text = str(number).replace("+", "")
    assert from_yaml(PROTOCOL.replace("NAME", text)).name == text


@given(TEXTS | st.from_regex(r"[=+@-][ -~]{0,10}", fullmatch=True))
@example("-2+3+cmd|' /C calc'!A0")
@example("-5 mm")
def test_no_cell_of_a_table_is_a_formula(text: str) -> None:
    stream = io.StringIO()
    csv.writer(stream).writerow([safe_cell(text)])
    (cell,) = next(csv.reader(io.StringIO(stream.getvalue(), newline="")), [""])
    number = cell.startswith(("-", "+")) and not set(cell) & set("|!'()=@&,;") and cell[1:].lstrip(".")[:1].isdigit()
    assert number or not cell.lstrip().startswith(FORMULAE)


VALUES = st.text(max_size=20) | st.floats(allow_nan=False) | st.integers() | st.booleans() | TRICKY


@given(VALUES, VALUES)
@example("a/b", "a_b")
@example("x y", "x (y)")
def test_a_point_has_a_folder_that_its_own_values_decide(one: str | float, other: str | float) -> None:
    labels = [label_of({"a": value}) for value in (one, other)]
    for label in labels:
        assert not FORBIDDEN & set(label)
        assert len(label.encode()) <= MOST_BYTES
        assert label[-1] not in " ."
    if not isinstance(one, str) or not isinstance(other, str):
        return
    # Of quantities a sign that no unit needs may be dropped: `2 %` and `2%` are one value.
    worded = not (one[:1] in "+-." or one[:1].isdigit() or other[:1] in "+-." or other[:1].isdigit())
    if worded and unicodedata.normalize("NFC", one).casefold() != unicodedata.normalize("NFC", other).casefold():
        assert labels[0].casefold() != labels[1].casefold()


def test_units_with_signs_beyond_ascii_keep_apart() -> None:
    assert label_of({"loop": "5 µm"}) == "loop=5_µm"
    assert label_of({"loop": "5 m"}) == "loop=5_m"


def test_many_values_make_a_folder_of_bounded_length() -> None:
    many = {f"parameter_{k}": f"value number {k}" for k in range(40)}
    assert len(label_of(many).encode()) <= MOST_BYTES
    assert label_of(many) != label_of({**many, "parameter_39": "another"})
