"""The study of the master curve: its designs, and what they say of the paper's claims."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from typer.testing import CliRunner

from app.cli.main import knitlab
from app.schemas import from_yaml, to_yaml
from app.studies.master_curve import RANGES, planned

if TYPE_CHECKING:
    from pathlib import Path


def test_a_design_can_be_knitted_and_its_protocol_written() -> None:
    (one,) = planned(1)
    assert from_yaml(to_yaml(one.protocol)) == one.protocol
    low, high = RANGES["E"]
    assert low <= one.values["E"] <= high
    assert one.values["w"] > one.values["h"]
    assert one.values["n"] in {1.0, 2.0, 3.0, 4.0}
    assert one.protocol.specimen.periodic


def test_too_few_designs_are_refused(tmp_path: Path) -> None:
    said = CliRunner().invoke(knitlab, ["master-curve", "--points", "5", "--out", str(tmp_path)])
    assert said.exit_code != 0
    assert "--points" in str(said.exception) + said.output


@pytest.mark.slow
def test_stress_goes_like_the_modulus_and_not_like_its_square(tmp_path: Path) -> None:
    runner = CliRunner()
    said = runner.invoke(knitlab, ["master-curve", "--points", "32", "--out", str(tmp_path), "--json", "--quiet"])
    assert said.exit_code == 0, said.output
    found = json.loads(said.stdout)
    for axis in ("C", "W"):
        law = found["laws"][axis]
        modulus = law["exponents"]["E"]
        assert abs(modulus["value"] - 1.0) < modulus["half_width_95"] < 2.0 - modulus["value"]
        assert law["p_value"] < 0.01
    spread = {one["scaling"]: one["spread"] for one in found["collapses"]}
    bending = spread["t L l w stress / (E I) over the same"]
    assert bending < spread["xi stress (the paper) over the same"]
    assert (tmp_path / "master_curve.png").stat().st_size > 20_000
    # Nothing is run twice.
    again = runner.invoke(knitlab, ["master-curve", "--points", "32", "--out", str(tmp_path), "--json", "--quiet"])
    assert json.loads(again.stdout)["laws"] == found["laws"]
