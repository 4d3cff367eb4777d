from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hypothesis import given, settings
from hypothesis import strategies as st

from app.schemas import ProtocolError, from_yaml, to_yaml
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import NAMED_STITCHES, NAMED_VOLUMETRIC_STITCHES, Counts, Stitch, VolumetricStitch, same_area
from knitlab_core.materials import MATERIALS, Material, RelaxationTerm, Value
from rigs.protocol.protocol import (
    Cycle,
    Extensometer,
    ForceRate,
    Hold,
    Image,
    LogSpec,
    Preload,
    Protocol,
    Ramp,
    Rate,
    Repeat,
    SpecimenSpec,
    Step,
    StrainRate,
    Target,
    Until,
    UntilRupture,
    Waveform,
    Zero,
)
from rigs.protocol.targets import Bound
from tests.planned import planned_strokes

if TYPE_CHECKING:
    from rigs.axes import Axis

STAGE_AXES: st.SearchStrategy[tuple[Axis, ...]] = st.sampled_from([("C",), ("W",), ("C", "W"), ("W", "C")])
WAYS: st.SearchStrategy[Rate] = st.floats(1e-9, 1.0) | st.builds(StrainRate, value=st.floats(1e-9, 100.0))
FORCE_RATES = st.builds(ForceRate, value=st.floats(1e-9, 1e4))
LABELS = st.from_regex(r"[A-Za-z0-9]([A-Za-z0-9 ._-]{0,20}[A-Za-z0-9._-])?", fullmatch=True)
TAGS = st.none() | LABELS
STRAINS = st.floats(-0.9, 5.0)
LENGTHS = st.floats(-10.0, 10.0)
FORCES = st.floats(-1e4, 1e4)
PLACES = st.builds(Target, kind=st.just("strain"), value=STRAINS) | st.builds(
    Target, kind=st.just("displacement"), value=LENGTHS
)
CHANNELS = st.sampled_from([("force",), ("displacement",), ("force", "displacement")])
TIMES = st.floats(1e-9, 1e7)
SIDES = st.sampled_from([">", "<"])


def bounds(levels: st.SearchStrategy[float]) -> st.SearchStrategy[float | Bound | None]:
    """Return levels that end a step, some with the side that counts."""
    return st.none() | levels | st.builds(Bound, side=SIDES, value=levels)


ENDS = st.none() | st.builds(
    Until,
    force=bounds(FORCES),
    strain=bounds(STRAINS),
    displacement=bounds(LENGTHS),
    time=TIMES,
    drop=st.none() | st.floats(1e-6, 1.0),
)
WAY = st.sampled_from([None, "strain", "displacement"])
LEVELS = {"strain": STRAINS, "displacement": LENGTHS, "force": FORCES}


def cycles_on(axes: st.SearchStrategy[tuple[Axis, ...]], control: str) -> st.SearchStrategy[Step]:
    """Return cycles of some axes under one kind of control."""
    level = LEVELS[control]
    ends = st.tuples(level, level).filter(lambda pair: pair[0] < pair[1])
    return st.builds(
        lambda ends, **rest: Cycle(lower=ends[0], upper=ends[1], **rest),
        ends=ends,
        axes=axes,
        control=st.just(control),
        rate=FORCE_RATES if control == "force" else WAYS,
        n=st.integers(1, 5),
        until=ENDS,
        tag=TAGS,
    )


def waveforms_on(
    axes: st.SearchStrategy[tuple[Axis, ...]], kind: str, levels: st.SearchStrategy[float]
) -> st.SearchStrategy[Waveform]:
    """Return waveforms of some pieces."""
    times = st.lists(TIMES, min_size=1, max_size=4, unique=True).map(lambda after: (0.0, *sorted(after)))
    points = times.flatmap(lambda all_of_them: st.tuples(*(st.tuples(st.just(time), levels) for time in all_of_them)))
    return st.builds(Waveform, axes=axes, points=points, kind=st.just(kind), until=ENDS, tag=TAGS)


def steps_on(axes: st.SearchStrategy[tuple[Axis, ...]]) -> st.SearchStrategy[Step | Repeat]:
    """Return steps that drive some of the axes of a rig."""
    drives = {"axes": axes, "until": ENDS, "tag": TAGS}
    forced = {**drives, "rate": FORCE_RATES, "control": st.just("force")}
    loads = st.floats(1e-9, 1e4)
    single: st.SearchStrategy[Step | Repeat] = (
        st.builds(Zero, channels=CHANNELS)
        | st.builds(Preload, force=loads, rate=WAYS, control=WAY, **drives)
        | st.builds(Preload, force=loads, **forced)
        | st.builds(Ramp, to=PLACES, rate=WAYS, control=WAY, **drives)
        | st.builds(Ramp, to=st.builds(Target, kind=st.just("force"), value=FORCES), **forced)
        | st.builds(Hold, duration=TIMES, until=ENDS, tag=TAGS)
        | st.builds(Hold, duration=TIMES, axes=axes, control=st.sampled_from([None, "strain", "force"]), tag=TAGS)
        | cycles_on(axes, "strain")
        | cycles_on(axes, "displacement")
        | cycles_on(axes, "force")
        | st.builds(UntilRupture, rate=WAYS, control=WAY, drop=st.floats(1e-6, 1.0), to=st.none() | PLACES, **drives)
        | waveforms_on(axes, "strain", STRAINS)
        | waveforms_on(axes, "displacement", LENGTHS)
        | waveforms_on(axes, "force", FORCES)
        | st.builds(Image, every=st.none() | st.just("off") | TIMES, tag=TAGS)
    )
    return st.recursive(
        single,
        lambda inner: st.builds(Repeat, n=st.integers(1, 3), steps=st.lists(inner, min_size=1, max_size=3).map(tuple)),
        max_leaves=5,
    )


STITCHES = st.builds(
    Stitch,
    curvature=st.floats(0.1, 5.0),
    height=st.floats(0.1, 10.0),
    depth=st.floats(0.1, 10.0),
    row_spacing=st.floats(0.1, 10.0),
    fibre_radius=st.floats(1e-3, 0.5),
)
YARNS = st.builds(
    lambda radius, count, model, bonding, gap: replace(
        same_area(radius, count, gap=gap, model=model), bonding=bonding, twist=0.1, phase=0.2
    ),
    radius=st.floats(1e-3, 0.05),
    count=st.integers(1, 12),
    model=st.sampled_from(["yarn", "bundle"]),
    bonding=st.floats(0.0, 1.0),
    gap=st.floats(0.1, 1.0),
)
LAWS = st.builds(
    BondLaw,
    fuse_gap=st.floats(1e-9, 1e-2),
    patch_radius=st.floats(1e-9, 1e-2),
    strength=st.floats(1.0, 1e12),
    shear_strength=st.none() | st.floats(1.0, 1e12),
    locate=st.floats(1e-6, 0.9),
)
ORIGINS = st.fixed_dictionaries({"source": LABELS, "assumed": st.booleans()})


def values(low: float, high: float, unit: str) -> st.SearchStrategy[Value]:
    """Return numbers with a source."""
    return st.builds(lambda number, origin: Value(value=number, unit=unit, **origin), st.floats(low, high), ORIGINS)


def series(terms: list[tuple[float, float]], origin: dict[str, Any]) -> tuple[RelaxationTerm, ...]:
    """Return a Prony series of one source."""
    return tuple(
        RelaxationTerm(share=Value(value=share, unit="1", **origin), time=Value(value=time, unit="s", **origin))
        for share, time in terms
    )


RESINS = st.builds(
    Material,
    name=st.just("own-resin"),
    young_modulus=values(1e3, 1e12, "Pa"),
    poisson_ratio=values(-0.9, 0.5, "1"),
    strength=values(1.0, 1e9, "Pa"),
    elongation_at_break=st.none() | values(1e-3, 2.0, "1"),
    density=st.none() | values(1.0, 1e4, "kg/m**3"),
    relaxation=st.builds(
        series,
        st.lists(st.tuples(st.floats(1e-6, 0.3), st.floats(1e-9, 1e9)), min_size=1, max_size=3),
        ORIGINS,
    ),
    note=st.just("") | LABELS,
)
OWN_SPECIMENS = st.builds(
    lambda straight, law, **rest: SpecimenSpec(
        rest_shape="straight" if straight else "as-printed", fused=None if straight else law, **rest
    ),
    straight=st.booleans(),
    law=st.none() | LAWS,
    knit=st.sampled_from(sorted(NAMED_STITCHES)),
    rows=st.integers(1, 50),
    loops=st.integers(1, 50),
    loop_width=st.floats(1e-6, 1.0),
    material=RESINS,
    yarn=st.none() | YARNS,
    viscoelastic=st.booleans(),
    rupture=st.sampled_from(["off", "stop", "go on"]),
)
SPECIMENS = st.builds(
    SpecimenSpec,
    knit=st.sampled_from(sorted(NAMED_STITCHES)) | STITCHES,
    rows=st.integers(1, 50),
    loops=st.integers(1, 50),
    loop_width=st.floats(1e-6, 1.0),
    material=st.sampled_from(sorted(MATERIALS)),
    friction=st.floats(0.0, 2.0),
    nodes_per_loop=st.integers(8, 1000),
)
VOLUMETRIC_STITCHES = st.builds(
    lambda reach, **values: VolumetricStitch(
        wale_height=reach * values["row_spacing"], pile_height=reach * values["layer_spacing"], **values
    ),
    reach=st.floats(1.1, 2.0),
    curvature=st.floats(0.1, 5.0),
    depth=st.floats(0.1, 10.0),
    row_spacing=st.floats(0.1, 5.0),
    layer_spacing=st.floats(0.1, 5.0),
    fibre_radius=st.floats(1e-3, 0.5),
)
VOLUMETRIC_SPECIMENS = st.builds(
    SpecimenSpec,
    knit=st.sampled_from(sorted(NAMED_VOLUMETRIC_STITCHES)) | VOLUMETRIC_STITCHES,
    rows=st.integers(1, 10),
    loops=st.integers(1, 10),
    layers=st.integers(1, 10),
    loop_width=st.floats(1e-6, 1.0),
    material=st.sampled_from(sorted(MATERIALS)),
)
STAGES = st.fixed_dictionaries(
    {
        "specimen": SPECIMENS | VOLUMETRIC_SPECIMENS | OWN_SPECIMENS,
        "others": st.sampled_from(["hold", "free", "follow"]),
        "steps": st.lists(steps_on(STAGE_AXES), min_size=1, max_size=4).map(tuple),
    }
)


def frames_along(axis: Axis) -> st.SearchStrategy[dict[str, Any]]:
    """Return what stands in a protocol for the frame."""
    return st.fixed_dictionaries(
        {
            "rig": st.just("uniaxial-frame"),
            "mount": st.just(axis),
            "specimen": VOLUMETRIC_SPECIMENS if axis == "P" else SPECIMENS | VOLUMETRIC_SPECIMENS,
            "others": st.just("free"),
            "steps": st.lists(steps_on(st.just((axis,))), min_size=1, max_size=3).map(tuple),
        }
    )


def can_hang(specimen: SpecimenSpec) -> bool:
    """Tell whether a specimen can hang on wires."""
    one_rod = specimen.yarn is None or specimen.yarn.model == "yarn"
    return "P" not in specimen.axes and one_rod and specimen.rest_shape == "as-printed"


def can_clamp(specimen: SpecimenSpec) -> bool:
    """Tell whether clamps can hold a specimen."""
    faces = specimen.fabric.clamp_faces(Counts(specimen.rows, specimen.loops, specimen.layers))
    return bool(faces) and all(low < high for low, high in faces.values())


def held(holder: str, rig: dict[str, Any], pole_friction: float | None) -> dict[str, Any]:
    """Return what stands in a protocol for what holds its specimen on a rig."""
    specimen, mount = rig["specimen"], rig.get("mount")
    if holder == "clamps" and can_clamp(specimen):
        return {"grips": "clamps"}
    if holder == "clamps on one axis" and can_clamp(specimen):
        return {"grips": {mount or "W": "clamps"}, "pole_friction": None if mount else pole_friction}
    hook = "wire" if holder == "wires" and can_hang(specimen) else "pin"
    return {"hook": hook, "pole_friction": pole_friction}


def pins_in(specimen: SpecimenSpec) -> Extensometer | None:
    """Return an extensometer for a specimen; None where it has one stitch along every axis."""
    made = Extensometer.inner_half(specimen.counts)
    return made if made.pairs else None


PROTOCOLS = st.builds(
    lambda rig, holder, rubs, pinned, **rest: Protocol(
        **held(holder, rig, rubs), extensometer=pins_in(rig["specimen"]) if pinned else None, **rig, **rest
    ),
    rig=STAGES | frames_along("C") | frames_along("W") | frames_along("P"),
    holder=st.sampled_from(["pins", "wires", "clamps", "clamps on one axis"]),
    rubs=st.none() | st.floats(0.0, 2.0),
    pinned=st.booleans(),
    speed_ref=st.sampled_from(["pair", "grip"]),
    log=st.builds(
        LogSpec,
        rate=st.floats(1e-3, 1e4),
        events=st.none() | st.floats(1e-3, 1e4),
        every_cycle=st.integers(1, 100),
        noise=st.booleans(),
        seed=st.integers(0, 2**63 - 1),
    ),
    name=LABELS,
    max_strain_increment=st.floats(1e-5, 0.1),
)
# The first example loads the unit registry, which takes longer than any deadline.
patient = settings(deadline=None)
EXAMPLE = (Path(__file__).parents[2] / "examples" / "biaxial_small.yaml").read_text(encoding="utf-8")
GAUGES: dict[Axis, float] = {"C": 20.0, "W": 30.0, "P": 25.0}


@patient
@given(PROTOCOLS)
def test_a_protocol_reads_back_as_itself(protocol: Protocol) -> None:
    assert from_yaml(to_yaml(protocol)) == protocol


@patient
@given(PROTOCOLS)
def test_strokes_join_and_keep_their_speed(protocol: Protocol) -> None:
    last: dict[Axis, float] = dict.fromkeys(protocol.axes, 0.0)
    cycle = 1
    try:
        for stroke in planned_strokes(protocol, {axis: GAUGES[axis] for axis in protocol.axes}):
            assert dict(stroke.start) == last
            assert stroke.cycle in {cycle, cycle + 1}
            assert math.isfinite(stroke.duration)
            assert stroke.duration > 0.0 or stroke.phase == "Zero"
            assert (stroke.start == stroke.end) == (stroke.phase in {"Zero", "Hold"} or bool(stroke.force))
            last, cycle = dict(stroke.start if stroke.stop_force is not None else stroke.end), stroke.cycle
    except SpecificationError as error:
        assert "displacement" in str(error)  # noqa: PT017 (steps that add up to nothing between the hooks)


@patient
@given(
    st.integers(0, len(EXAMPLE)),
    st.integers(0, 20),
    st.text(max_size=8) | st.sampled_from([*"{}[]&*!|>%@`'\":,#-\n\t"]),
)
def test_a_spoilt_example_is_at_worst_an_error_of_one_line(at: int, cut: int, insert: str) -> None:
    one_line_at_worst(EXAMPLE[:at] + insert + EXAMPLE[at + cut :])


@patient
@given(st.text(max_size=200))
def test_any_text_is_at_worst_an_error_of_one_line(text: str) -> None:
    one_line_at_worst(text)


def one_line_at_worst(text: str) -> None:
    try:
        from_yaml(text)
    except ProtocolError as error:
        line = str(error)
        assert line.startswith("<protocol>:")
        assert "\n" not in line
