"""Calibration: hidden values come back from a noisy log, and what a log does not tell is said."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any

import pytest
from typer.testing import CliRunner

import knitlab as kl
from app.cli.main import knitlab

if TYPE_CHECKING:
    from pathlib import Path

PROTOCOL = """
schema: knitlab/protocol@1
name: cell
rig: biaxial-hook
params: {{E: {E}, mu: {mu}, r: {r}, s: 40 MPa}}
materials:
  resin:
    young_modulus: {{value: "${{E}}", source: fitted}}
    poisson_ratio: {{value: 0.37, source: fitted}}
    strength: {{value: "${{s}}", source: fitted}}
specimen:
  knit: {{curvature: 1.5, height: 12.8 mm, depth: 4 mm, row_spacing: 13.76 mm, fibre_radius: "${{r}}"}}
  loops: [1, 1]
  periodic: on
  loop: 16 mm
  nodes_per_loop: 16
  material: resin
  friction: "${{mu}}"
speed_ref: pair
others: hold
max_strain_increment: {increment}
log: {{rate: 5 Hz, noise: on}}
steps:
  - zero: {{channels: [force, displacement]}}
  - cycle: {{axes: [C, W], lower: 0, upper: {upper}, rate: 0.05 mm/s, n: 1}}
"""


def written(path: Path, upper: str, increment: str, *, E: str, mu: str = "0.3", r: str = "0.72 mm") -> Path:
    path.write_text(PROTOCOL.format(E=E, mu=mu, r=r, upper=upper, increment=increment))
    return path


def calibrated(*words: str) -> dict[str, Any]:
    said = CliRunner().invoke(knitlab, ["calibrate", *words, "--json", "--quiet"])
    assert said.exit_code == 0, said.output + repr(said.exception)
    found: dict[str, Any] = json.loads(said.stdout)
    return found


@pytest.mark.slow
def test_a_modulus_comes_back_and_what_has_no_influence_is_named(tmp_path: Path) -> None:
    hidden = written(tmp_path / "hidden.yaml", "20 %", "8 %", E="0.9 GPa")
    log = next(kl.run(hidden, tmp_path / "truth", draw=None).folder.glob("*.csv"))
    guess = written(tmp_path / "guess.yaml", "20 %", "8 %", E="1 GPa")
    # Strength limits nothing unless rupture is asked for.
    words = (str(guess), str(log), "--axis", "C", "--out", str(tmp_path / "fit"), "--fit", "s=20MPa:80MPa")
    found = calibrated(*words, "--fit", "E=0.5GPa:2GPa")
    modulus = found["parameters"]["E"]
    assert modulus["estimate"] == pytest.approx(0.9, rel=0.04)
    assert modulus["low_95"] < modulus["estimate"] < modulus["high_95"]
    assert found["parameters"]["s"]["estimate"] is None
    assert found["parameters"]["s"]["used"] == pytest.approx(40.0)
    assert [line.split(" between")[0] for line in found["not_identifiable"]] == ["s is not seen by the data"]
    assert found["rms"] < found["rms_start"]
    # Nothing is run twice.
    again = calibrated(*words, "--fit", "E=0.5GPa:2GPa")
    assert again["reused"] == again["runs"] == found["runs"]
    assert again["parameters"] == found["parameters"]
    assert (tmp_path / "fit" / "fit.png").stat().st_size > 20_000


@pytest.mark.slow
def test_a_bound_that_is_hit_is_said(tmp_path: Path) -> None:
    hidden = written(tmp_path / "hidden.yaml", "10 %", "4 %", E="0.9 GPa")
    truth = kl.run(hidden, tmp_path / "truth", draw=None).folder
    guess = written(tmp_path / "guess.yaml", "10 %", "4 %", E="1.4 GPa")
    found = kl.calibrate(guess, [truth], ["E=1.1GPa:2GPa"], tmp_path / "fit", alignment=None, axis="C")
    (modulus,) = found.estimates.each
    assert modulus.at_bound == "lower"
    assert "E is at its lower bound, 1.1 GPa" in found.notes[0]


@pytest.mark.parametrize(
    ("fit", "said"),
    [
        (["F"], "a name under params: E, mu, r, s"),
        (["E=2GPa:1GPa"], "E=LOW:HIGH"),
        (["E=500MPa:2000MPa"], "bounds in the unit of the protocol's value: GPa"),
        (["E", "E"], "each parameter once"),
        ([], "1 to 12"),
    ],
)
def test_a_mistake_is_one_line(tmp_path: Path, fit: list[str], said: str) -> None:
    guess = written(tmp_path / "guess.yaml", "10 %", "4 %", E="1.4 GPa")
    with pytest.raises(kl.SpecificationError) as error:
        kl.calibrate(guess, [tmp_path / "none.csv"], fit, tmp_path / "fit")
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.slow
def test_modulus_friction_and_a_length_come_back_within_two_percent(tmp_path: Path) -> None:
    hidden = written(tmp_path / "hidden.yaml", "42 %", "2 %", E="0.9 GPa")
    log = next(kl.run(hidden, tmp_path / "truth", draw=None).folder.glob("*.csv"))
    guess = written(tmp_path / "guess.yaml", "42 %", "2 %", E="1.1 GPa", mu="0.25", r="0.75 mm")
    fit = ("--fit", "E=0.5GPa:2GPa", "--fit", "mu=0.1:0.6", "--fit", "r=0.65mm:0.85mm")
    found = calibrated(str(guess), str(log), *fit, "--out", str(tmp_path / "fit"))
    for name, truth in (("E", 0.9), ("mu", 0.3), ("r", 0.72)):
        assert found["parameters"][name]["estimate"] == pytest.approx(truth, rel=0.02)
    assert not found["not_identifiable"]


@pytest.mark.slow
def test_an_interrupted_calibration_in_two_processes_goes_on_to_the_same_values(tmp_path: Path) -> None:
    hidden = written(tmp_path / "hidden.yaml", "20 %", "4 %", E="0.9 GPa", mu="0.25")
    log = next(kl.run(hidden, tmp_path / "truth", draw=None).folder.glob("*.csv"))
    guess = written(tmp_path / "guess.yaml", "20 %", "4 %", E="1.2 GPa")
    words = (str(guess), str(log), "--axis", "C", "--fit", "E=0.5GPa:2GPa", "--fit", "mu=0.1:0.6", "--jobs", "2")
    whole = calibrated(*words, "--out", str(tmp_path / "whole"))
    out = tmp_path / "cut"
    program = [
        sys.executable,
        "-c",
        "from app.cli.main import main; main()",
        "calibrate",
        *words,
        "--out",
        str(out),
        "--quiet",
    ]
    with subprocess.Popen(program, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:  # noqa: S603
        for _ in range(1200):
            if len(list(out.glob("runs/*/run.h5"))) >= 3 or process.poll() is not None:
                break
            time.sleep(0.1)
        # As Ctrl-C in a terminal does: to the command and to its processes.
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate(timeout=120)[1]
    assert process.returncode == 130, said
    assert said.splitlines()[-1].endswith(f"interrupted; the same command goes on with the runs in {out}")
    begun = len(list(out.glob("runs/*/run.h5")))
    assert 3 <= begun < whole["runs"]
    again = calibrated(*words, "--out", str(out))
    assert again["parameters"] == whole["parameters"]
    assert again["runs"] == whole["runs"]
    assert 1 <= again["reused"] <= begun
