"""Bluesky plans drive a rig; what they need of its devices is also tested without Bluesky."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

import knitlab as kl
from tests.app.live.test_rig import HEAD

if TYPE_CHECKING:
    from pathlib import Path


def test_an_axis_moves_and_cells_read_in_si(tmp_path: Path) -> None:
    with kl.Rig(HEAD, tmp_path / "live", draw=None) as rig:
        devices = kl.devices_of(rig, rate=2e-4)
        told: list[object] = []
        status = devices.axes["C"].set(2e-4)
        status.add_callback(told.append)
        assert status.exception(120.0) is None
        assert (status.done, status.success) == (True, True)
        assert devices.axes["C"].locate() == {"setpoint": 2e-4, "readback": pytest.approx(2e-4)}
        assert devices.axes["C"].read()["strain_C"]["value"] == pytest.approx(2e-4 / 16e-3)
        assert devices.cells.read()["force_W"]["value"] == rig.read().force["W"]
        units = {name: one["units"] for name, one in devices.cells.describe().items()}
        assert units == {"force_C": "N", "force_W": "N"}
        failed = devices.axes["W"].set(1.0)
        assert "travel: axis W would go 1000 mm" in str(failed.exception(120.0))
        assert not failed.success
    assert told == [status]


def test_an_unmodified_plan_scans_an_axis_with_live_documents(tmp_path: Path) -> None:
    engine = pytest.importorskip("bluesky.run_engine")
    plans = pytest.importorskip("bluesky.plans")
    protocols = pytest.importorskip("bluesky.protocols")
    documents: list[tuple[str, dict[str, Any]]] = []
    run = engine.RunEngine({}, call_returns_result=False)
    head = replace(HEAD, log=kl.LogSpec(noise=False))
    with kl.Rig(head, tmp_path / "live", draw=None) as rig:
        devices = kl.devices_of(rig, rate=2e-4)
        course, cells = devices.axes["C"], devices.cells
        for protocol in (protocols.Movable, protocols.Locatable, protocols.Stoppable, protocols.Readable):
            assert isinstance(course, protocol)
        run(plans.scan([cells], course, 0.0, 4e-4, 3), lambda name, document: documents.append((name, document)))
        run(plans.count([cells], num=2), lambda name, document: documents.append((name, document)))
        with pytest.raises(Exception, match="travel: axis C would go 1000 mm"):
            run(plans.scan([cells], course, 1.0, 2.0, 2))
    names = [name for name, _ in documents]
    assert names == ["start", "descriptor", *["event"] * 3, "stop", "start", "descriptor", *["event"] * 2, "stop"]
    keys = documents[1][1]["data_keys"]
    assert {name: key["units"] for name, key in keys.items()} == {
        "C": "m",
        "strain_C": "1",
        "force_C": "N",
        "force_W": "N",
    }
    events = [document["data"] for name, document in documents[:6] if name == "event"]
    assert [event["C"] for event in events] == pytest.approx([0.0, 2e-4, 4e-4])
    assert events[0]["force_C"] < events[1]["force_C"] < events[2]["force_C"]
    assert [step.end for step in rig.result.steps] == ["target"] * 3
