"""Signals have the bits that SciPy's interpolation and filter would give them; SciPy takes too long to import."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.signal import lfilter

from rigs.instruments.pchip import Pchip
from rigs.instruments.signals import Lag


@pytest.mark.parametrize("count", [2, 3, 4, 7, 60])
def test_a_curve_has_the_bits_of_scipys(count: int) -> None:
    chance = np.random.default_rng(count)
    for scale in (1e-6, 1.0, 1e6):
        x = np.cumsum(chance.uniform(1e-3, 1.0, count))
        at = np.concatenate([x, chance.uniform(x[0] - 0.1, x[-1] + 0.1, 50)])
        rough = scale * chance.normal(size=count)
        # Rough, rising, and with flats.
        for y in (rough, np.cumsum(np.abs(rough)), np.round(rough / scale)):
            curve, theirs = Pchip.through(x, y), PchipInterpolator(x, y)
            assert curve(at).tolist() == theirs(at).tolist()
            assert curve.integral() == theirs.integrate(x[0], x[-1])
        several = chance.normal(size=(count, 3))
        assert Pchip.through(x, several)(at).tolist() == PchipInterpolator(x, several)(at).tolist()


def test_a_lag_has_the_bits_of_a_filter_and_goes_on_from_part_to_part() -> None:
    chance = np.random.default_rng(3)
    signal, lag = chance.normal(size=500), Lag(time_constant=0.3)
    parts = [lag(part, 0.1, 0.1) for part in np.split(signal, [1, 2, 120])]
    decay = float(np.exp(-0.1 / 0.3))
    share = float(-np.expm1(-0.1 / 0.3) / (0.1 / 0.3))
    settled = np.array([signal[0] * share])
    theirs, _ = lfilter([1.0 - share, share - decay], [1.0, -decay], signal, zi=settled)
    assert np.concatenate(parts).tolist() == theirs.tolist()
    assert parts[0][0] == pytest.approx(signal[0])
