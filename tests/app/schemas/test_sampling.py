"""Designs of points that fill ranges: reproducible, extendable, inside their ranges, mistakes named in place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.schemas import ProtocolError, load, load_sweep

if TYPE_CHECKING:
    from pathlib import Path

TEXT = """\
schema: knitlab/protocol@1
rig: biaxial-hook
others: hold
specimen: {knit: stockinette-default, loops: [2, 2], loop: "${loop}", material: RGD8530-DM, friction: "${mu}"}
params: {loop: 8 mm, mu: 0.3}
sample: {points: 9, of: {loop: [4 mm, 12 mm], mu: [0, 0.5]}}
steps:
  - ramp: {axes: [C, W], to: 10 %, rate: 1 mm/s}
"""


def values(text: str, folder: Path) -> list[tuple[float, float]]:
    """Return loop width [mm] and friction at every point."""
    path = folder / "sampled.yaml"
    path.write_text(text)
    return [
        (1e3 * loaded.protocol.specimen.loop_width, loaded.protocol.specimen.friction) for _, loaded in load_sweep(path)
    ]


@pytest.mark.parametrize("method", ["halton", "random", "latin-hypercube"])
def test_points_fill_their_ranges_and_come_again(method: str, tmp_path: Path) -> None:
    text = TEXT.replace("points: 9", f"points: 9, method: {method}, seed: 4")
    found = values(text, tmp_path)
    assert found == values(text, tmp_path)
    assert len(set(found)) == 9
    for low, high, column in ((4.0, 12.0, 0), (0.0, 0.5, 1)):
        shares = sorted((point[column] - low) / (high - low) for point in found)
        assert shares[0] >= 0.0
        assert shares[-1] <= 1.0
        assert shares[-1] - shares[0] > 0.5
        if method == "latin-hypercube":
            assert [int(9 * share) for share in shares] == list(range(9))


@pytest.mark.parametrize("method", ["halton", "random"])
def test_more_points_keep_the_first_ones(method: str, tmp_path: Path) -> None:
    text = TEXT.replace("points: 9", f"points: 9, method: {method}")
    assert values(text.replace("points: 9", "points: 17"), tmp_path)[:9] == values(text, tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("points: 9", "points: 0", "6:18: sample.points: found 0"),
        ("mu: [0, 0.5]", "nu: [0, 0.5]", "a name under params: loop, mu"),
        ("mu: [0, 0.5]", "mu: [0.5, 0]", "the smaller end first"),
        ("mu: [0, 0.5]", "mu: [0, 0.2, 0.5]", "the two ends of a range"),
        ("4 mm, 12 mm", "4 mm, 1.2 cm", "two numbers of one unit"),
        ("4 mm, 12 mm", "small, large", "two numbers of one unit"),
        ("points: 9", "points: 9, method: sobol", "halton, latin-hypercube or random"),
        ("steps:", "sweep: {mu: [0.1]}\nsteps:", "one of the two"),
    ],
)
def test_mistakes_are_named_in_their_place(old: str, new: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "sampled.yaml"
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(ProtocolError, match=r"sampled\.yaml:") as refused:
        load(path)
    assert said in str(refused.value)
