"""Images of tubes are to scale, coloured by value, and tell over from under."""

import numpy as np
import pytest

from app.views.tube_images import tube_images
from app.views.tubes import Tube

WINDOW = (0.0, 10.0, 0.0, 6.0)
PIXELS = 20.0
#: Red, green, blue.
TABLE = np.eye(3)


def line(begin: tuple[float, float, float], end: tuple[float, float, float], count: int = 41) -> np.ndarray:
    share = np.linspace(0.0, 1.0, count)[:, None]
    return np.asarray(np.array(begin) + share * (np.array(end) - np.array(begin)))


def tubes(*lines: np.ndarray, radius: float = 0.5, values: float = 0.0) -> Tube:
    points = np.concatenate(lines)
    sizes = np.array([len(one) for one in lines])
    return Tube(points=points, values=np.full(len(points), values), radius=radius, sizes=sizes)


def image(one: Tube) -> np.ndarray:
    (found,) = tube_images([one], WINDOW, pixels=PIXELS, limits=(0.0, 3.0), table=TABLE)
    return found.astype(float)


def test_a_tube_is_as_wide_and_where_the_window_says() -> None:
    found = image(tubes(line((2.0, 4.0, 0.0), (8.0, 4.0, 0.0)), radius=0.4))
    assert found.shape == (120, 200, 3)
    rows = np.flatnonzero(found[:, 100].min(axis=1) < 250.0)
    assert len(rows) / PIXELS == pytest.approx(0.8, abs=0.1)
    # Up is up: y = 4 of 6 mm is a third from the top.
    assert 0.5 * (rows[0] + rows[-1] + 1) / PIXELS == pytest.approx(2.0, abs=0.05)
    columns = np.flatnonzero(found[40].min(axis=1) < 250.0)
    assert columns[0] / PIXELS == pytest.approx(2.0 - 0.4, abs=0.1)
    assert (columns[-1] + 1) / PIXELS == pytest.approx(8.0 + 0.4, abs=0.1)
    assert (found[:20] == 255.0).all()


@pytest.mark.parametrize(("value", "channel"), [(0.5, 0), (1.5, 1), (2.9, 2), (-7.0, 0), (7.0, 2)])
def test_the_colour_is_that_of_the_value(value: float, channel: int) -> None:
    pixel = image(tubes(line((2.0, 3.0, 0.0), (8.0, 3.0, 0.0)), values=value))[60, 100]
    others = np.delete(pixel, channel)
    assert pixel[channel] > others.max() + 100.0


def test_what_lies_above_hides_and_shades_what_lies_below() -> None:
    upper, lower = line((5.0, 0.0, 1.0), (5.0, 6.0, 1.0)), line((0.0, 3.0, 0.0), (10.0, 3.0, 0.0))
    for pieces in ((upper, lower), (lower, upper)):
        found = image(tubes(*pieces))
        # Along the lower one: under the upper one its light is that of the upper one far from the crossing.
        assert found[60, 100] == pytest.approx(found[110, 100], abs=2.0)
        beside, far = found[60, 112].sum(), found[60, 40].sum()
        assert beside < 0.8 * far


def test_the_side_towards_the_lamp_is_brighter() -> None:
    found = image(tubes(line((0.0, 3.0, 0.0), (10.0, 3.0, 0.0)), radius=1.5, values=1.5))[:, 100].sum(axis=1)
    assert found[60 - 15] > found[60 + 15] + 10.0


def test_pieces_are_not_joined() -> None:
    found = image(tubes(line((0.5, 3.0, 0.0), (3.0, 3.0, 0.0)), line((7.0, 3.0, 0.0), (9.5, 3.0, 0.0))))
    assert (found[:, 80:120] == 255.0).all()


@pytest.mark.parametrize("count", [8, 15, 120])
def test_nothing_that_is_seen_of_a_tube_is_left_out(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    # A helix with sharp bends where points are few, and a piece that goes straight to the eye.
    turn = np.linspace(0.0, 12.0, count)
    helix = np.stack([5.0 + 3.0 * np.cos(turn), 3.0 + 2.0 * np.sin(turn), 2.0 * np.sin(3.0 * turn)], axis=1)
    one = tubes(helix, line((1.0, 1.0, -1.0), (1.0, 1.0, 3.0)))
    culled = image(one)
    monkeypatch.setattr(
        "app.views.tube_images.reaches_of", lambda points, _, radius: np.full((len(points) - 1, 2), radius + 1)
    )
    assert (image(one) == culled).all()
