"""Strain a yarn beyond what its material bears, with rupture off: said before, in the summary and in the record."""

from __future__ import annotations

import csv
import json
import sys
from typing import TYPE_CHECKING

import h5py
import pytest

from app.cli.main import main
from app.records.reader import RunReader

if TYPE_CHECKING:
    from pathlib import Path

PROTOCOL = """schema: knitlab/protocol@1
rig: uniaxial-frame
mount: W
materials:
  pla:
    young_modulus: {value: 2.6 GPa, source: a test}
    poisson_ratio: {value: 0.36, source: a test}
    strength: {value: 55 MPa, source: a test}
    elongation_at_break: {value: 4 %, source: a test}
params: {top: 17.5 %}
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: pla, friction: 0.3, nodes_per_loop: 16}
speed_ref: pair
others: free
max_strain_increment: 2.5 %
log: {rate: 10 Hz, noise: off}
steps:
  - zero: {channels: [force, displacement]}
  - ramp: {axes: [W], to: {strain: "${top}"}, rate: 2 mm/s}
"""


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.views.drawing.draw_pictures", lambda *_: "")


def said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *words: object) -> tuple[str, str]:
    monkeypatch.setattr(sys, "argv", ["knitlab", *map(str, words)])
    with pytest.raises(SystemExit) as raised:
        main()
    assert not raised.value.code
    captured = capsys.readouterr()
    return captured.out, captured.err


def test_passing_the_strength_is_said_before_and_after(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "pla.yaml"
    path.write_text(PROTOCOL, encoding="utf-8")
    _, err = said(capsys, monkeypatch, "check", path, "--set", "top=60 %")
    assert "WARNING: material: strength of 55 MPa would be passed" in err
    assert "WARNING: material: elongation at break of 4 % would be passed" in err

    out, _ = said(capsys, monkeypatch, "run", path, "--out", tmp_path / "run", "--quiet", "--json", "--no-pictures")
    found = json.loads(out)
    assert found["outcome"] == "target"
    (crossing,) = found["crossings"]
    assert crossing["name"] == "strength"
    run = RunReader(tmp_path / "run" / "run.h5")
    strain = run.trace.columns["fibre_strain"]
    # Of all rows the first beyond, by a scan of the record.
    assert strain[crossing["row"]] > 55e6 / 2.6e9 >= strain[: crossing["row"]].max()
    assert crossing["time"] == run.trace.columns["time"][crossing["row"]]
    assert crossing["strain"]["W"] == pytest.approx(0.15)
    with h5py.File(tmp_path / "run" / "run.h5") as file:
        assert [text.decode() for text in file["limits/name"]] == ["strength", "elongation at break"]
        assert file["limits/row"][()].tolist() == [crossing["row"], -1]
        assert file["limits/strain_W"][0] == crossing["strain"]["W"]
    out, _ = said(capsys, monkeypatch, "analyse", tmp_path / "run")
    assert out.startswith("beyond strength: strength of 55 MPa passed at 1.418 s, strain W 15.0 %")


def test_a_sweep_says_it_of_each_point_and_plots_chosen_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "pla.yaml"
    path.write_text(PROTOCOL.replace("specimen:", "sweep: {top: [2.5 %, 17.5 %]}\nspecimen:"), encoding="utf-8")
    words = ("sweep", path, "--out", tmp_path / "out", "--quiet", "--plot", "secant_peak_W")
    out, _ = said(capsys, monkeypatch, *words)
    assert out.count("beyond strength") == 1
    assert "top=17.5_: beyond strength: strength of 55 MPa passed" in out
    assert (tmp_path / "out" / "sweep_secant_peak_W.png").read_bytes()[:4] == b"\x89PNG"
    with (tmp_path / "out" / "sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["strain W where strength is passed [1]"] for row in rows] == ["", "0.15"]
