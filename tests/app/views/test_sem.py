"""Images as an electron microscope would take them: their scale, their grey levels, their tag."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile

from app.cli.sem import images
from app.records.layout import make_record
from app.records.reader import RunReader
from app.records.writer import RunWriter
from app.runs.publishing import images_of
from app.views.sem.bar import scale_of, with_bar
from app.views.sem.blocks import Block, fixtures
from app.views.sem.detector import emission, image
from app.views.sem.images import Look, taken, usual_look, write_images
from app.views.sem.microscope import read_microscope
from app.views.sem.tag import TAG
from app.views.sem.units import metric
from app.views.sem.view import View, fit, turned
from app.views.tubes import tube
from knitlab_core.errors import FormatError, SpecificationError
from rigs.record import Frame, SpecimenSize
from tests.synthetic_run import make_run, stage_instrument

MICROSCOPE = read_microscope()
RADIUS = 4e-6
STARTED = "2026-11-22T23:59:30+01:00"


def straight(*lines: tuple[tuple[float, float, float], tuple[float, float, float]]) -> np.ndarray:
    """Return the nodes of straight strands of 21 nodes each [m]."""
    share = np.linspace(0.0, 1.0, 21)[:, None]
    return np.concatenate([np.array(begin) + share * (np.array(end) - np.array(begin)) for begin, end in lines])


def view_on(nodes: np.ndarray, tilt: float = 0.0, rotation: float = 0.0, width: int = 1024) -> View:
    return fit([nodes], RADIUS, turned(tilt, rotation), width=width, print_width=MICROSCOPE.print_width.value)


def seen(nodes: np.ndarray, view: View, blocks: tuple[Block, ...] = ()) -> np.ndarray:
    strands = [21] * (len(nodes) // 21)
    yarn = tube(nodes, np.zeros(len(nodes) - len(strands)), RADIUS, strands=strands)
    return emission(yarn, blocks, view, MICROSCOPE)


def middle_of_bright(signal: np.ndarray) -> float:
    """Return the middle of what is bright along a line of pixels [pixel]."""
    bright = np.flatnonzero(signal > 0.5)
    return float(0.5 * (bright[0] + bright[-1] + 1))


def test_a_known_distance_is_as_many_pixels_as_it_says() -> None:
    # Two upright yarns, 150 µm from axis to axis, of 8 µm diameter.
    nodes = straight(((0, 0, 0), (0, 2e-4, 0)), ((1.5e-4, 0, 0), (1.5e-4, 2e-4, 0)))
    view = view_on(nodes)
    line = seen(nodes, view)[view.height // 2]
    left, right = line[:512], line[512:]
    apart = 512 + middle_of_bright(right) - middle_of_bright(left)
    assert apart * view.pixel == pytest.approx(1.5e-4, abs=view.pixel)
    assert np.count_nonzero(left > 0.5) * view.pixel == pytest.approx(2 * RADIUS, abs=1.2 * view.pixel)


@pytest.mark.parametrize(("tilt", "rotation"), [(0.0, 0.0), (40.0, 25.0), (78.0, -110.0), (90.0, 0.0)])
def test_a_spot_is_where_the_view_puts_it(tilt: float, rotation: float) -> None:
    # A short yarn far off the middle, beside a long one.
    nodes = straight(((0, 0, 0), (2e-4, 1e-4, 5e-5)), ((5e-5, 2e-4, 1.5e-4), (5.5e-5, 2.05e-4, 1.55e-4)))
    view = view_on(nodes, tilt, rotation)
    column, row, _ = view.on_image(nodes[21:]).mean(axis=0)
    found = np.argwhere(seen(nodes[21:], view) > 0.5)
    assert found.mean(axis=0) + 0.5 == pytest.approx([row, column], abs=0.7)
    # Seen from above, the wale runs upwards and the course to the right.
    if tilt == 0.0:
        assert row < view.on_image(nodes[:21])[:, 1].min()


def test_magnification_fits_the_width_of_a_print_and_shows_everything() -> None:
    nodes = straight(((0, 0, 0), (3e-4, 1e-4, 2e-4)))
    view = view_on(nodes, 60.0, 30.0)
    assert view.pixel * view.width * view.magnification == pytest.approx(0.1143)
    places = view.on_image(nodes)[:, :2]
    assert places.min() > RADIUS / view.pixel
    assert (places < np.array([view.width, view.height - view.bar]) - RADIUS / view.pixel).all()


@pytest.mark.parametrize("size", [2e-4, 3.3e-4, 8e-4, 3e-2])
@pytest.mark.parametrize("width", [1024, 2048])
def test_the_scale_is_as_long_as_its_label_says(size: float, width: int) -> None:
    view = view_on(straight(((0, 0, 0), (size, 0.5 * size, 0))), width=width)
    scale = scale_of(view)
    drawn = with_bar(np.zeros((view.height, view.width), dtype=np.uint8), view, (("a", "b"),))
    line = np.flatnonzero(drawn[scale.row, : round(0.2 * width)] == 255)
    assert line[-1] - line[0] + 1 == len(line) == scale.pixels
    number, unit = metric(scale.length, 3).split()
    labelled = float(number) * {"mm": 1e-3, "µm": 1e-6, "nm": 1e-9}[unit]
    assert len(line) * view.pixel == pytest.approx(labelled, abs=0.5 * view.pixel)
    assert number.strip("0.")[0] in "125"
    assert 0.06 * view.width < scale.pixels <= 0.17 * view.width


def test_edges_shine_and_what_lies_below_is_darker() -> None:
    upper, lower = ((0, 1e-4, 3e-5), (2e-4, 1e-4, 3e-5)), ((1e-4, 0, 0), (1e-4, 2e-4, 0))
    nodes = straight(upper, lower)
    view = view_on(nodes)
    signal = seen(nodes, view)
    column, row, _ = view.on_image(np.array([[4e-5, 1e-4, 3e-5]]))[0].astype(int)
    across = signal[:, column]
    body = np.flatnonzero(across > 0.5)
    assert across[body[1]] > 1.5 * across[row]
    # The upper yarn hides the lower one, and takes light from it beside the crossing.
    crossing, _, _ = view.on_image(np.array([[1e-4, 1e-4, 0]]))[0].astype(int)
    free = view.on_image(np.array([[1e-4, 2e-5, 0]]))[0].astype(int)[1]
    beside = round(row + 1.6 * RADIUS / view.pixel)
    assert signal[row, crossing] == pytest.approx(across[row], rel=0.1)
    assert signal[beside, crossing] < 0.85 * signal[free, crossing]


def test_the_side_of_the_detector_is_brighter() -> None:
    nodes = straight(((0, 0, 0), (2e-4, 0, 0)))
    view = view_on(nodes)
    # A step of silicon: its shadow falls to the side that the detector does not stand on.
    azimuth = np.radians(MICROSCOPE.collector_azimuth.value)
    assert np.sin(azimuth) > 0.5
    wall = Block(np.array([-1e-4, 2e-5, -1e-4]), np.array([3e-4, 6e-5, 5e-5]), printed=False)
    floor = Block(np.array([-1e-3, -1e-3, -2e-4]), np.array([1e-3, 1e-3, -1e-4]), printed=False)
    signal = seen(nodes, view, (wall, floor))
    (_, above, _), (_, below, _) = view.on_image(np.array([[1e-4, 8e-5, 0], [1e-4, -2e-5, 0]])).astype(int)
    middle = view.width // 2
    assert signal[above, middle] > 1.3 * signal[below, middle]


def test_noise_is_of_the_seed_and_of_counted_electrons() -> None:
    nodes = straight(((0, 0, 0), (2e-4, 0, 0)))
    view = view_on(nodes)
    plate = Block(np.array([-1.0, -1.0, -1e-4]), np.array([1.0, 1.0, -5e-5]), printed=True)
    yarn = tube(nodes, np.zeros(20), RADIUS)
    first, again, other = (image(yarn, (plate,), view, MICROSCOPE, seed) for seed in ([1, 0], [1, 0], [1, 1]))
    assert first.dtype == np.uint8
    assert (first == again).all()
    assert (first != other).mean() > 0.5
    quiet = replace(MICROSCOPE, dose=replace(MICROSCOPE.dose, value=100 * MICROSCOPE.dose.value))
    flat = (slice(20, 120), slice(300, 700))
    rough, smooth = (
        np.diff(one[flat].astype(float), axis=1).std() for one in (first, image(yarn, (plate,), view, quiet, [1, 0]))
    )
    # A tenth, and what rounding to whole grey levels adds.
    assert 0.08 < smooth / rough < 0.2


def plated_run(path: Path) -> RunReader:
    """Write a run of a made-up specimen between two plates, with two images among three frames."""
    pile = [((x, y, 0.0), (x, y, 1e-4)) for x in (0.0, 5e-5, 1e-4) for y in (0.0, 5e-5)]
    size = SpecimenSize(extents={"C": 1e-4, "W": 5e-5, "P": 8e-5}, fibre_radius=RADIUS, convention="specimen")
    lower = np.concatenate([21 * k + np.arange(3) for k in range(len(pile))])
    with RunWriter(
        make_record(
            path,
            protocol="",
            size=size,
            axes=("P",),
            strands=[21] * len(pile),
            instruments=[stage_instrument()],
            provenance={"rig": "sem-microgripper", "seed": 3, "name": "micro", "started": STARTED},
            plates=(lower, lower + 18),
        )
    ) as writer:
        for k, name in enumerate((None, "image", "image")):
            nodes = straight(*pile) * np.array([1.0, 1.0, 1.0 + 0.2 * k])
            edges = len(nodes) - len(pile)
            writer.add_frame(
                Frame(
                    time=20.0 * k,
                    nodes=nodes,
                    axial_strain=np.zeros(edges),
                    bending_strain=np.zeros(edges),
                    contact_force=np.zeros(len(nodes)),
                    strain={"P": 0.2 * k},
                    cycle=1,
                    phase="Stretch",
                    image=name,
                )
            )
    return RunReader(path)


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ...]:
    """Return the images of that run."""
    folder = tmp_path_factory.mktemp("micro")
    run = plated_run(folder / "run.h5")
    return write_images(run, folder / "images", "micro", usual_look(run), lambda *_: None)


def test_files_say_what_the_microscope_did(paths: tuple[Path, ...]) -> None:
    assert [path.name for path in paths] == ["micro_001.tif", "micro_002.tif"]
    for path, time, day in zip(paths, ("23:59:50", "00:00:10"), ("22 Nov 2026", "23 Nov 2026"), strict=True):
        with tifffile.TiffFile(path) as file:
            found = file.sem_metadata
            grey = file.asarray()
            raw = file.pages.first.tags[TAG]
        assert file.is_sem
        assert grey.shape == (768, 1024)
        assert grey.dtype == np.uint8
        assert found is not None
        assert found["ap_date"] == ("Date", day)
        assert found["ap_time"] == ("Time", time)
        assert found["sv_file_name"] == ("File Name", path.name)
        assert found["sv_serial_number"] == ("Serial No.", "KNITLAB-SIMULATED")
        assert found["dp_image_store"] == ("Store resolution", "1024 * 768")
        assert found["dp_detector_channel"] == ("Signal A", "SE2")
        assert found["ap_actualkv"] == ("EHT", 3.0, "kV")
        assert found["ap_wd"] == ("WD", 12.0, "mm")
        assert found["ap_stage_at_t"] == ("Stage at T", 78.0, "°")
        pixel = found[""][3]
        assert found["ap_image_pixel_size"] == ("Image Pixel Size", pytest.approx(1e9 * pixel, rel=1e-3), "nm")
        assert found["ap_width"] == ("Width", pytest.approx(1e6 * 1024 * pixel, rel=1e-3), "µm")
        assert found["ap_height"] == ("Height", pytest.approx(1e6 * 768 * pixel, rel=1e-3), "µm")
        # The magnification is that of a print 114.3 mm wide.
        assert found["ap_mag"] == ("Mag", pytest.approx(0.1143 / (1024 * pixel), rel=1e-3), "X")
        assert raw.dtype == 2


def test_the_tag_is_lines_of_the_instruments_kind(paths: tuple[Path, ...]) -> None:
    data = paths[0].read_bytes()
    begin = data.index(b"AP_MAG\r\nMag = ")
    text = data[begin : data.index(b"\x00", begin)]
    assert text.endswith(b"SV_FILE_NAME\r\nFile Name = micro_001.tif\r\n")
    assert b"\n" not in text.replace(b"\r\n", b"")
    assert b"AP_WIDTH\r\nWidth = " in text
    assert b" \xb5m\r\n" in text  # cp1252


def test_lengths_in_the_image_are_those_of_the_specimen(tmp_path: Path) -> None:
    """The gap between the plates, measured in the image with the file's own pixel size, grows as the frames say."""
    run = plated_run(tmp_path / "run.h5")
    paths = write_images(run, tmp_path, "side", Look(tilt=90.0, rotation=0.0), lambda *_: None)
    gaps = []
    for path in paths:
        with tifffile.TiffFile(path) as file:
            pixel = (file.sem_metadata or {})[""][3]
            grey = file.asarray()[:706].astype(float)
        # Half-way between two yarns of the row: bright plate, dark gap, bright plate.
        column = round(512 + 2.5e-5 / pixel)
        level = grey[:, column - 3 : column + 4].mean(axis=1)
        bright = np.flatnonzero(level > 60.0)
        gaps.append((np.diff(bright).max() - 1) * pixel)
    assert gaps == pytest.approx([1.2 * 8e-5, 1.4 * 8e-5], abs=1.5 * pixel)


def test_frames_without_images_are_those_of_the_picture(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run.h5")
    assert [round(frame.strain["C"], 3) for frame in taken(run)] == [0.0, 0.2, 0.4]
    marked = plated_run(tmp_path / "marked.h5")
    assert [frame.image for frame in taken(marked)] == ["image", "image"]


def test_blocks_stand_around_the_specimen(tmp_path: Path) -> None:
    run = plated_run(tmp_path / "run.h5")
    if run.plates is None:
        pytest.fail("plates were written")
    frame = run.frames()[2]
    substrate, lower, upper, *gripper = fixtures(frame, run.plates, RADIUS)
    assert substrate.high[2] == pytest.approx(lower.low[2])
    assert lower.high[2] == pytest.approx(frame.nodes[run.plates[0], 2].max())
    assert upper.low[2] == pytest.approx(frame.nodes[run.plates[1], 2].min())
    assert upper.low[2] - lower.high[2] == pytest.approx(1.4 * 8e-5)
    assert all(part.high[2] > upper.low[2] or part.low[2] < upper.low[2] for part in gripper)


@pytest.mark.parametrize(
    ("given", "message"),
    [({"tilt": 91.0}, "tilt: found 91"), ({"rotation": 500.0}, "rotation"), ({"width": 1000}, "1024 or 2048")],
)
def test_a_look_that_no_stage_has_is_refused(given: dict[str, float], message: str) -> None:
    with pytest.raises(SpecificationError, match=message):
        replace(Look(tilt=0.0, rotation=0.0), **given)  # type: ignore[arg-type]


def test_every_number_of_the_microscope_has_a_source(tmp_path: Path) -> None:
    numbers = [
        getattr(MICROSCOPE, name) for name in MICROSCOPE.__slots__ if name not in {"microscope", "serial", "signal"}
    ]
    assert all(one.source for one in numbers)
    bad = tmp_path / "bad.yaml"
    bad.write_text("microscope: x\n")
    with pytest.raises(FormatError, match="also"):
        read_microscope(bad)


def test_a_run_ends_with_its_images_and_one_without_any_has_none(tmp_path: Path) -> None:
    (tmp_path / "micro").mkdir()
    run = plated_run(tmp_path / "micro" / "run.h5")
    told: list[str] = []
    written = images_of(run, tmp_path / "micro", "micro", lambda _, text: told.append(text))
    assert [path.relative_to(tmp_path).as_posix() for path in written] == [
        "micro/images/micro_001.tif",
        "micro/images/micro_002.tif",
    ]
    assert told == ["rendering image 1 of 2", "rendering image 2 of 2"]
    assert images_of(make_run(tmp_path / "run.h5"), tmp_path, "synthetic", lambda *_: None) == ()
    assert not (tmp_path / "images").exists()


def test_the_command_renders_a_run_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plated_run(tmp_path / "run.h5")
    images(tmp_path, tilt=60.0, width=1024, out=tmp_path / "again", quiet=True)
    assert capsys.readouterr().out.splitlines() == [f"image: {tmp_path}/again/micro_00{k}.tif" for k in (1, 2)]
    with tifffile.TiffFile(tmp_path / "again" / "micro_001.tif") as file:
        said = file.sem_metadata or {}
    assert (said["ap_stage_at_t"][1], said["ap_stage_at_r"][1]) == (60.0, 24.0)
    with pytest.raises(SpecificationError, match="tilt"):
        images(tmp_path, tilt=120.0, quiet=True)
