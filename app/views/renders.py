"""Renders of the knit to scale: the real tube, coloured by a value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.views.cameras import view_of
from app.views.cells import middle_of, outline, vectors_at, vectors_of, window_of, with_images
from app.views.curve_styles import BEYOND, NAMES
from app.views.curves import prefixed
from app.views.tube_figures import draw
from app.views.tubes import tube
from knitlab_core.errors import SpecificationError
from rigs.axes import DIRECTIONS, SHEARS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from app.records.reader import RunReader
    from knitlab_core.knits import PinSpots, SiteSet, Specimen
    from rigs.axes import Axis, FloatArray, IntArray
    from rigs.record import Frame

AXIAL = "axial strain of the yarn [%]"
MARK = 0.2
MARK_SLACK = 0.005
#: Frames at whole strains between the first and the peak, about.
MOST_MARKS = 4
#: Edges between two marks of a fibre that is strained too much.
PEAK_DISTANCE = 8
WIRE_COLOUR = "#8a8a8a"
SITE_COLOURS = {"wale+": "#D55E00", "wale-": "#E69F00", "course+": "#0072B2", "course-": "#56B4E9"} | {
    "pile+": "#009E73",
    "pile-": "#66C9A8",
}


def knit_frames(run: RunReader, path: Path) -> Path:
    """Draw the knit up to the largest strain: first, middle, peak and every 20 %, on one scale.

    Where a fibre is strained beyond a limit of its material the title names it, and crosses mark the spots.

    Parameters
    ----------
    run : RunReader
        A run with frames.
    path : Path
        Path of the PNG to write.

    Returns
    -------
    Path
        The same path.

    Raises
    ------
    SpecificationError
        If the run kept no frame.
    """
    from app.views.plotting import save  # noqa: PLC0415 (matplotlib: only where a picture is wanted)

    frames = marked_frames(run.frames())
    if not frames:
        raise SpecificationError("run.frames", 0, "at least one frame to draw")
    view = view_of(volumetric=run.size.convention == "specimen")
    tubes = [
        tube(view.seen(frame.nodes), 100 * frame.axial_strain, run.size.fibre_radius, strands=run.strands)
        for frame in frames
    ]
    cells = vectors_at(run, frames)
    middles = [middle_of(frame.nodes, view) for frame in frames]
    tubes = [with_images(one, vectors, view) for one, vectors in zip(tubes, cells, strict=True)] if cells else tubes
    limit = min((crossing.limit for crossing in run.crossings), key=lambda one: one.strain, default=None)
    moved = any("displacement" in zero.kinds and any(zero.travel.values()) for zero in run.zeroings or ())
    titles = [_strain_title(frame, "strain from as printed" if moved else "strain") for frame in frames]
    spots = [beyond(frame, run.strands, limit.strain) if limit is not None else [] for frame in frames]
    if limit is not None:
        titles = [
            f"{title}\n× beyond the {limit.text}" if at else title for title, at in zip(titles, spots, strict=True)
        ]

    def add(figure: Figure) -> None:
        for axes, middle, vectors in zip(figure.axes, middles, cells, strict=False):
            outline(axes, middle, vectors, view)
        for axes, frame, at in zip(figure.axes, frames, spots, strict=False):
            _add_wires(axes, view.seen(frame.wires.mean(axis=1)), run.size.fibre_radius)
            for x, y, _ in 1e3 * view.seen(frame.nodes[at]):
                axes.plot(x, y, "X", ms=8, mfc=BEYOND, mec="white", mew=0.8, zorder=4)

    window = window_of(middles, cells, view) if cells else None
    return save(draw(tubes, titles, AXIAL, add, signed=True, view=view, window=window), path)


def marked_frames(frames: Sequence[Frame]) -> tuple[Frame, ...]:
    """Select the first frame, the peak, and those at multiples of 20 % strain or the one nearest the middle.

    The peak is the first frame at the largest strain of any axis, in tension or compression; a shear adds to it.
    """
    if not frames:
        return ()
    size = [_largest(frame, DIRECTIONS) + _largest(frame, SHEARS) for frame in frames]
    last = int(np.argmax(np.array(size) >= max(size) - 1e-9))
    marks = {0: 0, last: 1}
    step = MARK * max(1, round(size[last] / (MARK * MOST_MARKS)))
    for number in range(1, last):
        share = size[number] / step
        # A frame near the first or the peak would look the same.
        inner = MARK_SLACK < size[number] < size[last] - MARK_SLACK
        if inner and abs(share - round(share)) * step <= MARK_SLACK and round(share) * step not in marks.values():
            marks[number] = round(share) * step  # type: ignore[assignment]
    if not any(abs(size[number] - 0.5 * size[last]) < 0.25 * size[last] for number in marks) and last > 1:
        marks[min(range(1, last), key=lambda number: abs(size[number] - 0.5 * size[last]))] = -1
    return tuple(frames[number] for number in sorted(marks))


def _largest(frame: Frame, axes: Sequence[Axis]) -> float:
    """Return the largest strain of some axes, either way [1]; 0 where none of them is driven."""
    return max((abs(frame.strain[axis]) for axis in axes if axis in frame.strain), default=0.0)


def beyond(frame: Frame, strands: Sequence[int], limit: float) -> list[int]:
    """Return the nodes at peaks of the fibre's surface strain beyond a limit [1]."""
    from scipy.signal import find_peaks  # noqa: PLC0415 (only where a limit was passed)

    strain = np.nan_to_num(np.abs(frame.axial_strain) + frame.bending_strain)
    nodes: list[int] = []
    first = 0
    for strand, count in enumerate(strands):
        edges = strain[first - strand : first - strand + count - 1]
        # A peak may be at an end of the strand.
        peaks, _ = find_peaks(np.pad(edges, 1), height=limit, distance=PEAK_DISTANCE)
        nodes += (first + peaks - 1).tolist()
        first += count
    return nodes


def specimen_picture(
    specimen: Specimen,
    path: Path,
    clamped: Mapping[SiteSet, IntArray] | None = None,
    pins: Mapping[Axis, PinSpots] | None = None,
) -> Path:
    """Draw a specimen as made, coloured by height, with its boundary sites, or with what clamps hold, and with pins.

    Parameters
    ----------
    specimen : Specimen
        Nodes, radius and site sets.
    path : Path
        Path of the PNG to write.
    clamped : Mapping, optional
        Nodes in the jaws of clamps by edge; they are marked in the place of the sites.
    pins : Mapping, optional
        Pins of an extensometer by axis.

    Returns
    -------
    Path
        The same path.
    """
    from app.views.plotting import save  # noqa: PLC0415 (as above)

    marked = clamped or specimen.sites

    volumetric = "P" in specimen.fabric.axes
    layers = f" × {specimen.layers} layers" if volumetric else ""
    title = (
        f"{specimen.rows} rows × {specimen.loops} loops{layers}, loop width {_length(specimen.loop_width)}, "
        f"fibre radius {_length(specimen.radius)}\n"
        f"yarn {_length(specimen.yarn_length)}, narrowest gap {_length(specimen.clearance)}"
    )
    heights = np.asarray(specimen.nodes)[:, 2]
    factor, letter = prefixed(float(np.ptp(heights)), least=0.1)
    heights = factor * heights
    view = view_of(volumetric=volumetric)
    strands = [len(strand) for strand in specimen.strands]
    seen = tube(view.seen(specimen.nodes), heights, specimen.radius, strands=strands)
    # A knit with hundreds of sites must still be seen behind them.
    size = min(7.0, 60.0 / np.sqrt(max(1, sum(len(indices) for indices in marked.values()))))
    cell, middle = vectors_of(specimen), middle_of(specimen.nodes, view)
    seen = seen if cell is None else with_images(seen, cell, view)

    def add(figure: Figure) -> None:
        for name, indices in marked.items():
            x, y, _ = 1e3 * view.seen(specimen.nodes[indices]).T
            colour = SITE_COLOURS.get(name, "black")
            figure.axes[0].plot(x, y, "o", ms=size, mfc=colour, mec="white", mew=size / 7, label=name, zorder=3)
        for axis, spots in (pins or {}).items():
            x, y, _ = 1e3 * view.seen(spots.places(specimen.nodes)).T
            figure.axes[0].plot(x, y, "D:", ms=8, color="black", mfc="white", label=f"pins {axis}", zorder=4)
        if cell is not None:
            outline(figure.axes[0], middle, cell, view)
        if marked or pins:
            what = "held by clamps" if clamped else "boundary sites"
            figure.legend(loc="outside lower center", ncols=4, frameon=False, title=what)

    window = None if cell is None else window_of([middle], [cell], view)
    return save(draw([seen], [title], f"height z [{letter}m]", add, view=view, window=window), path)


def _length(value: float) -> str:
    """Write a length [m] in the unit that suits it."""
    factor, letter = prefixed(value, least=0.1)
    return f"{factor * value:.3g} {letter}m"


def _add_wires(axes: Axes, middles: FloatArray, radius: float) -> None:
    """Draw wires, which are vertical and as thick as the yarn, as grey discs at their middles (W, 3) [m]."""
    from matplotlib.patches import Circle  # noqa: PLC0415

    for x, y, _ in 1e3 * middles:
        axes.add_patch(Circle((x, y), 1e3 * radius, facecolor=WIRE_COLOUR, edgecolor="black", linewidth=0.5, zorder=3))


def _strain_title(frame: Frame, what: str) -> str:
    """Return the title of a shape: its strain from the printed one, and `what` that is called."""
    shares = {NAMES[axis]: f"{100 * value:.0f} %".replace("-0 %", "0 %") for axis, value in frame.strain.items()}
    if len(set(shares.values())) == 1 and len(shares) > 1:
        return f"{what} {next(iter(shares.values()))}"
    return f"{what}: " + ", ".join(f"{name} {share}" for name, share in shares.items())
