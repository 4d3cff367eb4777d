"""The forces of a test as each dialect of a log shows them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from rigs.instruments.channels import Instrument, measure
from rigs.logs.catalogue import LOGS
from rigs.logs.logged import Logged
from rigs.logs.writer import write_log
from tests.synthetic_run import SIZE, stage_instrument

if TYPE_CHECKING:
    from rigs.axes import Axis, FloatArray
    from rigs.trace import Trace

COLUMNS = {
    "biotester": "XForce",
    "triaxial": "biaxial-hook.XForce",
    "bluehill-universal": "Force",
    "shear-stage": "Force {axis}",
}
SUFFIXES = {"m": 1e-3, "u": 1e-6}


def logged_forces(dialect: str, trace: Trace, *, axis: Axis = "C", rate: float = 10.0) -> FloatArray:
    """Return the column of forces of a dialect [N], sampled without noise at a rate [Hz]; its results must agree."""
    log = LOGS[dialect]
    machine = stage_instrument(rate)
    # The stage has the axis of the trace as its X, and as its Y too where that trace has one axis.
    reads = {"C": axis, "W": "W" if "force_W" in trace.columns else axis}
    channels = tuple(
        replace(channel, reads=channel.reads[:-1] + reads[channel.reads[-1]]) for channel in machine.channels
    )
    frame = replace(
        machine,
        name=log.machines[0] if log.machines[0] != "biaxial-hook" else "uniaxial-frame",
        channels=tuple(replace(channel, name=channel.name[1:]) for channel in channels if channel.name.startswith("X")),
    )
    # The clock of the stage is late, so that no sample of the two is at one time.
    stage = replace(machine, channels=channels, offset=0.033, skew=1e-3)
    instruments: list[Instrument] = [stage, frame]
    samples = {one.name: measure(one, trace, seed=0, noise=False) for one in instruments}
    facts = {"started": "2018-11-13T17:14:09+01:00", "rig.convention.temperature": 22.0, "rig.carriage.compliance": 0.0}
    parts, known = log.gather(Logged(sample="s", size=SIZE, samples=samples, facts=facts))
    lines = list(parts)
    if dialect.startswith("alemnis"):
        texts = [str(value) for part in lines for value in part["Raw load"]]
        return np.array(
            [float(text[:-1]) * SUFFIXES[text[-1]] if text[-1] in SUFFIXES else float(text) for text in texts]
        )
    assert b"".join(write_log(log.dialect, lines, known))
    column = COLUMNS.get(dialect, "Load").format(axis=axis)
    force = np.array([float(str(value)) for part in lines for value in part[column]])
    if "Load" in known:
        assert known["Load"] == pytest.approx(force.max(), abs=1e-4)
    return force
