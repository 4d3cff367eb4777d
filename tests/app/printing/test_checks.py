from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
import trimesh

from app.printing.checks import Check, printer_checks, surface_checks
from app.printing.fibres import Fibre, make_fibres, specimen_fibres
from app.printing.gap import mesh_gap
from app.printing.printers import printer_names, read_printer_data
from knitlab_core.errors import FormatError, SpecificationError
from knitlab_core.knits import NAMED_STITCHES, knit_specimen

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from rigs.axes import FloatArray
    from rigs.machines.printer import PrinterData

ERROR = 0.01


@pytest.fixture(scope="module")
def printer() -> PrinterData:
    return read_printer_data("j35")


def line(start: tuple[float, float, float], end: tuple[float, float, float]) -> FloatArray:
    return np.linspace(start, end, 40)


def one() -> Fibre:
    (fibre,) = make_fibres([line((0, 0, 0), (10, 0, 0))], 0.4, ERROR)
    return fibre


def damaged(vertices: FloatArray | None = None, faces: NDArray[np.int64] | None = None) -> Fibre:
    whole = one()
    mesh = trimesh.Trimesh(
        whole.mesh.vertices if vertices is None else vertices,
        whole.mesh.faces if faces is None else faces,
        process=False,
    )
    return replace(whole, mesh=mesh)


def failed(checks: list[Check]) -> dict[str, float]:
    return {check.name: check.found for check in checks if not check.met}


def crossing(gap: float, radius: float = 0.4) -> tuple[Fibre, ...]:
    height = 2.0 * radius + gap
    return make_fibres([line((-5, 0, 0), (5, 0, 0)), line((0, -5, height), (0, 5, height))], radius, ERROR)


def test_a_whole_tube_passes(printer: PrinterData) -> None:
    checks = surface_checks([one()], ERROR) + printer_checks([one()], printer, None)
    assert failed(checks) == {}
    assert len(checks) == 8


def test_a_tube_with_a_hole_is_refused() -> None:
    found = failed(surface_checks([damaged(faces=np.delete(one().mesh.faces, 50, axis=0))], ERROR))
    # A triangle that is missing leaves three edges open and takes one from the characteristic.
    assert found["edges not of two faces"] == 3
    assert found["Euler characteristic"] == 1


def test_a_turned_triangle_is_refused() -> None:
    faces = one().mesh.faces.copy()
    faces[50] = faces[50, ::-1]
    assert failed(surface_checks([damaged(faces=faces)], ERROR)) == {"edges of turned faces": 3}


def test_a_surface_that_is_inside_out_is_refused() -> None:
    found = failed(surface_checks([damaged(faces=one().mesh.faces[:, ::-1])], ERROR))
    assert found == {"volume / (π r² L)": pytest.approx(-1.0, abs=0.05)}


def test_a_fin_is_no_manifold() -> None:
    mesh = one().mesh
    top = len(mesh.vertices)
    vertices = np.concatenate([mesh.vertices, [[5.0, 0.0, 5.0]]])
    faces = np.concatenate([mesh.faces, [[*mesh.faces[50, :2], top]]])
    # One edge with three faces, two with one.
    assert failed(surface_checks([damaged(vertices, faces)], ERROR))["edges not of two faces"] == 3


def test_a_fibre_in_two_pieces_is_refused() -> None:
    mesh = one().mesh
    vertices = np.concatenate([mesh.vertices, np.asarray(mesh.vertices) + np.array([0.0, 5.0, 0.0])])
    faces = np.concatenate([mesh.faces, mesh.faces + len(mesh.vertices)])
    found = failed(surface_checks([damaged(vertices, faces)], ERROR))
    assert found["pieces of a fibre"] == 2
    assert found["Euler characteristic"] == 4
    assert found["volume / (π r² L)"] == pytest.approx(2.0, abs=0.1)


def test_the_worst_of_several_fibres_is_shown() -> None:
    hollow = damaged(faces=np.delete(one().mesh.faces, 50, axis=0))
    assert failed(surface_checks([one(), hollow, one()], ERROR)) == failed(surface_checks([hollow], ERROR))


@pytest.mark.parametrize("gap", [1.0, 0.21, 0.05])
def test_the_gap_of_crossed_tubes_is_their_distance_less_a_diameter(gap: float) -> None:
    assert mesh_gap(crossing(gap)) == pytest.approx(gap, abs=2.0 * ERROR)
    assert mesh_gap(crossing(gap)) > gap - 1e-9


@pytest.mark.parametrize("gap", [-0.05, -0.3, -0.7])
def test_overlapping_loops_are_refused(gap: float, printer: PrinterData) -> None:
    found = failed(printer_checks(crossing(gap), printer, gap))
    assert set(found) == {"gap by the centreline", "gap by the mesh"}
    assert found["gap by the mesh"] < 0.0


def test_loops_too_close_for_the_printer_are_refused(printer: PrinterData) -> None:
    assert set(failed(printer_checks(crossing(0.1), printer, 0.1))) == {"gap by the centreline", "gap by the mesh"}


def test_a_fibre_too_thin_for_the_printer_is_refused(printer: PrinterData) -> None:
    thin = make_fibres([line((0, 0, 0), (10, 0, 0))], 0.1, ERROR)
    assert failed(printer_checks(thin, printer, None)) == {"fibre diameter": 0.2}


def test_a_bend_tighter_than_the_fibre_is_refused(printer: PrinterData) -> None:
    angle = np.linspace(0.0, math.pi, 40)
    hook = 0.3 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    found = failed(printer_checks(make_fibres([hook], 0.4, ERROR), printer, None))
    assert found["radius of tightest bend"] == pytest.approx(0.3)


def test_a_single_straight_fibre_meets_nothing() -> None:
    assert mesh_gap([one()]) == math.inf


def test_parallel_tubes_and_a_far_pair() -> None:
    for distance in (1.0, 30.0):
        pair = make_fibres([line((0, 0, 0), (9, 0, 0)), line((0, distance, 0), (9, distance, 0))], 0.4, ERROR)
        assert mesh_gap(pair) == pytest.approx(distance - 0.8, abs=2.0 * ERROR)


def test_a_hook_that_comes_back_to_itself() -> None:
    angle = np.linspace(0.0, math.pi, 60)
    bow = np.stack([2.0 * np.sin(angle), 2.0 * np.cos(angle), 0.0 * angle], axis=-1)
    leg = np.linspace(5.0, 0.1, 40)[:, None] * [-1.0, 0.0, 0.0]
    hook = np.concatenate([leg + bow[0], bow, leg[::-1] + bow[-1]])
    assert mesh_gap(make_fibres([hook], 0.4, ERROR)) == pytest.approx(4.0 - 0.8, abs=2.0 * ERROR)


@pytest.mark.parametrize(("name", "loop_width"), [("stockinette-default", 8e-3), ("paper-fit", 50e-6)])
def test_the_gap_of_a_knits_mesh_is_the_centrelines(name: str, loop_width: float) -> None:
    specimen = knit_specimen(NAMED_STITCHES[name], rows=3, loops=3, loop_width=loop_width)
    error = 2e-3 * loop_width
    found = 1e-3 * mesh_gap(specimen_fibres(specimen, error))
    # Each mesh lies up to the chord error inside its tube or half of it outside; corners need not face each other.
    assert specimen.clearance - error <= found <= specimen.clearance + 3.0 * error


def test_a_figure_that_is_no_number_is_not_met() -> None:
    assert not Check(name="x", found=math.nan).met
    assert Check(name="x", found=1.0, least=1.0, most=1.0).met


def test_printers_come_with_sources() -> None:
    assert printer_names() == ("j35", "nanoscribe")
    for name in printer_names():
        data = read_printer_data(name)
        for datum in (data.layer_height, data.resolution, data.smallest_feature, data.clearance):
            assert datum.unit == "m"
            assert datum.source
    assert read_printer_data("nanoscribe").layer_height.value == 0.2e-6
    assert read_printer_data("j35").smallest_feature.value == 0.212e-3


def test_a_printer_of_ones_own(tmp_path: Path) -> None:
    from importlib.resources import files  # noqa: PLC0415 (one test's)

    text = (files("rigs") / "data" / "printers" / "j35.yaml").read_text(encoding="utf-8")
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace("Stratasys J35 (PolyJet)", "mine"), encoding="utf-8")
    assert read_printer_data(str(path)).printer == "mine"
    path.write_text(text.replace("value: 1.875e-5", "value: 0.0"), encoding="utf-8")
    with pytest.raises(SpecificationError, match=r"layer_height: found 0\.0, allowed a length above 0 m"):
        read_printer_data(str(path))
    path.write_text(text.replace("unit: m", "unit: mm", 1), encoding="utf-8")
    with pytest.raises(SpecificationError, match=r"layer_height\.unit: found 'mm', allowed m"):
        read_printer_data(str(path))
    path.write_text(text.replace("clearance:", "clear:"), encoding="utf-8")
    with pytest.raises(FormatError, match=r"mine\.yaml:24"):
        read_printer_data(str(path))
    for unknown in ("j36", str(tmp_path / "none.yaml")):
        with pytest.raises(SpecificationError, match="allowed j35, nanoscribe, or the path"):
            read_printer_data(unknown)
