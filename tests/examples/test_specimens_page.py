"""Hold the page of specimens to what the program makes of its snippets."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from app.schemas import from_yaml
from rigs.protocol.made_specimen import make_specimen

PAGE = (Path(__file__).parents[2] / "docs" / "specimens.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
TEST = """schema: knitlab/protocol@1
name: snippet
rig: biaxial-hook
speed_ref: pair
others: hold
log: {rate: 10 Hz, noise: off}
steps:
  - ramp: {axes: [C, W], to: {strain: 1 %}, rate: 0.2 mm/s}
"""
ROWS = [line for line in PAGE.splitlines() if line.count("|") == 6][2:]
VOLUMETRIC = TEST.replace("biaxial-hook", "uniaxial-frame\nmount: C").replace("[C, W]", "[C]").replace("hold", "free")


@pytest.mark.parametrize(("snippet", "row"), list(zip(SNIPPETS, ROWS[: len(SNIPPETS)], strict=True)))
def test_the_page_says_what_a_specimen_is(snippet: str, row: str) -> None:
    protocol = from_yaml((VOLUMETRIC if "volumetric" in snippet else TEST) + snippet)
    specimen = make_specimen(protocol.specimen)
    facts = [cell.split()[0] for cell in row.split("|")[2:5]]
    assert facts == [f"{specimen.yarn_length:.4g}", str(len(specimen.nodes)), f"{1e3 * specimen.clearance:.4g}"]
