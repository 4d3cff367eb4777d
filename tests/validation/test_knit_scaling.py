"""Scaling of a whole knit with modulus and size: what dimensional analysis says, friction included."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest

from knitlab_core.equilibrium.newton import Options
from tests.validation.knit import LOOP_WIDTH, YOUNG_MODULUS, FloatArray, make_knit, pull

if TYPE_CHECKING:
    from collections.abc import Callable

# Two runs agree only as well as each is solved.
TIGHT = Options(tolerance=1e-8)


class Pulled(NamedTuple):
    """Course and wale forces (k, 2) [N] on the way to 30 % and back to 20 %; width and thickness of the knit [m]."""

    force: FloatArray
    width: float
    thickness: float


def _pulled(young_modulus: float = YOUNG_MODULUS, size: float = 1.0) -> Pulled:
    knit = make_knit(2, young_modulus=young_modulus, loop_width=size * LOOP_WIDTH)
    rows, _ = pull(knit, [0.3, 0.2], steps=20, options=TIGHT)
    extent = np.ptp(knit.specimen.nodes, axis=0) + 2.0 * knit.specimen.radius
    return Pulled(np.array([row.force for row in rows[1:]]), float(extent[0]), float(extent[2]))


def test_forces_double_with_the_modulus(bar: Callable[..., None]) -> None:
    one, two = _pulled(), _pulled(young_modulus=2.0 * YOUNG_MODULUS)
    bar("E doubled: force / 2", np.abs(two.force / (2.0 * one.force) - 1.0).max(), 1e-6, "1", "physics.md §6")


@pytest.mark.parametrize("s", [50e-6 / LOOP_WIDTH, 7.0])
def test_forces_follow_the_size(bar: Callable[..., None], s: float) -> None:
    one, scaled = _pulled(), _pulled(size=s)
    per_width = (scaled.force / scaled.width) / (one.force / one.width)
    bar(f"size x {s:g}: force per width / s", np.abs(per_width / s - 1.0).max(), 1e-6, "1", "physics.md §6")
    # A volumetric knit's stress is force per width and thickness, and the thickness scales too.
    stress = per_width / (scaled.thickness / one.thickness)
    bar(f"size x {s:g}: force per area", np.abs(stress - 1.0).max(), 1e-6, "1", "physics.md §6")
