"""Entry points of printing: check a protocol's knit for a printer and write the printer's files."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Final

from app.checks.dry_run import build_specimen
from app.file_names import file_stem
from app.printing.checks import Check, printer_checks, surface_checks
from app.printing.fibres import specimen_fibres
from app.printing.files import write_surface
from app.printing.sheets import window, write_layer, write_sheet
from app.printing.slices import Slicer, sliced_volume
from knitlab_core.errors import SpecificationError
from knitlab_core.knits.fibre_clearance import check_fibres

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from app.printing.fibres import Fibre
    from app.printing.files import Format
    from app.schemas import Loaded
    from knitlab_core.knits import Specimen
    from rigs.machines.printer import PrinterData

MOST_AREAS: Final = 400
"""Layers whose areas are summed for the volume, at most about."""

_SHOWN: Final = 12
_SLICED: Final = 0.03
_SURFACE, _CHECKED, _WRITTEN = 0.15, 0.4, 0.6


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """Which files to write.

    Attributes
    ----------
    formats : tuple of {'stl', '3mf'}
        Files of the surface.
    sheet : bool
        Whether to cut layers and show some on a sheet.
    every : int or None
        Show every such layer as a picture of its own.
    chord_error : float or None
        How far the mesh may lie off the true tube [m]; None for half a layer.
    """

    formats: tuple[Format, ...]
    sheet: bool = False
    every: int | None = None
    chord_error: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Print:
    """Result of the checks of a knit, and its files.

    Attributes
    ----------
    checks : tuple of Check
        Figures beside what is allowed.
    files : tuple of Path
        What was written.
    fibres, sides, rings, triangles : int
        Size of the surface: corners of a ring, rings and triangles of all fibres.
    extent : tuple of float
        Size of the print along course, wale and out of plane [m].
    volume : float
        Material [m³].
    layers : int
        Layers of the printer.
    chord_error : float
        How far the mesh may lie off the true tube [m].
    """

    checks: tuple[Check, ...]
    files: tuple[Path, ...]
    fibres: int
    sides: int
    rings: int
    triangles: int
    extent: tuple[float, float, float]
    volume: float
    layers: int
    chord_error: float

    @property
    def printable(self) -> bool:
        """Whether every check is met."""
        return all(check.met for check in self.checks)


def print_knit(
    loaded: Loaded, printer: PrinterData, folder: Path, wanted: Wanted, progress: Callable[[float, str], None]
) -> Print:
    """Make the surface of a protocol's knit, check it for a printer and write its files.

    Parameters
    ----------
    loaded : Loaded
        The protocol.
    printer : PrinterData
        What it can resolve.
    folder : Path
        Where the files shall stand; made if need be.
    wanted : Wanted
        What to make.
    progress : callable
        Told the share done [1] and what is being done.

    Returns
    -------
    Print
        A knit that fails a check is an outcome, with its files written.

    Raises
    ------
    SpecificationError
        For a knit that cannot exist, a yarn by measurement, or a surface or picture beyond its limit.
    """
    progress(0.0, "laying the surface")
    _require_solid(loaded)
    specimen = build_specimen(loaded)
    layer = printer.layer_height.value
    error = 0.5 * layer if wanted.chord_error is None else wanted.chord_error
    fibres = specimen_fibres(specimen, error)
    progress(_SURFACE, "checking the surface")
    checks = surface_checks(fibres, 1e3 * error)
    checks += printer_checks(fibres, printer, 1e3 * _gap(specimen))
    slicer = Slicer(fibres, 1e3 * layer)
    folder.mkdir(parents=True, exist_ok=True)
    name = file_stem(loaded.protocol.name)
    files = list(_surfaces(fibres, folder / name, wanted.formats, progress))
    volume = sum(float(fibre.mesh.volume) for fibre in fibres)
    if wanted.sheet or wanted.every is not None:
        check, pictures = _slice(fibres, slicer, printer, folder / name, wanted, progress)
        checks.append(check)
        files += pictures
    progress(1.0, "done")
    corners = [fibre.mesh.bounds[1] for fibre in fibres]
    x, y, z = (1e-3 * float(max(corner[axis] for corner in corners)) for axis in range(3))
    return Print(
        checks=tuple(checks),
        files=tuple(files),
        fibres=len(fibres),
        sides=fibres[0].sides,
        rings=sum(len(fibre.points) for fibre in fibres),
        triangles=sum(len(fibre.mesh.faces) for fibre in fibres),
        extent=(x, y, z),
        volume=1e-9 * volume,
        layers=slicer.count,
        chord_error=error,
    )


def _require_solid(loaded: Loaded) -> None:
    """Raise for a yarn by measurement: it is spun, not printed."""
    measured = loaded.protocol.specimen.measured
    if measured is not None:
        field = "yarn" if ("specimen", "yarn") in loaded.document.values else "material"
        found = f"{measured.name}, a yarn by measurement"
        raise loaded.locate(SpecificationError(field, found, "a solid material, to be printed"))


def _gap(specimen: Specimen) -> float:
    """Return the least gap by the centreline, inside the yarn and between yarns, taken as round [m]."""
    if specimen.yarn.fibres == 1:
        return specimen.clearance
    gaps = check_fibres(specimen.centreline, specimen.yarn, loop_width=specimen.loop_width)
    return specimen.loop_width * min(gaps.inside, gaps.between)


def _surfaces(
    fibres: Sequence[Fibre], stem: Path, formats: Sequence[Format], progress: Callable[[float, str], None]
) -> Iterator[Path]:
    """Write the surface in every format."""
    for done, kind in enumerate(formats):
        share = _CHECKED + (_WRITTEN - _CHECKED) * done / len(formats)
        progress(share, f"writing {kind.upper()}")
        yield write_surface(fibres, stem.with_name(f"{stem.name}.{kind}"), kind)


def _slice(
    fibres: Sequence[Fibre],
    slicer: Slicer,
    printer: PrinterData,
    stem: Path,
    wanted: Wanted,
    progress: Callable[[float, str], None],
) -> tuple[Check, list[Path]]:
    """Slice into layers: their volume beside the mesh's, and pictures."""
    bounds = fibres[0].mesh.bounds.copy()
    for fibre in fibres[1:]:
        bounds[1] = bounds[1].clip(min=fibre.mesh.bounds[1])
    view = window(bounds, 1e3 * printer.resolution.value)
    span = 1.0 - _WRITTEN
    volume, numbers, _ = sliced_volume(
        slicer, MOST_AREAS, lambda done: progress(_WRITTEN + 0.5 * span * done, "cutting layers")
    )
    meshes = sum(float(fibre.mesh.volume) for fibre in fibres)
    check = Check(
        name="volume of layers / mesh",
        found=volume / meshes,
        least=1.0 - _SLICED,
        most=1.0 + _SLICED,
        note=f"{len(numbers)} of {slicer.count} layers",
    )
    pictures = []
    if wanted.sheet:
        shown = [slicer.layer(number) for number in slicer.every(ceil(slicer.count / _SHOWN))]
        title = f"{stem.name}: {len(shown)} of {slicer.count} layers on {printer.printer}"
        pictures.append(write_sheet(shown, view, stem.with_name(f"{stem.name}_slices.png"), title))
    if wanted.every is not None:
        chosen = slicer.every(wanted.every)
        place = stem.with_name(f"{stem.name}_layers")
        place.mkdir(exist_ok=True)
        for done, number in enumerate(chosen):
            progress(_WRITTEN + span * (0.5 + 0.5 * done / len(chosen)), f"drawing layer {number}")
            pictures.append(write_layer(slicer.layer(number), view, place / f"layer_{number:05d}.png"))
    return check, pictures
