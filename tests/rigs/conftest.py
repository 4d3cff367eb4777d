"""Mount small knits on the biaxial stage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.check import stitch_of
from app.rig_data import read_biaxial_data
from knitlab_core.knits import planar_specimen
from rigs.biaxial import mount
from rigs.protocol import LogSpec, Protocol, SpecimenSpec, Step

if TYPE_CHECKING:
    from collections.abc import Callable

    from knitlab_core.equilibrium.model import State
    from rigs.biaxial import BiaxialStage
    from rigs.biaxial_data import BiaxialData

    Mounted = tuple[BiaxialStage, State, Protocol]


@pytest.fixture
def quick_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Paint with lines: VTK takes many seconds where no graphics card helps it."""
    monkeypatch.setattr("app.pictures.vtk_images", lambda *_, **__: "quick")


@pytest.fixture(scope="session")
def mount_knit() -> Callable[..., Mounted]:
    """Return a function that mounts the knit of a protocol made of the given steps."""

    def put(
        *steps: Step,
        rows: int = 2,
        loops: int = 2,
        increment: float = 0.02,
        friction: float = 0.3,
        data: BiaxialData | None = None,
    ) -> Mounted:
        spec = SpecimenSpec(
            knit="stockinette-default",
            rows=rows,
            loops=loops,
            loop_width=8e-3,
            material="RGD8530-DM",
            friction=friction,
            nodes_per_loop=24,
        )
        protocol = Protocol(
            specimen=spec,
            speed_ref="pair",
            others="hold",
            steps=steps,
            log=LogSpec(noise=False),
            max_strain_increment=increment,
        )
        specimen = planar_specimen(
            stitch_of(spec), rows=rows, loops=loops, loop_width=spec.loop_width, nodes_per_loop=spec.nodes_per_loop
        )
        stage, state = mount(specimen, protocol, read_biaxial_data() if data is None else data)
        return stage, state, protocol

    return put
