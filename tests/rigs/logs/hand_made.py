"""Hold a test that no rig did: a few samples of every machine, written by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigs.instruments.samples import Samples
from rigs.logs.logged import Logged
from rigs.record import SpecimenSize

if TYPE_CHECKING:
    from rigs.record import Phase

SIZE = SpecimenSize(extents={"C": 45e-3, "W": 40e-3, "P": 1e-3}, fibre_radius=0.4e-3)


def samples(machine: str, phases: tuple[Phase, ...], reads: dict[str, str], **measured: list[float]) -> Samples:
    values = {name: np.array(column) for name, column in measured.items()}
    time = values.pop("time")
    return Samples(
        instrument=machine,
        time=time,
        measured=values,
        clean=values,
        offset={name: np.zeros(len(time)) for name in values},
        units={},
        reads=reads,
        cycle=np.ones(len(time), dtype=np.int64),
        phase=phases,
        tag=(None,) * len(time),
        overloads=(),
    )


def stage() -> Samples:
    made = samples(
        "biaxial-hook",
        ("Zero", "Stretch", "Hold", "Recover"),
        {},
        time=[0.0, 0.1, 0.2, 0.3],
        XDisplacement=[0.0, 10e-6, 20e-6, 10e-6],
        YDisplacement=[-4e-8, 9e-6, 18e-6, 9e-6],
        XForce=[0.0, 1.5e-3, 3.0, 1e-3],
        YForce=[-1e-7, -2.25e-3, 12.346e-3, 0.0],
    )
    made.cycle[3] = 2
    return replace(made, tag=(None, "equibiaxial", "equibiaxial", "pull, again"))


def frame() -> Samples:
    return samples(
        "uniaxial-frame",
        ("Zero", "Stretch", "Stretch", "Hold", "Recover", "Recover", "Stretch", "Stretch"),
        {"Displacement": "displacement_C", "Force": "force_C"},
        time=[0.0, 0.02, 0.04, 10.0, 10.1, 10.2, 10.3, 1234.5],
        Displacement=[-2.04726e-3, 3.88711e-3, 9e-3, 9e-3, 3e-3, -1e-9, 0.05e-3, 12.5e-3],
        Force=[-4.319, -0.00004, 100.25, 99.0, 1.0, -0.0, 0.5, 1234.56789],
    )


def indenter() -> Samples:
    made = samples(
        "nanoindenter",
        ("Zero", "Zero", "Stretch", "Stretch"),
        {"Displacement": "displacement_P", "Force": "force_P"},
        time=[-6.135, -0.0002, 0.0, 3661.5],
        Displacement=[0.0, -1.5e-12, 655e-9, 1.2345678e-6],
        Force=[-2e-15, 0.0, 1.42e-3, 2.5],
    )
    made.offset["Force"][:] = 1e-3
    return replace(made, delay={"Force": 0.003})


def sheared() -> Samples:
    made = {"CDisplacement": [0.0, 9e-3, 9e-3], "WDisplacement": [0.0, 8e-3, 8e-3], "WCDisplacement": [0.0, 0.0, -6e-3]}
    made |= {"CForce": [0.0, 4e-3, 5.5e-3], "WForce": [-2e-7, 0.0, 45e-3], "WCForce": [0.0, -3e-8, -22.5e-3]}
    axes = ("C", "W", "WC")
    reads = {f"{axis}Displacement": f"crosshead_{axis}" for axis in axes} | {
        f"{axis}Force": f"force_{axis}" for axis in axes
    }
    return samples("shear-stage", ("Zero", "Stretch", "Recover"), reads, time=[0.0, 24.0, 31.25], **made)


def logged(sample: str = "22L.3", **machines: Samples) -> Logged:
    """Return the test of that sample; machines by their names with an underscore replace those above."""
    made = {"biaxial-hook": stage(), "uniaxial-frame": frame(), "nanoindenter": indenter(), "shear-stage": sheared()}
    return Logged(
        sample=sample,
        size=SIZE,
        samples=made | {name.replace("_", "-"): one for name, one in machines.items()},
        facts={
            "started": "2018-11-13T17:14:09+01:00",
            "rig.convention.temperature": 22.0,
            "rig.carriage.compliance": 1e-6,
        },
    )
