"""Draw the knit: its real tube, coloured by a value, to scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from app.painters import fit_window, paint_lines, vtk_images
from app.report import NAMES
from app.run_folder import whole_file
from app.tubes import Tube, tube
from app.views import FROM_ABOVE, view_of
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from app.run_reader import RunReader
    from app.views import View
    from knitlab_core.knits import Specimen
    from rigs.record import FloatArray, Frame

AXIAL = "axial strain of the yarn [%]"
#: Light to dark and sound for colour-blind readers; at rest the yarn is pale and its crossings show.
COLOURS = "YlOrRd"
DPI = 200
MARK = 0.2
MARK_SLACK = 0.005
WIRE_COLOUR = "#8a8a8a"
SITE_COLOURS = {"wale+": "#D55E00", "wale-": "#E69F00", "course+": "#0072B2", "course-": "#56B4E9"} | {
    "pile+": "#009E73",
    "pile-": "#66C9A8",
}


class Picture(NamedTuple):
    """Say where a picture is and, if VTK did not paint it, why not."""

    path: Path
    note: str


def knit_frames(run: RunReader, path: Path) -> Picture:
    """Draw the knit on its way to the first peak, at every 20 % of strain, on one scale of colour and length.

    Parameters
    ----------
    run : RunReader
        A run with frames.
    path : Path
        Where the PNG shall stand.

    Returns
    -------
    Picture
        The path, and a note if VTK did not paint it.

    Raises
    ------
    SpecificationError
        If the run kept no frame.
    """
    frames = marked_frames(run.frames())
    if not frames:
        raise SpecificationError("run.frames", 0, "at least one frame to draw")
    view = view_of(volumetric=run.size.convention == "specimen")
    tubes = [
        tube(view.seen(frame.nodes), 100 * frame.axial_strain, run.size.fibre_radius, strands=run.strands)
        for frame in frames
    ]
    figure, note = draw(tubes, [_strain_title(frame) for frame in frames], AXIAL, view=view)
    for axes, frame in zip(figure.axes, frames, strict=False):
        _add_wires(axes, view.seen(frame.wires.mean(axis=1)), run.size.fibre_radius)
    return Picture(_save(figure, path), note)


def marked_frames(frames: Sequence[Frame]) -> tuple[Frame, ...]:
    """Pick the first frame, those at whole 20 % of strain up to the first peak, and the peak."""
    strains = [max(frame.strain.values()) for frame in frames]
    peak = max(strains, default=0.0)
    picked: dict[int | None, Frame] = {}
    for frame, strain in zip(frames, strains, strict=True):
        mark = round(strain / MARK)
        marked = abs(strain - mark * MARK) <= MARK_SLACK
        if marked or strain == peak:
            picked.setdefault(mark if marked else None, frame)
        if strain >= peak - MARK_SLACK:
            break
    return tuple(picked.values())


def specimen_picture(specimen: Specimen, path: Path) -> Picture:
    """Draw a specimen as it was made, coloured by height, with its boundary sites.

    Parameters
    ----------
    specimen : Specimen
        Nodes, radius and site sets.
    path : Path
        Where the PNG shall stand.

    Returns
    -------
    Picture
        The path, and a note if VTK did not paint it.
    """
    layers = f" × {specimen.layers} layers" if "pile+" in specimen.sites else ""
    title = (
        f"{specimen.rows} rows × {specimen.loops} loops{layers}, loop width {1e3 * specimen.loop_width:g} mm, "
        f"fibre radius {1e3 * specimen.radius:.3g} mm\n"
        f"yarn {specimen.yarn_length:.3g} m, narrowest gap {1e3 * specimen.clearance:.2g} mm"
    )
    heights = 1e3 * np.asarray(specimen.nodes)[:, 2]
    view = view_of(volumetric="pile+" in specimen.sites)
    strands = [len(strand) for strand in specimen.strands]
    seen = tube(view.seen(specimen.nodes), heights, specimen.radius, strands=strands)
    figure, note = draw([seen], [title], "height z [mm]", "YlGnBu", view=view)
    axes = figure.axes[0]
    # A knit with hundreds of sites must still be seen behind them.
    size = min(7.0, 60.0 / np.sqrt(sum(len(indices) for indices in specimen.sites.values())))
    for name, indices in specimen.sites.items():
        x, y, _ = 1e3 * view.seen(specimen.nodes[indices]).T
        colour = SITE_COLOURS.get(name, "black")
        axes.plot(x, y, "o", ms=size, mfc=colour, mec="white", mew=size / 7, label=name, zorder=3)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, title="boundary sites")
    return Picture(_save(figure, path), note)


def draw(
    tubes: Sequence[Tube], titles: Sequence[str], label: str, colours: str = COLOURS, *, view: View = FROM_ABOVE
) -> tuple[Figure, str]:
    """Draw tubes side by side on one scale of colour and length.

    Parameters
    ----------
    tubes : sequence of Tube
        What to draw.
    titles : sequence of str
        One per tube.
    label : str
        Words beside the colour bar.
    colours : str
        Name of the colour map.
    view : View
        How the tubes were turned to the eye.

    Returns
    -------
    figure : Figure
        Its first axes are the tubes'.
    note : str
        Why VTK did not paint; empty if it did.
    """
    from matplotlib.cm import ScalarMappable  # noqa: PLC0415 - imported when a picture is wanted
    from matplotlib.colors import Normalize  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    window = fit_window(tubes)
    width, height = window[1] - window[0], window[3] - window[2]
    values = np.concatenate([one.values for one in tubes])
    low, high = np.percentile(values, [0.2, 99.8])
    limits = (float(low), float(max(high, low + 1e-6)))
    scale = ScalarMappable(Normalize(*limits), colours)
    panel = 4.6 if len(tubes) > 1 else 6.2
    figure = Figure(figsize=(panel * len(tubes) + 1.4, panel * height / width + 0.7), layout="constrained")
    row = list(np.atleast_1d(figure.subplots(1, len(tubes), sharey=True)))
    for axes, title in zip(row, titles, strict=True):
        _dress(axes, title, window)
        view.dress(axes)
    for axes in row[1:]:
        axes.set_ylabel("")
    bar = figure.colorbar(scale, cax=row[-1].inset_axes((1.03, 0.0, 0.035, 1.0)))
    bar.set_label(label, fontsize=12)
    # Laid out now, so that an image has the pixels its place on the page has.
    figure.draw_without_rendering()
    pixels = DPI * row[0].get_position().width * figure.get_figwidth() / width
    images = vtk_images(tubes, window, pixels=pixels, limits=limits, colours=colours)
    if isinstance(images, str):
        for axes, one in zip(row, tubes, strict=True):
            paint_lines(axes, one, window, scale)
        return figure, f"drawn with matplotlib: {images}"
    for axes, image in zip(row, images, strict=True):
        axes.imshow(image, extent=window, interpolation="nearest", zorder=2)
    return figure, ""


def _dress(axes: Axes, title: str, window: tuple[float, float, float, float]) -> None:
    axes.set(xlim=window[:2], ylim=window[2:], aspect="equal")
    axes.set_title(title, fontsize=13)
    axes.tick_params(length=3, labelsize=10)
    for side in axes.spines.values():
        side.set_color("#bbbbbb")


def _add_wires(axes: Axes, middles: FloatArray, radius: float) -> None:
    """Draw wires, which stand upright and are as thick as the yarn, as grey discs about their middles (W, 3) [m]."""
    from matplotlib.patches import Circle  # noqa: PLC0415

    for x, y, _ in 1e3 * middles:
        axes.add_patch(Circle((x, y), 1e3 * radius, facecolor=WIRE_COLOUR, edgecolor="black", linewidth=0.5, zorder=3))


def _strain_title(frame: Frame) -> str:
    shares = {NAMES[axis]: f"{100 * value:.0f} %".replace("-0 %", "0 %") for axis, value in frame.strain.items()}
    if len(set(shares.values())) == 1 and len(shares) > 1:
        return f"strain {next(iter(shares.values()))}"
    return "strain: " + ", ".join(f"{name} {share}" for name, share in shares.items())


def _save(figure: Figure, path: Path) -> Path:
    with whole_file(path) as temporary:
        figure.savefig(temporary, dpi=DPI, facecolor="white")
    return path
