from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from knitlab_core.errors import SpecificationError
from rigs.protocol.protocol import (
    Cycle,
    ForceRate,
    Hold,
    Image,
    LogSpec,
    Preload,
    Protocol,
    Ramp,
    Repeat,
    SpecimenSpec,
    StrainRate,
    Target,
    Until,
    UntilRupture,
    Zero,
    stroke_count,
)

if TYPE_CHECKING:
    from collections.abc import Callable

SPECIMEN: dict[str, Any] = {
    "knit": "stockinette-default",
    "rows": 6,
    "loops": 6,
    "loop_width": 8e-3,
    "material": "RGD8530-DM",
}
CYCLE: dict[str, Any] = {"axes": ("C", "W"), "lower": 0.0, "upper": 0.4, "rate": 2e-4, "n": 2}
FRAME: dict[str, Any] = {"rig": "uniaxial-frame", "mount": "W", "others": "free", "steps": (Zero(),)}
PRELOAD: dict[str, Any] = {"axes": ("C",), "force": 0.05, "rate": 2e-4}


def whole(**changes: Any) -> Protocol:  # noqa: ANN401 (whatever is wrong)
    values: dict[str, Any] = {
        "specimen": SpecimenSpec(**SPECIMEN),
        "speed_ref": "pair",
        "others": "hold",
        "steps": (Zero(), Cycle(**CYCLE)),
    }
    return Protocol(**(values | changes))


def test_a_plain_protocol_has_the_labs_defaults() -> None:
    protocol = whole()
    assert protocol.specimen.friction == 0.3
    assert protocol.specimen.nodes_per_loop == 48
    assert protocol.log == LogSpec(rate=10.0, noise=True, seed=0)
    assert (protocol.rig, protocol.hook) == ("biaxial-hook", "pin")


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: SpecimenSpec(**SPECIMEN | {"knit": "brioche"}), "knit"),
        (lambda: SpecimenSpec(**SPECIMEN | {"rows": 0}), "rows"),
        (lambda: SpecimenSpec(**SPECIMEN | {"layers": 2}), "layers"),
        (lambda: SpecimenSpec(**SPECIMEN | {"knit": "volumetric-default", "layers": 0}), "layers"),
        (lambda: SpecimenSpec(**SPECIMEN | {"knit": "volumetric-default", "layers": 200, "rows": 9}), "loops"),
        (lambda: SpecimenSpec(**SPECIMEN | {"rows": 200, "loops": 200}), "loops"),
        (lambda: SpecimenSpec(**SPECIMEN | {"loop_width": 0.0}), "loop_width"),
        (lambda: SpecimenSpec(**SPECIMEN | {"loop_width": float("nan")}), "loop_width"),
        (lambda: SpecimenSpec(**SPECIMEN | {"material": "cheese"}), "material"),
        (lambda: SpecimenSpec(**SPECIMEN | {"friction": -0.1}), "friction"),
        (lambda: SpecimenSpec(**SPECIMEN | {"nodes_per_loop": 4}), "nodes_per_loop"),
        (lambda: LogSpec(rate=0.0), "rate"),
        (lambda: LogSpec(seed=-1), "seed"),
        (lambda: Target(kind="strain", value=-1.0), "strain"),
        (lambda: Target(kind="displacement", value=11.0), "displacement"),
        (lambda: Zero(channels=()), "channels"),
        (lambda: Zero(channels=("force", "force")), "channels"),
        (lambda: Preload(**PRELOAD | {"axes": ()}), "axes"),
        (lambda: Preload(**PRELOAD | {"axes": ("C", "C")}), "axes"),
        (lambda: Preload(**PRELOAD | {"force": 0.0}), "force"),
        (lambda: Ramp(axes=("C",), to=Target(kind="strain", value=0.1), rate=0.0), "rate"),
        (lambda: Hold(duration=0.0), "duration"),
        (lambda: Hold(duration=1.0, tag="../up"), "tag"),
        (lambda: Cycle(**CYCLE | {"upper": 0.0}), "upper"),
        (lambda: Cycle(**CYCLE | {"n": 0}), "n"),
        (lambda: Repeat(n=0, steps=(Zero(),)), "n"),
        (lambda: Repeat(n=1, steps=()), "steps"),
        (lambda: whole(steps=(Repeat(n=10_000, steps=(Cycle(**CYCLE | {"n": 100}),)),)), "steps"),
        (lambda: whole(name="a/b"), "name"),
        (lambda: whole(max_strain_increment=0.0), "max_strain_increment"),
        (lambda: whole(others="drift"), "others"),
        (lambda: Ramp(axes=("C",), to=Target(kind="force", value=1.0), rate=1e-3), "rate"),
        (lambda: Ramp(axes=("C",), to=Target(kind="strain", value=1.0), rate=1e-3, control="force"), "to"),
        (lambda: Ramp(axes=("C",), to=Target(kind="strain", value=1.0), rate=ForceRate(value=1.0)), "rate"),
        (lambda: StrainRate(value=0.0), "rate"),
        (lambda: ForceRate(value=-1.0), "rate"),
        (Until, "until"),
        (lambda: Until(time=0.0), "until.time"),
        (lambda: Until(drop=0.0), "until.drop"),
        (lambda: Until(strain=-1.0), "until.strain"),
        (lambda: Hold(duration=1.0, control="force"), "axes"),
        (lambda: UntilRupture(axes=("C",), rate=1e-3, drop=2.0), "drop"),
        (lambda: UntilRupture(axes=("C",), rate=1e-3, control="force"), "control"),
        (lambda: Image(every=0.0), "every"),
        (lambda: Cycle(**CYCLE | {"control": "force"}), "rate"),
        (lambda: whole(steps=(UntilRupture(axes=("P",), rate=1e-3),)), "steps[0].until_rupture.axes"),
        (lambda: whole(mount="C"), "mount"),
        (lambda: whole(**FRAME | {"mount": None}), "mount"),
        (lambda: whole(**FRAME | {"mount": "P"}), "mount"),
        (lambda: whole(**FRAME | {"others": "hold"}), "others"),
        (lambda: whole(**FRAME | {"steps": (Zero(), Cycle(**CYCLE))}), "steps[1].cycle.axes"),
        (lambda: whole(steps=(Cycle(**CYCLE | {"axes": ("P",)}),)), "steps[0].cycle.axes"),
    ],
)
def test_a_value_out_of_range_is_refused_where_it_is_said(make: Callable[[], object], field: str) -> None:
    with pytest.raises(SpecificationError) as raised:
        make()
    assert raised.value.field == field


def test_strokes_are_counted_without_making_them() -> None:
    huge = Repeat(n=10_000, steps=(Repeat(n=10_000, steps=(Cycle(**CYCLE | {"n": 10_000}),)),))
    assert stroke_count([Zero(), huge]) == 1 + 2 * 10**12
