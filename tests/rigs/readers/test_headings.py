from __future__ import annotations

import pytest

from rigs.readers.headings import factor_to_si, meaning, unit_below

KNOWN = [
    ("Time", "time", "", ""),
    ("Time (s)", "time", "", "s"),
    ("Prüfzeit [s]", "time", "", "s"),
    ("Zeit / s", "time", "", "s"),
    ("Extension", "travel", "", ""),
    ("Tensile extension (mm)", "travel", "", "mm"),
    ("Standardweg [mm]", "travel", "", "mm"),
    ("XDisplacement_um", "travel", "C", "um"),
    ("YSize_um", "distance", "W", "um"),
    ("clamp_distance_mm", "distance", "", "mm"),
    ("width_at_middle_mm", "width", "", "mm"),
    ("Load", "force", "", ""),
    ("Standardkraft in N", "force", "", "N"),
    ("YForce_mN", "force", "W", "mN"),
    ("Force P [µN]", "force", "P", "µN"),
    ("uniaxial-frame.Force", "force", "P", ""),
    ("Corrected Load", "force", "P", ""),
    ("Tensile strain (Strain 1)", "strain", "", ""),
    ("Dehnung [%]", "strain", "", "%"),
    ("Tensile stress (MPa)", "stress", "", "MPa"),
    ("Total Cycle Count", "cycle", "", ""),
    ("Segment ID", "segment", "", ""),
    ("repeat", "repeat", "", ""),
    ("Maximum Load", "other", "", ""),
    ("Tensile stress at Maximum Load", "other", "", ""),
    ("Raw Load", "other", "", ""),
    ("biaxial-hook.Time", "other", "", ""),
    ("Temperature", "other", "", ""),
    ("frame", "other", "", ""),
]


@pytest.mark.parametrize(("text", "quantity", "axis", "unit"), KNOWN)
def test_headings_of_instruments_are_known(text: str, quantity: str, axis: str, unit: str) -> None:
    found = meaning(text)
    assert (found.quantity, found.axis, found.unit) == (quantity, axis, unit)


def test_units_are_those_of_their_quantity() -> None:
    assert factor_to_si("force", "kN") == pytest.approx(1e3)
    assert factor_to_si("force", "lbf") == pytest.approx(4.4482216)
    assert factor_to_si("stress", "N/mm²") == 1e6
    assert factor_to_si("time", "S") == 1.0
    assert factor_to_si("force", "mm") is None
    assert factor_to_si("cycle", "") == 1.0


def test_units_stand_below_in_brackets_or_bare() -> None:
    assert [unit_below(text) for text in ("(mm)", "[N]", "s", "", "( % )")] == ["mm", "N", "s", "", "%"]
    assert unit_below("no unit at all") is None
