from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
import trimesh
from matplotlib.image import imread

from app.printing import sheets
from app.printing.fibres import Fibre, make_fibres, specimen_fibres
from app.printing.files import write_surface
from app.printing.sheets import raster, window, write_layer, write_sheet
from app.printing.slices import Slicer, sliced_volume
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, knit_specimen

if TYPE_CHECKING:
    from pathlib import Path

    from rigs.axes import FloatArray


@pytest.fixture(scope="module")
def knit() -> tuple[Fibre, ...]:
    specimen = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=2, loops=2, loop_width=8e-3)
    return specimen_fibres(specimen, 10e-6)


@pytest.fixture(scope="module")
def pair() -> tuple[Fibre, ...]:
    x = np.linspace(0.0, 9.0, 30)
    low = np.stack([x, np.sin(x), 0.0 * x], axis=-1)
    return make_fibres([low, low + np.array([0.0, 0.0, 2.0])], 0.4, 0.01)


def upright(radius: float = 1.0, height: float = 4.0) -> tuple[Fibre, ...]:
    return make_fibres([np.outer(np.linspace(0.0, height, 9), [0.0, 0, 1])], radius, 1e-4)


def bounds(fibres: tuple[Fibre, ...]) -> FloatArray:
    corners: FloatArray = np.max([fibre.mesh.bounds for fibre in fibres], axis=0)
    return corners


def test_stl_reads_back_as_the_same_body(knit: tuple[Fibre, ...], tmp_path: Path) -> None:
    path = write_surface(knit, tmp_path / "knit.stl", "stl")
    mesh = knit[0].mesh
    # Binary STL: 84 bytes of head and 50 for each triangle.
    assert path.stat().st_size == 84 + 50 * len(mesh.faces)
    read = trimesh.load_mesh(path)
    assert isinstance(read, trimesh.Trimesh)
    assert read.is_watertight
    assert read.euler_number == 2
    assert read.volume == pytest.approx(mesh.volume, rel=1e-5)
    assert read.bounds == pytest.approx(mesh.bounds, abs=1e-5)


def test_a_microscopic_stl_is_still_closed(tmp_path: Path) -> None:
    specimen = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=2, loops=2, loop_width=50e-6)
    fibres = specimen_fibres(specimen, 0.1e-6)
    read = trimesh.load_mesh(write_surface(fibres, tmp_path / "knit.stl", "stl"))
    assert isinstance(read, trimesh.Trimesh)
    assert read.is_watertight
    assert read.volume == pytest.approx(fibres[0].mesh.volume, rel=1e-4)


def test_3mf_keeps_units_and_one_object_per_fibre(pair: tuple[Fibre, ...], tmp_path: Path) -> None:
    read = trimesh.load_scene(write_surface(pair, tmp_path / "pair.3mf", "3mf"))
    assert read.units == "millimeter"
    assert sorted(read.geometry) == ["fibre 1", "fibre 2"]
    for name, fibre in zip(("fibre 1", "fibre 2"), pair, strict=True):
        mesh = read.geometry[name]
        assert isinstance(mesh, trimesh.Trimesh)
        assert mesh.is_watertight
        assert len(mesh.faces) == len(fibre.mesh.faces)
        assert mesh.volume == pytest.approx(fibre.mesh.volume, rel=1e-9)
        assert mesh.bounds == pytest.approx(fibre.mesh.bounds, abs=1e-9)


def test_stl_holds_all_fibres(pair: tuple[Fibre, ...], tmp_path: Path) -> None:
    read = trimesh.load_mesh(write_surface(pair, tmp_path / "pair.stl", "stl"))
    assert isinstance(read, trimesh.Trimesh)
    assert read.body_count == 2
    assert read.volume == pytest.approx(sum(fibre.mesh.volume for fibre in pair), rel=1e-5)


def test_the_section_of_an_upright_tube_is_its_polygon() -> None:
    fibres = upright()
    slicer = Slicer(fibres, 0.3)
    sides = fibres[0].sides
    assert slicer.count == 13  # the middle of the next one would be at 4.05
    for number in (0, 5, slicer.count - 1):
        layer = slicer.layer(number)
        assert layer.height == pytest.approx((number + 0.5) * 0.3)
        assert layer.area == pytest.approx(0.5 * sides * math.sin(2.0 * math.pi / sides))
    assert len(slicer.layer(slicer.count).outline) == 0
    assert slicer.layer(slicer.count).area == 0.0


def test_a_lying_tube_is_cut_along() -> None:
    fibres = make_fibres([np.outer(np.linspace(0.0, 10.0, 40), [1.0, 0, 0])], 1.0, 1e-4)
    slicer = Slicer(fibres, 0.1)
    for number in (2, 10, 17):
        height = (number + 0.5) * 0.1
        assert slicer.layer(number).area == pytest.approx(20.0 * math.sqrt(1.0 - (1.0 - height) ** 2), rel=2e-3)


def test_a_layer_that_touches_corners_is_cut_once() -> None:
    # The middle of the second layer is where a ring of corners lies.
    fibres = make_fibres([np.outer([0.0, 1.5, 3.0], [0.0, 0, 1])], 1.0, 1e-3)
    sides = fibres[0].sides
    assert Slicer(fibres, 1.0).layer(1).area == pytest.approx(0.5 * sides * math.sin(2.0 * math.pi / sides))


def test_layers_hold_the_volume(knit: tuple[Fibre, ...]) -> None:
    told: list[float] = []
    slicer = Slicer(knit, 0.05)
    volume, numbers, areas = sliced_volume(slicer, 1000, told.append)
    assert volume == pytest.approx(knit[0].mesh.volume, rel=0.005)
    assert numbers.tolist() == list(range(slicer.count))
    assert areas.min() > 0.0
    assert told[-1] == 1.0
    coarse, fewer, _ = sliced_volume(slicer, 40, told.append)
    assert len(fewer) <= 40
    assert coarse == pytest.approx(knit[0].mesh.volume, rel=0.03)


def test_pixels_fill_the_area_of_the_outline(knit: tuple[Fibre, ...]) -> None:
    layer = Slicer(knit, 0.05).layer(20)
    view = window(bounds(knit), 0.02)
    filled = raster(layer, view)
    assert filled.shape == view.shape
    assert filled.sum() * view.pixel**2 == pytest.approx(layer.area, rel=0.01)
    assert not filled[0].any()
    assert not filled[:, -1].any()


def test_pixels_stand_where_the_material_is() -> None:
    # A tube of radius 1 beside one of the same, 4 along x and 6 along y: lower left, upper right.
    stem = np.outer(np.linspace(0.0, 2.0, 5), [0.0, 0, 1])
    fibres = make_fibres([stem, stem + np.array([4.0, 6.0, 0.0])], 1.0, 1e-3)
    view = window(bounds(fibres), 0.05)
    filled = raster(Slicer(fibres, 1.0).layer(0), view)
    row, column = (round((place + view.margin) / view.pixel) for place in (1.0, 1.0))
    assert filled[-row, column]
    assert not filled[row, column]
    assert filled[round((view.margin + 1.0) / view.pixel), round((view.margin + 5.0) / view.pixel)]


def test_overlapping_fibres_do_not_cancel() -> None:
    stem = np.outer(np.linspace(0.0, 2.0, 5), [0.0, 0, 1])
    fibres = make_fibres([stem, stem + np.array([1.0, 0.0, 0.0])], 1.0, 1e-3)
    filled = raster(Slicer(fibres, 1.0).layer(0), window(bounds(fibres), 0.01))
    union = 2.0 * math.pi - (2.0 * math.pi / 3.0 - math.sqrt(3.0) / 2.0)
    assert filled.sum() * 0.01**2 == pytest.approx(union, rel=0.01)


def test_a_layer_is_drawn_to_scale(tmp_path: Path) -> None:
    fibres = upright()
    view = window(bounds(fibres), 0.02)
    layer = Slicer(fibres, 0.5).layer(3)
    image = imread(write_layer(layer, view, tmp_path / "layer.png"))[..., :3]
    rows, columns = view.shape
    assert image.shape[1] == columns
    ink = image[:rows].mean(axis=-1) < 0.6
    assert ink.sum() == pytest.approx(raster(layer, view).sum(), rel=0.01)
    # A fifth of 2 mm is 0.4 mm; the bar is the round length below, 0.2 mm or 10 pixels.
    bar = (image[rows:] == 0.0).all(axis=-1)[16:24].any(axis=0)
    assert bar.sum() == pytest.approx(10, abs=2)


def test_a_sheet_shows_layers(knit: tuple[Fibre, ...], tmp_path: Path) -> None:
    slicer = Slicer(knit, 0.2)
    layers = [slicer.layer(number) for number in slicer.every(5)]
    image = imread(write_sheet(layers, window(bounds(knit), 0.1), tmp_path / "sheet.png", "a knit"))
    blue = (image[..., 2] > image[..., 0] + 0.2).mean()
    assert 0.005 < blue < 0.3


def test_a_picture_of_too_many_pixels_is_refused(knit: tuple[Fibre, ...]) -> None:
    with pytest.raises(SpecificationError, match=r"slices: found '.* pixels', allowed at most"):
        window(bounds(knit), 1e-4)


@pytest.mark.parametrize(("length", "round_"), [(1.0, 1.0), (0.99, 0.5), (0.03, 0.02), (7.3, 5.0), (60.0, 50.0)])
def test_scale_bars_are_round(length: float, round_: float) -> None:
    assert sheets._round_length(length) == pytest.approx(round_)
