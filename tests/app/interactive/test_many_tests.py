"""Sweeps, comparisons and calibrations from Python: what they take, what they give, how a notebook shows them."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import knitlab as kl

if TYPE_CHECKING:
    from pathlib import Path

PROTOCOL: dict[str, Any] = {
    "schema": "knitlab/protocol@1",
    "rig": "biaxial-hook",
    "params": {"l": "8 mm", "far": "2.5 %"},
    "specimen": {
        "knit": "stockinette-default",
        "loops": [2, 2],
        "loop": "${l}",
        "material": "RGD8530-DM",
        "friction": 0.3,
        "nodes_per_loop": 16,
    },
    "others": "hold",
    "log": {"noise": "off"},
    "steps": [{"cycle": {"axes": ["C"], "lower": 0, "upper": "${far}", "rate": "0.2 mm/s", "n": 1}}],
}
WIDTHS = ("8 mm", "8.4 mm")


@pytest.fixture(scope="module")
def told() -> list[tuple[float, str]]:
    return []


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory, told: list[tuple[float, str]]) -> kl.Sweep:
    out = tmp_path_factory.mktemp("swept") / "<b>"
    return kl.sweep(PROTOCOL, out, lambda *said: told.append(said), values={"l": WIDTHS}, draw=None)


def test_a_sweep_of_data_over_values_has_a_run_a_point(swept: kl.Sweep, told: list[tuple[float, str]]) -> None:
    assert [one.point.values for one in swept.points] == [{"l": "8 mm"}, {"l": "8.4 mm"}]
    assert swept["l=8.4_mm"].record.test.specimen.loop_width == pytest.approx(8.4e-3)
    assert [run.outcome for run in swept.runs] == ["target", "target"]
    with pytest.raises(kl.SpecificationError, match=r"l=9 mm.*allowed one of l=8_mm, l=8\.4_mm"):
        swept["l=9 mm"]
    shares = [share for share, _ in told]
    assert shares == sorted(shares), "one bar for all points"
    assert shares[-1] == 1.0
    assert any("l=8.4_mm: Stretch" in words for _, words in told)


def test_its_table_is_the_file_with_all_digits(swept: kl.Sweep) -> None:
    with swept.table_file.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(swept.table.columns) == list(rows[0])
    assert swept.table["loop area, C, cycle 1 [J/m3]"].tolist() == [
        float(row["loop area, C, cycle 1 [J/m3]"]) for row in rows
    ]
    assert swept.plot().figure.axes[0].get_legend_handles_labels()[1][-1] == "l=8.4_mm"
    assert np.array_equal(swept.plot("loop area C").figure.axes[0].lines[0].get_xdata(), [8.0, 8.4])
    shown = swept._repr_html_()
    assert "data:image/png;base64," in shown
    assert "secant modulus" in shown
    assert "<b><" not in shown, "names of users are escaped"


def test_protocols_of_any_kind_are_the_points_of_a_list(tmp_path: Path) -> None:
    once = {**PROTOCOL, "params": {"l": "8 mm"}, "steps": [{"hold": {"for": "1 s"}}]}
    text = kl.to_yaml(kl.load(once).protocol)
    (tmp_path / "held.yaml").write_text(text.replace("name: test\n", ""), encoding="utf-8")
    several: list[Any] = [once, kl.load(once).protocol, text, str(tmp_path / "held.yaml")]
    swept = kl.sweep(several, tmp_path / "out", draw=None)
    assert [one.point.label for one in swept.points] == ["test", "test-2", "test-3", "held"]
    assert {one.outcome for one in swept.points} == {"target"}
    for wrong, words in (([], "0 protocols"), ([PROTOCOL, {**PROTOCOL, "rig": "hook"}], "rig: found 'hook'")):
        with pytest.raises(kl.SpecificationError, match=words):
            kl.sweep(wrong, tmp_path / "wrong", draw=None)
    with pytest.raises(kl.ProtocolError, match=r"sweep\.nu: found 'nu', allowed a name under params: l, far"):
        kl.sweep(PROTOCOL, tmp_path / "wrong", values={"nu": [1]})
    with pytest.raises(kl.ProtocolError, match=r"sweep: found nothing"):
        kl.sweep(kl.load(once).protocol, tmp_path / "wrong")


def test_runs_records_and_sweeps_are_compared(swept: kl.Sweep, tmp_path: Path) -> None:
    both = kl.compare(swept)
    names = list(dict.fromkeys(both.table["name"]))
    assert names == ["test, l=8_mm", "test, l=8.4_mm"], "points are told apart by their folders"
    (log,) = swept["l=8.4_mm"].to_csv(out=tmp_path)
    one = kl.compare([swept["l=8.4_mm"], swept.runs[0].record, log], tmp_path / "over.svg", axis="C")
    assert one.figure == tmp_path / "over.svg"
    error = one.table[(one.table["figure"] == "NRMSE")].set_index("name")["value"]
    assert error["test, l=8.4_mm"] < 0.01 < error["test, l=8_mm"], "the log is that of the wider knit"
    assert both.figure is None
    assert not list(tmp_path.glob("*.png"))
    shown = both._repr_html_()
    assert "data:image/png;base64," in shown
    assert "NRMSE" in shown
    assert "stress over strain: test, l=8_mm" in repr(both)


def test_a_calibration_of_data_shows_its_estimates(swept: kl.Sweep, tmp_path: Path) -> None:
    told: list[float] = []
    found = kl.calibrate(
        {**PROTOCOL, "params": {"l": "8.4 mm", "far": "2.5 %"}},
        swept["l=8.4_mm"],
        {"l": ("7.5 mm", "9 mm")},
        tmp_path / "fit",
        lambda share, _: told.append(share),
        axis="C",
    )
    assert found.table["estimate"].tolist() == pytest.approx([8.4], abs=0.01)
    assert found.last < 1e-6
    assert len(told) == found.runs == 3, "the curve that it looks for, and one of each side"
    drawn = found.plot().figure.axes[0].lines
    assert len(found.curves) == sum(np.size(line.get_xdata()) for line in drawn[::2]), "of loading and unloading"
    shown = found._repr_html_()
    assert "estimate" in shown
    assert "data:image/png;base64," in shown
    assert repr(found).startswith("Calibration(l=8.4")


def test_a_file_may_list_the_tests(swept: kl.Sweep, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "runs").symlink_to(swept.folder)
    file = tmp_path / "sub" / "tests.yaml"
    file.write_text('schema: knitlab/tests@1\ntests: ["../runs/l=8_mm", "../runs/l=8.4_mm"]\n', encoding="utf-8")
    assert kl.compare(file).table.equals(kl.compare(swept).table)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("schema: knitlab/tests@1\ntests: [none.csv]\n", "2:9: tests.0: found 'none.csv', allowed a run folder or"),
        ("schema: knitlab/tests@1\ntest: [a.csv]\n", "2:1: test: found an unknown field, allowed schema, tests"),
        ("schema: knitlab/tests@1\ntests: none.csv\n", "2:8: tests: found 'none.csv', allowed a list of run folders"),
        ("schema: knitlab/design@1\n", "1:9: schema: found 'knitlab/design@1', allowed knitlab/tests@1"),
        ("- a\n", "1:1: schema: found nothing, allowed knitlab/tests@1"),
    ],
)
def test_a_list_with_a_mistake_is_named_with_its_place(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "tests.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(kl.ProtocolError) as raised:
        kl.compare(tmp_path / "tests.yaml")
    assert str(raised.value).startswith(f"{tmp_path / 'tests.yaml'}:{said}")
