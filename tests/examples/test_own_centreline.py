"""A yarn by its own centreline on the frame: as stiff as a curved rod of its shape."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.records.reader import RunReader
from app.records.results import energy_balance_error
from app.runs.use_cases import run_protocol
from app.schemas import load, loads, to_yaml
from rigs.protocol.steps import Cycle
from tests.examples.test_examples import EXAMPLES, Ran

if TYPE_CHECKING:
    from pathlib import Path

SERPENTINE = EXAMPLES / "serpentine_small.yaml"


def test_a_serpentine_is_as_stiff_as_its_bending_moments_make_it(tmp_path: Path) -> None:
    whole = load(SERPENTINE).protocol
    (cycle,) = (step for step in whole.steps if isinstance(step, Cycle))
    protocol = replace(whole, steps=(whole.steps[0], replace(cycle, upper=0.004)), max_strain_increment=0.004)
    (tmp_path / "small.yaml").write_text(to_yaml(protocol), encoding="utf-8")
    result = run_protocol(tmp_path / "small.yaml", tmp_path / "run", lambda _share, _text: None, draw=None)
    ran = Ran(result, RunReader(result.folder / "run.h5"))
    assert result.outcome == "target"
    assert energy_balance_error(ran.run.trace) <= 0.01
    # Ends that turn freely on the line of the force leave the moment F y: the compliance is the integral of y2 / EI.
    x = np.linspace(0.0, 36e-3, 20_001)
    wave = 2.0 * math.pi / 12e-3
    y, slope = 4e-3 * np.sin(wave * x), 4e-3 * wave * np.cos(wave * x)
    bending = 0.82e9 * math.pi * 0.4e-3**4 / 4.0
    stiffness = bending / np.trapezoid(y**2 * np.hypot(1.0, slope), x)
    assert ran.stress("C", 0.004) * ran.run.size.section("C") == pytest.approx(stiffness * 0.004 * 36e-3, rel=0.02)
    # Across it no hooks hold: its width is that of its yarn, its thickness the agreed one.
    assert ran.run.size.section("C") == pytest.approx(8.8e-3 * 1e-3, rel=1e-2)


def test_a_centreline_may_be_sent_with_the_protocol() -> None:
    text = SERPENTINE.read_text(encoding="utf-8")
    sent = loads(text, files={"serpentine.csv": SERPENTINE.with_name("serpentine.csv").read_text(encoding="utf-8")})
    assert sent.protocol == load(SERPENTINE).protocol
    assert loads(sent.text).protocol == sent.protocol  # its text needs no file
