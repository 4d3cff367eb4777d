from __future__ import annotations

import numpy as np
import pytest

from knitlab_core.errors import SpecificationError
from knitlab_core.knits import Fabric, Filament, Pin, Specimen, Yarn, fabric_named, knit_specimen, pin_spots, same_area

PINS = (Pin(row=0, loop=2), Pin(row=2, loop=1))


def knit(fabric: str | Fabric, nodes: int = 24, yarn: Yarn | None = None, layers: int = 1) -> Specimen:
    made = fabric_named(fabric) if isinstance(fabric, str) else fabric
    return knit_specimen(made, loop_width=8e-3, rows=3, loops=3, layers=layers, nodes_per_loop=nodes, yarn=yarn)


@pytest.mark.parametrize(
    ("name", "nodes"), [("stockinette-default", 16), ("stockinette-default", 61), ("rib-1x1", 24), ("garter", 24)]
)
def test_a_pin_is_on_the_base_line_of_its_row_a_quarter_stitch_from_its_middle_at_any_mesh(
    name: str, nodes: int
) -> None:
    made = knit(name, nodes)
    places = pin_spots(made, PINS).places(made.nodes) / made.loop_width
    spacing = made.fabric.clamp_faces(made.counts)["W"][0] * 2.0
    assert places[:, 0] == pytest.approx([1.25, 0.25], abs=2e-3)
    assert places[:, 1] == pytest.approx([-spacing, spacing], abs=2e-3)


def test_a_pin_is_where_the_yarn_has_its_arc_length() -> None:
    made = knit("stockinette-default", 40)
    found = pin_spots(made, PINS).places(made.nodes)
    arcs = np.array([made.fabric.leg(made.centreline, made.counts, pin) for pin in PINS], dtype=np.float64)
    exact = made.centreline.position(arcs) - made.fabric.middle(made.counts)
    assert found / made.loop_width == pytest.approx(exact, abs=2e-4)


def test_a_pin_of_a_volumetric_knit_is_in_its_layer() -> None:
    made = knit("volumetric-default", 24, layers=2)
    low, high = pin_spots(made, [Pin(row=1, loop=1, layer=0), Pin(row=1, loop=1, layer=1)]).places(made.nodes)
    assert (high - low)[2] / made.loop_width == pytest.approx(made.fabric.layer_spacing, abs=5e-3)  # type: ignore[attr-defined]
    assert (high - low)[0] == pytest.approx(0.0, abs=1e-5)


def test_a_pin_of_a_bundle_is_in_the_middle_of_its_fibres() -> None:
    fabric = fabric_named("stockinette-default")
    bundle = knit(fabric, 40, same_area(fabric.fibre_radius, 3, model="bundle"))
    single = knit(fabric, 40)
    assert pin_spots(bundle, PINS).places(bundle.nodes) == pytest.approx(
        pin_spots(single, PINS).places(single.nodes), abs=2e-5
    )


def test_pins_follow_an_affine_map_exactly() -> None:
    made = knit("stockinette-default")
    spots = pin_spots(made, PINS)
    matrix = np.array([[0.9, 0.1, 0.0], [0.0, 1.4, 0.0], [0.02, 0.0, 1.0]])
    moved = made.nodes @ matrix.T + [1e-3, -2e-3, 5e-3]
    assert spots.places(moved) == pytest.approx(spots.places(made.nodes) @ matrix.T + [1e-3, -2e-3, 5e-3], abs=1e-15)
    assert spots.weights.sum(axis=1) == pytest.approx(1.0)


def test_a_filament_has_no_stitches_for_pins() -> None:
    made = knit_specimen(Filament(fibre_radius=0.01), loop_width=0.1)
    with pytest.raises(SpecificationError, match="not known"):
        pin_spots(made, PINS)
