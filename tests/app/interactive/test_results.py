from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import knitlab as kl
from app.interactive.scene import SIDES, mesh_of
from app.views.progress_bar import bar_for
from app.views.tubes import tube

if TYPE_CHECKING:
    from pathlib import Path

    from IPython.display import HTML

PROTOCOL: dict[str, Any] = {
    "schema": "knitlab/protocol@1",
    "rig": "biaxial-hook",
    "specimen": {
        "knit": "stockinette-default",
        "loops": (2, 2),
        "loop": "8 mm",
        "material": "RGD8530-DM",
        "friction": np.float64(0.3),
        "nodes_per_loop": 24,
    },
    "others": "hold",
    "steps": [{"cycle": {"axes": ["C", "W"], "lower": 0, "upper": "5 %", "rate": "0.2 mm/s", "n": 1}}],
}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> kl.Run:
    return kl.run(PROTOCOL, tmp_path_factory.mktemp("data") / "<b>bold", draw=None)


def test_its_table_has_every_equilibrium_of_every_axis(run: kl.Run) -> None:
    table = run.table
    course = table[table["axis"] == "C"]
    assert len(course) == len(run.record.trace)
    np.testing.assert_allclose(course["force [N]"], run.record.force("C"), rtol=1e-12)
    assert set(run.cycles["axis"]) >= {"C", "W"}
    assert "external work" in " ".join(run.analyse("energy").columns)


def test_without_pandas_a_table_is_arrays(run: kl.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.interactive.results.find_spec", lambda _: None)
    table = kl.show(run.folder).table
    assert isinstance(table["strain [1]"], np.ndarray)


def test_a_notebook_shows_its_curves_and_escapes_what_a_user_wrote(run: kl.Run) -> None:
    shown = run._repr_html_()
    assert "data:image/png;base64," in shown
    assert "loop area" in shown
    assert "<b>bold" not in shown
    assert repr(kl.show(run.folder)) == repr(run)


def test_the_knit_is_the_stored_shape_nearest_on_the_way_up(run: kl.Run, tmp_path: Path) -> None:
    frames = run.record.frames()
    scene = run.knit(at=0.0)
    scene.save(tmp_path / "knit.html")
    assert "http" not in (tmp_path / "knit.html").read_text(encoding="utf-8").split("<script")[0]
    mesh = scene.figure.data[0]
    assert np.ptp(mesh.x) == pytest.approx(1e3 * np.ptp(frames[0].nodes[:, 0]), rel=0.2)
    assert "C 5.0 %" in run.knit().figure.layout.title.text


def test_without_plotly_it_says_what_to_install(run: kl.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "plotly", None)
    with pytest.raises(kl.SpecificationError, match=r"knitlab\[notebook\]"):
        run.knit()


def test_a_tube_is_as_thick_as_the_fibre_and_closed_around_it() -> None:
    line = np.stack([np.linspace(0.0, 1.0, 9), np.zeros(9), np.zeros(9)], axis=1)
    drawn = tube(line, np.zeros(8), 0.1, 2)
    corners, faces = mesh_of(drawn)
    np.testing.assert_allclose(np.hypot(corners[:, 1], corners[:, 2]), 100.0, rtol=1e-12)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, times = np.unique(edges, axis=0, return_counts=True)
    assert np.count_nonzero(times == 1) == 2 * SIDES, "open at its two ends alone"


def test_a_protocol_may_be_text_and_mistakes_in_data_are_named() -> None:
    text = kl.to_yaml(kl.load(PROTOCOL).protocol)
    assert kl.load(text).protocol == kl.load(PROTOCOL).protocol
    with pytest.raises(kl.SpecificationError, match=r"specimen\.loops\[0\].*type object"):
        kl.check({**PROTOCOL, "specimen": {**PROTOCOL["specimen"], "loops": [object(), 2]}})
    with pytest.raises(kl.ProtocolError, match=r"rig: found 'hook'"):
        kl.check({**PROTOCOL, "rig": "hook"})


def test_in_a_notebook_the_bar_replaces_its_output(monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []

    class Handle:
        def update(self, shown: HTML) -> None:
            written.append(str(shown.data))

    def display(shown: HTML, **_: object) -> Handle:
        written.append(str(shown.data))
        return Handle()

    monkeypatch.setitem(sys.modules, "ipykernel", sys)
    monkeypatch.setattr("IPython.display.display", display)
    with bar_for(wanted=True) as bar:
        bar.show(0.5, "C < 5 %")
    assert "50 %" in written[0]
    assert "C &lt; 5 %" in written[0]
    assert "done in" in written[1]
