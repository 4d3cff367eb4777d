import numpy as np
import pytest

from knitlab_core.knits import NAMED_STITCHES, Centreline, planar_line, yarn_per_loop
from knitlab_core.knits.directors import directors
from tests.curves import Helix, Straight, double_bend, yarn_of

DEFAULT = NAMED_STITCHES["stockinette-default"]
YARNS = {
    "knit": planar_line(DEFAULT, rows=2, loops=1),
    "paper-fit": planar_line(NAMED_STITCHES["paper-fit"], rows=2, loops=1),
    "S": double_bend(0.3),
    "straight": yarn_of(Straight(length=2.0)),
    "helix": yarn_of(Helix(radius=0.3, rise=0.1, length=5.0)),
}


@pytest.mark.parametrize("yarn", YARNS.values(), ids=YARNS)
def test_directors_and_tangent_are_a_right_handed_frame(yarn: Centreline) -> None:
    s = np.linspace(0.0, yarn.length, 501)
    e2, e3 = directors(yarn, s)
    frame = np.stack([yarn.tangent(s), e2, e3], axis=1)
    np.testing.assert_allclose(frame @ frame.transpose(0, 2, 1), np.tile(np.eye(3), (s.size, 1, 1)), atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(frame), 1.0, rtol=1e-13)


@pytest.mark.parametrize("yarn", YARNS.values(), ids=YARNS)
def test_directors_never_flip(yarn: Centreline) -> None:
    s = np.linspace(0.0, yarn.length, 4001)
    e2, e3 = directors(yarn, s)
    # A frame that does not turn about the yarn turns by the bend alone, curvature times step.
    bend = np.linalg.norm(yarn.curvature(s), axis=-1).max() * s[1]
    for director in (e2, e3):
        turned = np.linalg.norm(np.diff(director, axis=0), axis=-1)
        assert turned.max() <= 1.001 * bend + 1e-12
    assert bend < 0.1


@pytest.mark.parametrize("yarn", YARNS.values(), ids=YARNS)
def test_directors_do_not_turn_about_the_yarn(yarn: Centreline) -> None:
    s = np.linspace(0.0, yarn.length, 4001)
    e2, e3 = directors(yarn, s)
    about = np.sum((e2[2:] - e2[:-2]) * e3[1:-1], axis=-1) / 2.0
    # What is left is of third order in the step, of second where curvature jumps.
    assert np.abs(about).max() < 1e-4
    assert abs(np.sum(about)) < 1e-3


def test_frenet_s_frame_would_flip_where_this_one_does_not() -> None:
    yarn = double_bend()
    around = yarn.starts[1] + np.array([-1e-6, 1e-6])
    normals = yarn.curvature(around)
    assert normals[0] @ normals[1] == pytest.approx(-1.0)
    e2, _ = directors(yarn, around)
    assert e2[0] @ e2[1] == pytest.approx(1.0)


def test_a_yarn_in_a_plane_keeps_the_director_out_of_it() -> None:
    yarn = double_bend()
    e2, _ = directors(yarn, np.linspace(0.0, yarn.length, 50))
    np.testing.assert_allclose(e2, np.tile([0.0, 0.0, 1.0], (50, 1)), atol=1e-14)


def test_on_a_helix_frenet_s_frame_turns_against_it_by_the_torsion() -> None:
    shape = Helix(radius=0.3, rise=0.2, length=6.0)
    yarn = yarn_of(shape)
    s = np.linspace(0.0, 6.0, 40)
    e2, e3 = directors(yarn, s)
    normal = yarn.curvature(s)
    angle = np.unwrap(np.arctan2(np.sum(normal * e3, axis=-1), np.sum(normal * e2, axis=-1)))
    torsion = shape.rise / shape.speed**2
    np.testing.assert_allclose(angle - angle[0], torsion * s, atol=1e-5)


@pytest.mark.parametrize("name", NAMED_STITCHES)
def test_a_loop_brings_the_directors_back(name: str) -> None:
    yarn = planar_line(NAMED_STITCHES[name], rows=1, loops=2)
    feet = yarn_per_loop(NAMED_STITCHES[name]) * np.arange(3.0)
    e2, _ = directors(yarn, feet)
    np.testing.assert_allclose(e2, np.tile([0.0, 0.0, 1.0], (3, 1)), atol=1e-9)


def test_directors_do_not_depend_on_the_spots_asked_for() -> None:
    yarn = YARNS["knit"]
    few = np.array([3.1, 0.0, 7.77, 3.1 + 1e-14])
    e2, _ = directors(yarn, few)
    many = np.concatenate([np.linspace(0.0, yarn.length, 999), few])
    np.testing.assert_allclose(directors(yarn, many)[0][-4:], e2, atol=1e-6)
    np.testing.assert_allclose(e2[0], e2[3], atol=1e-12)


def test_a_yarn_that_starts_out_of_the_plane_has_directors_too() -> None:
    yarn = yarn_of(Helix(radius=0.3, rise=0.01, length=1.0))
    assert yarn.tangent(np.zeros(1))[0, 2] > 0.99
    e2, _ = directors(yarn, np.zeros(1))
    assert e2[0, 0] > 0.99
