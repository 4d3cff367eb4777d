"""Mount small knits on the rigs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from app.schemas.machine_data import machines_of
from rigs.machines.mounting import mount
from rigs.protocol.made_specimen import make_specimen
from rigs.protocol.protocol import Extensometer, LogSpec, Protocol, SpecimenSpec, Step

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from knitlab_core.equilibrium.model import State
    from rigs.axes import Axis
    from rigs.machines.machine import MachineData
    from rigs.machines.rig import Rig
    from rigs.protocol.catalogue import Grips, Hook, Others

    Mounted = tuple[Rig, State, Protocol]


@pytest.fixture(scope="session")
def mount_knit() -> Callable[..., Mounted]:
    """Return a function that mounts the knit of a protocol made of the given steps."""

    def put(
        *steps: Step,
        rows: int = 2,
        loops: int = 2,
        increment: float = 0.02,
        friction: float = 0.3,
        data: MachineData | None = None,
        mount_along: Axis | None = None,
        layers: int | None = None,
        others: Others = "hold",
        noise: bool = False,
        seed: int = 0,
        nodes: int = 24,
        hook: Hook = "pin",
        grips: Grips | Mapping[Axis, Grips] = "hooks",
        pole_friction: float | None = None,
        extensometer: Extensometer | None = None,
        **specimen: Any,  # noqa: ANN401 (handed through)
    ) -> Mounted:
        usual = {
            "knit": "stockinette-default" if layers is None else "volumetric-default",
            "loop_width": 8e-3,
            "nodes_per_loop": nodes,
            "material": "RGD8530-DM",
        }
        spec = SpecimenSpec(
            rows=rows, loops=loops, layers=1 if layers is None else layers, friction=friction, **{**usual, **specimen}
        )
        protocol = Protocol(
            specimen=spec,
            speed_ref="pair",
            rig="biaxial-hook" if mount_along is None else "uniaxial-frame",
            mount=mount_along,
            others=others if mount_along is None else "free",
            steps=steps,
            hook=hook,
            grips=grips,
            pole_friction=pole_friction,
            extensometer=extensometer,
            log=LogSpec(noise=noise, seed=seed),
            max_strain_increment=increment,
        )
        machines = machines_of(protocol)
        if data is not None:
            machines = dict.fromkeys(machines, data)
        rig, state = mount(make_specimen(spec), protocol, machines)
        return rig, state, protocol

    return put
