"""Images of a run as the microscope's TIFF files."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import TYPE_CHECKING, Final

from app.records.folder import whole_file
from app.views.renders import marked_frames
from app.views.sem.bar import with_bar
from app.views.sem.blocks import fixtures
from app.views.sem.detector import image
from app.views.sem.microscope import read_microscope
from app.views.sem.tag import TAG, encoded, lines_of
from app.views.sem.view import fit, turned
from app.views.tubes import tube
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import numpy as np
    import numpy.typing as npt

    from app.records.reader import RunReader
    from app.views.sem.view import View
    from rigs.machines.microscope import Microscope
    from rigs.record import Frame

PIECES: Final = 3
"""Pieces of the drawn yarn from node to node."""

WIDTHS: Final = (1024, 2048)

IMAGES: Final = "images"
"""Folder of the images in that of the run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Stage position and size of the images.

    Attributes
    ----------
    tilt : float
        Angle of the beam to the pile [deg]: 0 from above, 90 across it.
    rotation : float
        Of the specimen about its pile [deg].
    width : int
        Pixels along an image: 1024 or 2048.
    """

    tilt: float
    rotation: float
    width: int = WIDTHS[0]

    def __post_init__(self) -> None:
        if not 0.0 <= self.tilt <= 90.0:
            raise SpecificationError("tilt", self.tilt, "an angle from 0 (from above) to 90 (across the pile)")
        if not -360.0 <= self.rotation <= 360.0:
            raise SpecificationError("rotation", self.rotation, "an angle from -360 to 360")
        if self.width not in WIDTHS:
            raise SpecificationError("width", self.width, " or ".join(map(str, WIDTHS)))


def usual_look(run: RunReader, width: int = WIDTHS[0]) -> Look:
    """Return the usual stage position: plates almost from the side, a block obliquely, others from above."""
    if run.plates is not None:
        return Look(tilt=78.0, rotation=24.0, width=width)
    if run.size.convention == "specimen":
        return Look(tilt=62.0, rotation=32.0, width=width)
    return Look(tilt=30.0, rotation=0.0, width=width)


def taken(run: RunReader) -> tuple[Frame, ...]:
    """Return the frames to render: those that the protocol takes images of, or else those of the run's picture."""
    frames = run.frames()
    return tuple(frame for frame in frames if frame.image is not None) or marked_frames(frames)


def write_images(
    run: RunReader, folder: Path, name: str, look: Look, progress: Callable[[float, str], None]
) -> tuple[Path, ...]:
    """Render the images of a run, all at one magnification.

    Parameters
    ----------
    run : RunReader
        The run.
    folder : Path
        Folder to write them into; made if it is not there.
    name : str
        What their names begin with.
    look : Look
        Position of the stage.
    progress : callable
        Told the share done [1] and what is being done.

    Returns
    -------
    tuple of Path
        The files, in the order of time.

    Raises
    ------
    SpecificationError
        If the run kept no frame.
    """
    import tifffile  # noqa: PLC0415 - needed for nothing else

    frames, microscope = taken(run), read_microscope()
    if not frames:
        raise SpecificationError("run.frames", 0, "at least one frame to render")
    view = view_of_run(run, frames, look, microscope)
    start = datetime.fromisoformat(str(run.provenance["started"]))
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for number, frame in enumerate(frames):
        path = folder / f"{name}_{number + 1:03d}.tif"
        progress(number / len(frames), f"rendering image {number + 1} of {len(frames)}")
        moment = start + timedelta(seconds=frame.time)
        lines = lines_of(view, microscope, tilt=look.tilt, rotation=look.rotation, moment=moment, name=path.name)
        grey = with_bar(picture_of(run, frame, view, microscope, number), view, _columns(lines))
        with whole_file(path) as temporary:
            tag = encoded(lines, view)
            # One entry that other programs show, and the microscope's own.
            tifffile.imwrite(
                temporary,
                grey,
                photometric="minisblack",
                resolution=(1e-2 / view.pixel,) * 2,
                resolutionunit="CENTIMETER",
                metadata=None,
                software="knitlab (simulated image)",
                extratags=[(TAG, "s", len(tag), tag, True)],
            )
        written.append(path)
    return tuple(written)


def view_of_run(run: RunReader, frames: tuple[Frame, ...], look: Look, microscope: Microscope) -> View:
    """Return the view in which all frames can be seen whole."""
    shapes = [frame.nodes for frame in frames]
    if run.plates is not None:
        blocks = [block for frame in frames for block in fixtures(frame, run.plates, run.size.fibre_radius)]
        shapes += [block.corners for block in blocks if block.printed]
    return fit(
        shapes,
        run.size.fibre_radius,
        turned(look.tilt, look.rotation),
        width=look.width,
        print_width=microscope.print_width.value,
    )


def picture_of(run: RunReader, frame: Frame, view: View, microscope: Microscope, number: int) -> npt.NDArray[np.uint8]:
    """Return the grey levels of a frame without data bar; its number and the run's seed make the noise."""
    radius = run.size.fibre_radius
    yarn = tube(frame.nodes, frame.axial_strain, radius, PIECES, strands=run.strands)
    blocks = () if run.plates is None else fixtures(frame, run.plates, radius)
    return image(yarn, blocks, view, microscope, [int(run.provenance["seed"]), number])


def _columns(lines: dict[str, str]) -> tuple[tuple[str, str], ...]:
    """Return the texts of the data bar, upper and lower line of each column."""
    return (
        (lines["AP_ACTUALKV"], lines["AP_WD"]),
        (lines["AP_MAG"], lines["DP_DETECTOR_CHANNEL"]),
        (lines["AP_DATE"], lines["AP_TIME"]),
        (lines["SV_FILE_NAME"], "knitlab, simulated"),
    )
