"""Prove the frame with what is known beforehand: a straight filament has the modulus of its material."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from app.schemas import ProtocolError, from_yaml, to_yaml
from app.schemas.machine_data import machines_of
from rigs.analysis.stress_strain import stress_strain
from rigs.control.experiment import perform
from rigs.instruments.channels import measure
from rigs.instruments.zeros import Zeroing
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.record import Equilibrium
from rigs.trace import trace_of

if TYPE_CHECKING:
    from collections.abc import Callable

TEXT = (Path(__file__).parents[2] / "examples" / "filament.yaml").read_text(encoding="utf-8")


def modulus(text: str) -> float:
    """Return the slope of what the frame logs, over the material's modulus."""
    protocol = from_yaml(text)
    rig, state = mount(make_specimen(protocol.specimen), protocol, machines_of(protocol))
    events = list(perform(rig, state, protocol))
    rows = [event for event in events if isinstance(event, Equilibrium)]
    zeroings = [event for event in events if isinstance(event, Zeroing)]
    log = protocol.log
    (instrument,) = rig.instruments
    samples = measure(instrument, trace_of(rows), seed=log.seed, noise=log.noise, zeroings=zeroings)
    travel, force = samples.measured["Displacement"], samples.measured["Force"]
    strain, stress = stress_strain(travel, force, "C", rig.size)
    return float(np.polyfit(strain, stress, 1)[0]) / protocol.specimen.solid.young_modulus.value


@pytest.mark.parametrize("force_controlled", [False, True])
def test_a_filament_measures_its_own_modulus(bar: Callable[..., None], *, force_controlled: bool) -> None:
    text = TEXT.replace("noise: on", "noise: off")
    if force_controlled:
        text = text.replace("{strain: 0.4 %}, rate: 0.02 mm/s", "{force: 2 N}, rate: 0.2 N/s")
    error = modulus(text) - 1.0
    how = "force" if force_controlled else "displacement"
    bar(f"filament on the frame, {how} control", error, 1e-3, "1", "Hooke: E of its own material")


def test_with_noise_it_does_so_within_the_accuracy_of_the_load_cell(bar: Callable[..., None]) -> None:
    accuracy = machines_of(from_yaml(TEXT))["uniaxial-frame"].load_cell.accuracy
    assert accuracy is not None
    bar("filament on the frame, with noise", modulus(TEXT) - 1.0, accuracy.value, "1", "ISO 7500-1 class 0.5")


def test_a_filament_is_its_diameter_and_its_length() -> None:
    protocol = from_yaml(TEXT)
    specimen = make_specimen(protocol.specimen)
    assert specimen.nodes[-1] - specimen.nodes[0] == pytest.approx([50e-3, 0.0, 0.0])
    assert specimen.radius == pytest.approx(0.5e-3)
    rig, _ = mount(specimen, protocol, machines_of(protocol))
    assert rig.size.section("C") == pytest.approx(math.pi * 0.25e-6)
    assert from_yaml(to_yaml(protocol)) == protocol


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[1, 1]", "[2, 1]", "8:10: specimen.loops: found a list, allowed [1, 1]: a filament is no knit"),
        ("1 mm}", "1 s}", "7:20: specimen.knit.filament: found '1 s', allowed a number of loop widths, or a length"),
        ("1 mm}", "20 mm}", "7:20: specimen.knit.filament: found 0.4 of its length, allowed a diameter above 0"),
        (
            "{filament: 1 mm}",
            "{filament: 1 mm, depth: 2}",
            "specimen.knit.depth: found an unknown field, allowed filament",
        ),
        ("mount: C", "mount: W", "5:8: mount: found W, allowed C: the axis along the frame"),
    ],
)
def test_a_filament_that_cannot_be_is_one_line(old: str, new: str, says: str) -> None:
    with pytest.raises(ProtocolError) as raised:
        from_yaml(TEXT.replace(old, new))
    assert says in str(raised.value)
