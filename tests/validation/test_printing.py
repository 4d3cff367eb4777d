"""Surfaces, gaps and slices of a printed knit, against those of the yarn that they stand for."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from app.printing.checks import printer_checks, surface_checks
from app.printing.fibres import Fibre, specimen_fibres
from app.printing.gap import mesh_gap
from app.printing.printers import read_printer_data
from app.printing.slices import Slicer, sliced_volume
from knitlab_core.knits import NAMED_STITCHES, NAMED_VOLUMETRIC_STITCHES, Specimen, knit_specimen
from knitlab_core.knits.fibre_clearance import check_fibres
from knitlab_core.knits.fibres import same_area

if TYPE_CHECKING:
    from collections.abc import Callable

ERROR = 9.375e-6


@pytest.fixture(scope="module")
def specimen() -> Specimen:
    return knit_specimen(NAMED_STITCHES["stockinette-default"], rows=6, loops=6, loop_width=8e-3)


@pytest.fixture(scope="module")
def fibre(specimen: Specimen) -> Fibre:
    (fibre,) = specimen_fibres(specimen, ERROR)
    return fibre


def test_volume(specimen: Specimen, fibre: Fibre, bar: Callable[..., None]) -> None:
    area = 0.5 * fibre.sides * math.sin(2.0 * math.pi / fibre.sides) * specimen.radius**2
    error = 1e-9 * float(fibre.mesh.volume) / (area * specimen.yarn_length) - 1.0
    bar("print 6x6: volume of the mesh", error, 0.002, "1", "Pappus, polygon area x length of the yarn")


@pytest.mark.slow
def test_volume_of_a_fine_mesh(specimen: Specimen, bar: Callable[..., None]) -> None:
    finer = specimen_fibres(specimen, ERROR / 8.0)[0]
    error = 1e-9 * float(finer.mesh.volume) / (math.pi * specimen.radius**2 * specimen.yarn_length) - 1.0
    bar("print 6x6: volume at an eighth of the chord error", error, 2.0 * ERROR / 8.0 / 0.4e-3, "1", "pi r² L")


def test_gap(specimen: Specimen, fibre: Fibre, bar: Callable[..., None]) -> None:
    error = (1e-3 * mesh_gap([fibre]) - specimen.clearance) / ERROR
    bar("print 6x6: gap of the mesh, in chord errors", error, 2.0, "1", "distance of centrelines less 2r")


def test_slices(fibre: Fibre, bar: Callable[..., None]) -> None:
    volume, _, _ = sliced_volume(Slicer([fibre], 0.01875), 50, lambda _: None)
    bar("print 6x6: areas of 43 layers", volume / float(fibre.mesh.volume) - 1.0, 0.03, "1", "volume of the mesh")


def test_every_check_of_the_6x6_is_met(specimen: Specimen, fibre: Fibre) -> None:
    checks = surface_checks([fibre], 1e3 * ERROR)
    checks += printer_checks([fibre], read_printer_data("j35"), 1e3 * specimen.clearance)
    assert [check.name for check in checks if not check.met] == []


def test_a_yarn_of_three_fibres(bar: Callable[..., None]) -> None:
    yarn = replace(same_area(0.05, 3, gap=0.8), twist=6.0)
    stitch = NAMED_STITCHES["stockinette-default"]
    specimen = knit_specimen(stitch, rows=2, loops=2, loop_width=8e-3, yarn=yarn)
    fibres = specimen_fibres(specimen, ERROR)
    assert len(fibres) == 3
    assert [check.name for check in surface_checks(fibres, 1e3 * ERROR) if not check.met] == []
    inside = 8e-3 * check_fibres(specimen.centreline, yarn, loop_width=8e-3).inside
    error = (1e-3 * mesh_gap(fibres) - inside) / ERROR
    bar("print 3-ply 2x2: gap of the meshes, in chord errors", error, 2.0, "1", "distance of fibres less 2r")


@pytest.mark.slow
def test_the_6x6x6_is_printable(bar: Callable[..., None]) -> None:
    stitch = NAMED_VOLUMETRIC_STITCHES["volumetric-default"]
    specimen = knit_specimen(stitch, rows=6, loops=6, layers=6, loop_width=8e-3)
    fibres = specimen_fibres(specimen, ERROR)
    checks = surface_checks(fibres, 1e3 * ERROR)
    checks += printer_checks(fibres, read_printer_data("j35"), 1e3 * specimen.clearance)
    assert [check.name for check in checks if not check.met] == []
    (fibre,) = fibres
    bar("print 6x6x6: triangles", len(fibre.mesh.faces), 2_500_000, "1", "half of the limit")
    area = 0.5 * fibre.sides * math.sin(2.0 * math.pi / fibre.sides) * specimen.radius**2
    error = 1e-9 * float(fibre.mesh.volume) / (area * specimen.yarn_length) - 1.0
    bar("print 6x6x6: volume of the mesh", error, 0.002, "1", "Pappus, polygon area x length of the yarn")
    error = (1e-3 * mesh_gap(fibres) - specimen.clearance) / ERROR
    bar("print 6x6x6: gap of the mesh, in chord errors", error, 2.0, "1", "distance of centrelines less 2r")
    volume, _, _ = sliced_volume(Slicer(fibres, 0.01875), 400, lambda _: None)
    bar("print 6x6x6: areas of 360 layers", volume / float(fibre.mesh.volume) - 1.0, 0.03, "1", "volume of the mesh")
