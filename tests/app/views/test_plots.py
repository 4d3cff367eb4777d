from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from app.records.reader import RunReader
from app.views import renders
from app.views.cameras import FROM_A_CORNER, FROM_ABOVE
from app.views.compare import compare_runs, compared
from app.views.curves import curves_of, force_unit, prefixed, stress_unit
from app.views.plots import legend_of, stress_strain_plot
from app.views.plotting import DPI, PixelImage, save
from app.views.renders import (
    beyond,
    knit_frames,
    marked_frames,
    specimen_picture,
)
from app.views.tube_figures import colour_limits, draw
from app.views.tubes import fit_window, smooth_curve, tube
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, knit_specimen
from rigs.analysis.material_limits import MaterialLimit
from rigs.machines.fixtures import clamped_nodes
from rigs.machines.pins import pins_on
from rigs.protocol.extensometer import Extensometer
from tests.synthetic_run import PROTOCOL, SIZE, frame, knit_nodes, make_run, rows


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunReader:
    return make_run(tmp_path_factory.mktemp("run") / "run.h5")


def test_curve_is_the_quadratic_spline_of_the_nodes() -> None:
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 0]])
    curve = smooth_curve(nodes, per_span=2)
    assert curve[0].tolist() == nodes[0].tolist()
    assert curve[-1].tolist() == nodes[-1].tolist()
    # Spans join at the middles of the edges; the middle of span i is (x₋ + 6x + x₊)/8.
    assert curve[1].tolist() == [0.5, 0, 0]
    assert curve[2] == pytest.approx((nodes[0] + 6 * nodes[1] + nodes[2]) / 8)
    assert curve[3].tolist() == [1, 0.5, 0]
    assert curve[5].tolist() == [1.5, 1, 0]


def test_colour_follows_edges_or_nodes() -> None:
    nodes = np.stack([np.arange(5.0), 0 * np.arange(5.0), 0 * np.arange(5.0)], axis=1)
    by_edge = tube(nodes, np.array([0.0, 1, 2, 3]), 0.1)
    by_node = tube(nodes, np.arange(5.0), 0.1)
    assert len(by_edge.values) == len(by_edge.points) == len(by_node.values)
    # An edge's value stands at its middle, x = k + 1/2; ends keep the last one.
    assert by_edge.values[1:-1] == pytest.approx(by_edge.points[1:-1, 0] / 1e3 - 0.5)
    assert by_node.values == pytest.approx(by_node.points[:, 0] / 1e3)
    assert by_edge.radius == pytest.approx(100.0)


def test_window_holds_the_whole_tube() -> None:
    one = tube(knit_nodes(0.0), np.zeros(len(knit_nodes(0.0))), 0.4e-3)
    x0, x1, y0, y1 = fit_window([one])
    assert x0 < one.points[:, 0].min() - 0.4
    assert x1 > one.points[:, 0].max() + 0.4
    assert y0 < one.points[:, 1].min() - 0.4
    assert y1 > one.points[:, 1].max() + 0.4


def test_frames_are_picked_on_the_way_to_the_first_peak() -> None:
    strains = [0.0, 0.1, 0.2, 0.3, 0.4, 0.2, 0.0, 0.2, 0.4]
    picked = marked_frames([frame(float(k), strain, 1, "Stretch") for k, strain in enumerate(strains)])
    assert [(one.time, one.strain["C"]) for one in picked] == [(0.0, 0.0), (2.0, 0.2), (4.0, 0.4)]
    picked = marked_frames([frame(float(k), strain, 1, "Stretch") for k, strain in enumerate([0.0, 0.2, 0.33])])
    assert [one.strain["C"] for one in picked] == [0.0, 0.2, 0.33]
    assert len(marked_frames([frame(0.0, 0.0, 1, "Zero")])) == 1
    assert marked_frames([]) == ()


def test_the_peak_is_among_the_frames_wherever_it_lies() -> None:
    strains = [0.0, 0.2, 0.28, 0.3, 0.28]
    picked = marked_frames([frame(float(k), strain, 1, "Stretch") for k, strain in enumerate(strains)])
    assert [one.strain["C"] for one in picked] == [0.0, 0.2, 0.3]


def test_first_middle_and_peak_are_always_shown() -> None:
    def shown(strains: list[float]) -> list[float]:
        return [
            one.strain["C"] for one in marked_frames([frame(float(k), e, 1, "Hold") for k, e in enumerate(strains)])
        ]

    # A rig that gives shows 13.49 % where 15 % is asked for, and a frame just before its peak.
    assert shown([0.0, 0.0, 0.015, 0.027, 0.045, 0.075, 0.13, 0.1349, 0.1349, 0.05, 0.0]) == [0.0, 0.075, 0.1349]
    assert shown([0.0, -0.05, -0.1, -0.05]) == [0.0, -0.05, -0.1]
    assert shown([0.0, 0.0, 0.0]) == [0.0]
    assert shown([0.0, 0.05]) == [0.0, 0.05]
    assert len(shown([0.025 * k for k in range(100)])) <= 7


def test_a_corner_shows_the_pile_upright_and_nothing_distorted() -> None:
    turn = FROM_A_CORNER.turn
    assert turn @ turn.T == pytest.approx(np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1.0)
    course, wale, pile = FROM_A_CORNER.seen(np.eye(3))
    assert pile[0] == pytest.approx(0.0)
    assert pile[1] > max(abs(course[1]), abs(wale[1])) > 0.0
    assert pile[2] > 0.0
    assert FROM_ABOVE.seen(np.eye(3)) == pytest.approx(np.eye(3))


def test_runs_are_compared_by_axis_and_name(run: RunReader, tmp_path: Path) -> None:
    image = imread(compare_runs([run.path, run.path.parent], tmp_path / "both.png"))
    assert image.std() > 0.05
    with pytest.raises(SpecificationError, match="at least one run"):
        compare_runs([], tmp_path / "none.png")


def test_compared_runs_of_one_axis_differ_in_their_dashes(run: RunReader) -> None:
    lines = compared([run, run], by_modulus=False)
    assert [(line.label, line.dashes) for line in lines] == [
        ("course, synthetic", "-"),
        ("wale, synthetic", "-"),
        ("course, synthetic", "--"),
        ("wale, synthetic", "--"),
    ]
    assert len({line.colour for line in lines}) == 2
    assert {line.modulus for line in lines} == {None}


def test_plot_shows_every_branch_without_noise_and_the_log_behind(run: RunReader, tmp_path: Path) -> None:
    course, wale = curves_of(run)
    assert (course.axis, wale.axis) == ("C", "W")
    for curve in (course, wale):
        found = [(part.cycle, part.role) for part in curve.parts]
        assert found == [(1, "loading"), (1, "unloading"), (2, "loading"), (2, "unloading")]
        assert curve.log is not None
        assert len(curve.log.time) == len(run.samples["biaxial-hook"].time)
    # The peak itself is drawn, not a sample beside it.
    first = wale.parts[0]
    assert first.strain[-1] == wale.parts[1].strain[0] == pytest.approx(0.4, abs=1e-12)
    assert first.stress[-1] == wale.parts[1].stress[0] == pytest.approx(130 * (np.exp(16.5 * 0.4) - 1), rel=1e-12)
    # Between the equilibria, 2 % apart, the curve bends as the exponential does, and no noise is on it.
    assert first.stress == pytest.approx(130 * (np.exp(16.5 * first.strain) - 1), rel=0.02, abs=50.0)
    assert np.all(np.diff(first.stress) > 0.0)
    image = imread(stress_strain_plot(run, tmp_path / "plot.png"))
    assert image.shape[0] > 800
    assert image.std() > 0.05


def test_a_legend_names_what_there_is_and_nothing_else(run: RunReader, tmp_path: Path) -> None:
    assert [entry.label for entry in legend_of(curves_of(run))] == [
        "course",
        "wale",
        "cycle 1",
        "cycle 2",
        "loading",
        "unloading",
        "as logged, with noise",
    ]
    ramp = make_run(tmp_path / "ramp.h5", rows()[:21], sampled=False)
    assert [entry.label for entry in legend_of(curves_of(ramp))] == ["course", "wale"]


def test_a_hold_and_the_peak_before_it_are_drawn(tmp_path: Path) -> None:
    made = rows()[:21]
    held = [replace(made[-1], time=made[-1].time + wait, phase="Hold", step=2) for wait in (4.0, 10.0)]
    course, wale = curves_of(make_run(tmp_path / "run.h5", [*made, *held]))
    for curve in (course, wale):
        ramp, hold = curve.parts
        assert (ramp.role, hold.role, curve.cycles) == ("loading", "hold", (1,))
        assert ramp.strain[-1] == pytest.approx(0.4, abs=1e-12)
        assert (hold.time[0], hold.time[-1]) == (made[-1].time, held[-1].time)
        assert hold.still
    labels = [entry.label for entry in legend_of([course, wale])]
    assert labels == ["course", "wale", "loading", "all axes at rest", "as logged, with noise"]
    assert next(entry.mark for entry in legend_of([course]) if entry.label == "all axes at rest") == "o"
    # What relaxes at rest is a line, and its dot is none.
    slack = [replace(row, force={axis: 0.7 * force for axis, force in row.force.items()}) for row in held]
    relaxing = curves_of(make_run(tmp_path / "relaxing.h5", [*made, *slack]))[0]
    assert not relaxing.parts[-1].still
    assert relaxing.parts[-1].stress[-1] == pytest.approx(0.7 * relaxing.parts[0].stress[-1])


@pytest.mark.parametrize(("others", "role"), [("hold", "held"), ("free", "free")])
def test_an_axis_that_no_step_drives_is_shown_as_what_it_is(others: str, role: str, tmp_path: Path) -> None:
    protocol = PROTOCOL.replace("axes: [C, W]", "axes: [C]").replace("others: hold", f"others: {others}")
    course, wale = curves_of(make_run(tmp_path / "run.h5", protocol=protocol))
    assert course.roles == ("loading", "unloading")
    assert wale.roles == (role,)
    assert [entry.label for entry in legend_of([course, wale])][:2] == ["course", f"wale, {role}"]
    assert legend_of([wale])[0].label == f"wale, {role}"


def test_a_jump_is_drawn_as_a_jump(tmp_path: Path) -> None:
    made = rows()[:21]
    dropped = replace(made[10], force={axis: 0.5 * force for axis, force in made[10].force.items()})
    part = curves_of(make_run(tmp_path / "run.h5", [*made[:11], dropped, *made[11:]]))[0].parts[0]
    at = np.flatnonzero(part.time == dropped.time)
    assert len(at) == 2
    before, after = part.force[at]
    assert after == pytest.approx(0.5 * before)
    assert np.all(part.force[: at[0] + 1] <= before)
    assert np.all(part.force[at[1] :] >= after)


def test_no_line_is_drawn_across_a_zeroing(tmp_path: Path) -> None:
    # Pulled to 40 %, set to zero there, and back.
    made = rows()[:41]
    moment = made[20].time
    middle = replace(made[20], phase="Zero")
    zeroed = make_run(tmp_path / "run.h5", [*made[:21], middle, *made[21:]], zeroed=moment)
    course, _ = curves_of(zeroed)
    assert [part.role for part in course.parts] == ["loading", "unloading"]
    up, down = course.parts
    assert [float(up.strain[-1]), float(down.strain[0])] == pytest.approx([0.4, 0.0])
    step = np.abs(np.diff(zeroed.trace.columns["displacement_C"])).max() / SIZE.extents["C"]
    for part in course.parts:
        assert np.abs(np.diff(part.strain)).max() < step
    assert course.log is not None
    assert np.isnan(course.log.force).sum() == 1


def test_a_run_cut_off_is_plotted_from_its_equilibria(tmp_path: Path) -> None:
    cut_off = make_run(tmp_path / "run.h5", sampled=False)
    course = curves_of(cut_off)[0]
    assert set(cut_off.trace.columns["time"]) <= {time for part in course.parts for time in part.time}
    assert course.log is None
    assert stress_strain_plot(cut_off, tmp_path / "plot.png").exists()


def test_units_fit_the_scale() -> None:
    assert prefixed(0.0) == (1.0, "")
    for (factor, unit), wanted in (
        (prefixed(2.6e-4), (1e6, "µ")),
        (force_unit([np.array([0.0, 3e-4])]), (1e3, "mN")),
        (force_unit([np.array([-0.4, 2e-3])]), (1.0, "N")),
        (stress_unit([np.array([11.3e3]), np.array([0.0])]), (1e-3, "kPa")),
        (stress_unit([np.array([3.9e6])]), (1e-6, "MPa")),
    ):
        assert unit == wanted[1]
        assert factor == pytest.approx(wanted[0])


def test_values_with_signs_have_colours_about_zero() -> None:
    (low, high), (first, last) = colour_limits(np.linspace(-1.0, 3.0, 1001), signed=True)
    assert (first, last) == (-high, high)
    assert [low, high] == pytest.approx([-1.0, 3.0], abs=0.02)
    # A knit at rest has a scale that is no rounding error's.
    assert colour_limits(np.zeros(5), signed=True) == ((-0.01, 0.01), (-0.01, 0.01))
    (low, high), limits = colour_limits(np.linspace(-1.0, 3.0, 1001), signed=False)
    assert limits == (low, high)


def test_a_limit_that_was_passed_is_marked_on_every_curve_and_in_the_pictures(tmp_path: Path) -> None:
    # The made-up fibre is strained by 0.3 strain², so 3 % is passed beyond a strain of 31.6 %: at the row at 32 %.
    limit = MaterialLimit(name="elongation at break", strain=0.03, text="elongation at break of 3 %")
    found = make_run(tmp_path / "run.h5", limits=[limit])
    (crossing,) = found.crossings
    row = rows()[16]
    assert (crossing.row, crossing.time, crossing.limit) == (16, row.time, limit)
    assert crossing.strain == {"C": pytest.approx(0.32), "W": pytest.approx(0.32)}
    for curve in curves_of(found):
        (mark,) = curve.marks
        assert mark.time == row.time
        assert mark.force == pytest.approx(row.force[curve.axis])
        assert mark.strain == pytest.approx(0.32)
    assert legend_of(curves_of(found))[-1].label == "elongation at break of 3 % passed"
    # At 40 % axial and bending strain together come to 0.0196 + 0.02 at the crests of the wave.
    shape = frame(1.0, 0.4, 1, "Stretch")
    strain = np.abs(shape.axial_strain) + shape.bending_strain
    # Crests come every 24 edges, the first at the end of the yarn.
    assert beyond(shape, found.strands, 0.03) == list(range(0, len(strain), 24))
    # Of two strands each is looked at by itself: the edge from one to the other is none.
    halves = replace(shape, axial_strain=np.tile([0.0, 0.05, 0.0], 2), bending_strain=np.zeros(6))
    assert beyond(halves, [4, 4], 0.03) == [1, 5]
    assert beyond(frame(0.0, 0.0, 1, "Zero"), found.strands, 0.03) == []


def test_pictures_of_a_run_and_of_a_specimen(run: RunReader, tmp_path: Path) -> None:
    image = imread(knit_frames(run, tmp_path / "knit.png"))
    assert image.shape[1] > 2.5 * image.shape[0]
    assert image.std() > 0.05
    specimen = knit_specimen(NAMED_STITCHES["stockinette-default"], rows=3, loops=2, loop_width=8e-3)
    plain = imread(specimen_picture(specimen, tmp_path / "s.png"))
    assert plain.std() > 0.05
    pins = pins_on(specimen, Extensometer.inner_half(specimen.counts))
    clamped = clamped_nodes(specimen, {"W": "clamps"})
    marked = imread(specimen_picture(specimen, tmp_path / "marked.png", clamped, pins))
    assert marked.shape != plain.shape or np.abs(marked - plain).max() > 0.5


def test_titles_of_shapes_say_where_strain_counts_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[list[str]] = []

    def kept(tubes: Any, titles: list[str], *rest: Any, **look: Any) -> Figure:  # noqa: ANN401 (handed through)
        drawn.append(titles)
        return draw(tubes, titles, *rest, **look)

    monkeypatch.setattr(renders, "draw", kept)
    for number, zeroed in enumerate((0.0, rows()[5].time)):
        knit_frames(make_run(tmp_path / f"{number}.h5", zeroed=zeroed, sampled=False), tmp_path / "knit.png")
    assert drawn == [[f"{what} {at} %" for at in (0, 20, 40)] for what in ("strain", "strain from as printed")]


def test_an_image_fills_the_axes_pixel_by_pixel(tmp_path: Path) -> None:
    figure = Figure(figsize=(2.0, 1.0))
    axes = figure.add_axes((0.25, 0.2, 0.5, 0.6))
    axes.set_axis_off()
    # The axes are three fifths of an inch high and an inch wide, a fifth and half an inch from the edges.
    rows, edge, side = 3 * DPI // 5, DPI // 5, DPI // 2
    image = np.random.default_rng(1).integers(0, 256, (rows, DPI, 3), dtype=np.uint8)
    axes.add_artist(PixelImage(image))
    page = np.round(255 * imread(save(figure, tmp_path / "page.png"))).astype(np.uint8)
    assert page.shape == (DPI, 2 * DPI, 4)
    assert (page[edge : edge + rows, side : side + DPI, :3] == image).all()
    assert (page[:edge] == 255).all()


def test_a_run_without_frames_has_no_picture(run: RunReader, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(renders, "marked_frames", lambda _: ())
    with pytest.raises(SpecificationError, match="at least one frame"):
        knit_frames(run, tmp_path / "knit.png")


def test_strands_are_tubes_of_their_own_and_breaks_are_left_open() -> None:
    first = np.column_stack([np.arange(8.0), np.zeros(8), np.zeros(8)])
    nodes = np.concatenate([first, first + np.array([0.0, 5.0, 0.0])])
    values = np.concatenate([np.full(7, 1.0), np.full(7, 2.0)])
    whole = tube(nodes, values, 0.1, strands=[8, 8])
    alone = tube(first, values[:7], 0.1)
    assert whole.sizes.tolist() == [len(alone.points)] * 2
    assert whole.points[: whole.sizes[0]].tolist() == alone.points.tolist()
    assert set(whole.values[: whole.sizes[0]]) == {1.0}
    # No piece of a tube leads from strand to strand, nor over a broken edge.
    values[3] = np.nan
    broken = tube(nodes, values, 0.1, strands=[8, 8])
    pieces = np.split(broken.points, np.cumsum(broken.sizes)[:-1])
    assert [(piece[0, 0], piece[-1, 0]) for piece in pieces] == [(0.0, 3e3), (4e3, 7e3), (0.0, 7e3)]
    assert not np.isnan(broken.values).any()


@pytest.mark.parametrize("count", [1, 3])
def test_an_image_of_a_knit_has_the_pixels_of_its_place_on_the_page(tmp_path: Path, count: int) -> None:
    nodes = knit_nodes(0.2)
    tubes = [tube(nodes, np.zeros(len(nodes)), 0.4e-3)] * count
    figure = draw(tubes, ["a title\nof two lines"] * count, "values", lambda _: None)
    save(figure, tmp_path / "page.png")
    scale = DPI / figure.dpi
    for axes in figure.axes[:count]:
        (image,) = (one for one in axes.get_children() if isinstance(one, PixelImage))
        assert image.shape == pytest.approx([scale * axes.bbox.height, scale * axes.bbox.width], abs=1.0)
        # To scale: as long along the wale as along the course.
        assert axes.bbox.width / np.ptp(axes.get_xlim()) == pytest.approx(axes.bbox.height / np.ptp(axes.get_ylim()))
