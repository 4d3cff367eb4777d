"""What a protocol has wrong is said all at once, and what is suggested is allowed in that protocol."""

from __future__ import annotations

import pickle
import sys
from typing import TYPE_CHECKING

import pytest

from app.checks.dry_run import dry_run
from app.cli.main import main
from app.records.reader import RunReader
from app.runs.use_cases import run_protocol
from app.schemas import ProtocolError, from_yaml, load, loads, to_yaml
from app.schemas.errors import nearest

if TYPE_CHECKING:
    from pathlib import Path

STAGE = """\
schema: knitlab/protocol@1
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [1, 1], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
others: hold
log: {rate: 10 Hz, noise: off}
steps:
  - zero: {channels: [force]}
  - ramp: {axes: [C], to: {strain: 1 %}, rate: 1 mm/s}
"""
FRAME = STAGE.replace("biaxial-hook", "uniaxial-frame\nmount: C").replace("others: hold\n", "")
CUBE = STAGE.replace("stockinette-default, loops: [1, 1]", "volumetric-default, loops: [1, 1, 1]")
GRIPPER = CUBE.replace("biaxial-hook", "sem-microgripper").replace("others: hold\n", "").replace("[C]", "[P]")


def mistakes_of(text: str) -> list[ProtocolError]:
    with pytest.raises(ProtocolError) as raised:
        loads(text, "p.yaml")
    assert all(isinstance(one, ProtocolError) for one in raised.value.more)
    return [raised.value, *raised.value.more]  # type: ignore[list-item]  # as the line before says


@pytest.mark.parametrize(
    ("text", "old", "new", "says"),
    [
        (STAGE, "biaxial-hook", "biaxial", "or triaxial-shear (did you mean biaxial-hook?)"),
        (STAGE, "biaxial-hook", "Biaxial_Hook", "(did you mean biaxial-hook?)"),
        (STAGE, "biaxial-hook", "frame", "(did you mean uniaxial-frame?)"),
        # A planar knit has no face for the gripper, nor for the third axis.
        (STAGE, "biaxial-hook", "gripper", "shear-frame or triaxial-shear"),
        (CUBE, "biaxial-hook", "gripper", "(did you mean sem-microgripper?)"),
        (STAGE, "biaxial-hook", "triaxal", "shear-frame or triaxial-shear"),
        (STAGE, "[C]", "[X]", "found 'X', allowed C or W (did you mean C?)"),
        (STAGE, "[C]", "[c]", "found 'c', allowed C or W (did you mean C?)"),
        (STAGE, "[C]", "[Z]", "found 'Z', allowed C or W"),
        (STAGE, "[C]", "[pile]", "found 'pile', allowed C or W"),
        (FRAME, "axes: [C]", "axes: [wale]", "found 'wale', allowed C"),
        (FRAME, "mount: C", "mount: course", "mount: found 'course', allowed C or W (did you mean C?)"),
        (GRIPPER, "[P]", "[z]", "found 'z', allowed P (did you mean P?)"),
        (FRAME, "log:", "others: fre\nlog:", "others: found 'fre', allowed free (did you mean free?)"),
        (
            STAGE,
            "others: hold",
            "others: fol",
            "others: found 'fol', allowed hold, free or follow (did you mean follow?)",
        ),
        (CUBE, "friction", "hook: wir, friction", "specimen.hook: found 'wir', allowed pin"),
        (STAGE, "stockinette-default", "stockinette", "(did you mean stockinette-default?)"),
        (STAGE, "stockinette-default", "default", "(did you mean stockinette-default?)"),
        (GRIPPER, "volumetric-default", "default", "(did you mean volumetric-default?)"),
        (STAGE, "RGD8530-DM", "RGD8350-DM", "(did you mean RGD8530-DM?)"),
        # Neither field is one of a rig of one clock that drives all its axes.
        (
            STAGE,
            "noise: off",
            "clock_ofset: 1 s",
            "log.clock_ofset: found an unknown field, allowed rate, events, every_cycle, noise, seed",
        ),
        (
            STAGE,
            "others: hold",
            "others: hold\nmont: C",
            "mont: found an unknown field, allowed schema, name, rig, spec",
        ),
        (FRAME, "mount: C", "mont: C", "steps (did you mean mount?)"),
        (STAGE, "ramp: {", "rmp: {", "(did you mean ramp?)"),
        (
            STAGE,
            "ramp: {axes: [C], to: {strain: 1 %}, rate: 1 mm/s}",
            "until_rupture: {axes: [C], rate: 1 mm/s, control: forc}",
            "control: found 'forc', allowed strain or displacement",
        ),
    ],
)
def test_what_is_suggested_is_near_and_allowed_here(text: str, old: str, new: str, says: str) -> None:
    assert text.count(old) >= 1
    line = str(mistakes_of(text.replace(old, new))[0])
    assert says in line
    if "did you mean" not in says:
        assert "did you mean" not in line


def test_the_words_of_the_tables_are_good_protocols() -> None:
    for text in (STAGE, FRAME, CUBE, GRIPPER):
        assert from_yaml(to_yaml(from_yaml(text))) == from_yaml(text)


def test_one_letter_suggests_only_what_is_alone_with_it() -> None:
    assert nearest("s", ["speed_ref", "steps"]) == ""
    assert nearest("m", ["speed_ref", "mount"]) == " (did you mean mount?)"
    assert nearest("", ["mount"]) == ""


OWN = "{mine: {young_modulus: {value: 1 m, source: a}, poisson_ratio: {value: 0.3, source: a}}}"
EVERYTHING_WRONG = """\
schema: knitlab/protocol@1
name: a/b
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [0, 1], loop: -8 mm, material: RGD8530, friction: 3, hok: pin}
speed_ref: par
others: hold
log: {rate: -1 Hz, seed: -1, noise: loud}
params: {top: 20 %, never: 1}
steps:
  - zero: {channels: [froce]}
  - ramp: {axes: [P], to: "${tp}", rate: 1 mm/s}
  - ramp: {axes: [P], to: 1 %, rate: 1 mm/s}
  - cycle: {axes: [C], lower: 30 %, upper: 10 %, rate: 1 N/s, n: 0, until: {time: 0 s, force: 1 MN}}
  - hold: {for: 0 s, axes: [C, C]}
  - repeat: {n: 2, steps: [hold: {for: 1 kg}, hold: {for: 0 s}]}
"""


def test_all_mistakes_are_said_at_once_in_the_order_of_the_file() -> None:
    found = mistakes_of(EVERYTHING_WRONG)
    assert [one.field for one in found if not one.missing] == [
        "name",
        "specimen.loops",
        "specimen.loop",
        "specimen.material",
        "specimen.friction",
        "specimen.hok",
        "speed_ref",
        "log.rate",
        "log.seed",
        "log.noise",
        "steps[0].zero.channels[0]",
        "steps[1].ramp.to",
        "steps[2].ramp.axes",
        "steps[3].cycle.upper",
        "steps[3].cycle.rate",
        "steps[3].cycle.n",
        "steps[3].cycle.until.time",
        "steps[3].cycle.until.force",
        "steps[4].hold.for",
        "steps[4].hold.axes",
        "steps[5].repeat.steps[0].hold.for",
    ]
    spots = [(one.spot.line, one.spot.column) for one in found]
    assert spots == sorted(spots)
    assert len({(one.spot, one.field) for one in found}) == len(found)
    copy = pickle.loads(pickle.dumps(found[0]))  # noqa: S301 - our own bytes
    assert [str(one) for one in (copy, *copy.more)] == [str(one) for one in found]


def test_a_mistake_brings_no_others_with_it() -> None:
    # Each of these is one mistake, whatever it makes of fields that are fine.
    for old, new in (
        ("rig: biaxial-hook", "rig: biaxial"),
        ("rig: biaxial-hook", "rgi: biaxial-hook"),
        ("knit: stockinette-default", "knit: stocking"),
        ("loops: [1, 1]", "lops: [1, 1]"),
        ("rate: 1 mm/s", "rat: 1 mm/s"),
        ("ramp:", "rmp:"),
        ("others: hold", "others: hld"),
        ("loops: [1, 1]", "loops: [1, 1, 1]"),
        ("material: RGD8530-DM, friction: 0.3}", f"material: mine, viscoelastic: on}}\nmaterials: {OWN}"),
        ("rate: 1 mm/s", "rate: 1 mm/s, tag: -2"),
        ("to: {strain: 1 %}", "to: {strain: 900 %}"),
    ):
        assert len(mistakes_of(STAGE.replace(old, new))) == 1, new


def test_check_prints_twenty_mistakes_and_counts_the_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "p.yaml"
    holds = [f"  - hold: {{for: {k} kg}}\n" for k in range(33)]
    for text, lines, last in ((holds, 21, "... and 13 more"), (holds[:20], 20, "p.yaml:28:")):
        path.write_text(STAGE + "".join(text), encoding="utf-8")
        monkeypatch.setattr(sys, "argv", ["knitlab", "check", str(path)])
        with pytest.raises(SystemExit) as raised:
            main()
        said = capsys.readouterr().err.splitlines()
        assert (raised.value.code, len(said)) == (2, lines)
        assert all(line.startswith(f"{path}:{k}:17: steps[{k - 7}].hold.for: ") for k, line in enumerate(said[:20], 9))
        assert last in said[-1]


@pytest.mark.parametrize(
    ("said", "kind", "value"), [("10 %", "strain", 0.1), ("0.1", "strain", 0.1), ("8 mm", "displacement", 8e-3)]
)
def test_a_target_alone_is_of_the_kind_that_its_unit_says(said: str, kind: str, value: float) -> None:
    (_, short), (_, whole) = (
        from_yaml(STAGE.replace("{strain: 1 %}", to)).steps for to in (said, f"{{{kind}: {said}}}")
    )
    assert short == whole
    assert getattr(short, "to").value == pytest.approx(value)  # noqa: B009 (a union of steps)


def test_a_force_alone_is_a_target_and_a_time_is_none() -> None:
    text = STAGE.replace("{strain: 1 %}, rate: 1 mm/s", "2 N, rate: 0.1 N/s")
    assert from_yaml(text) == from_yaml(text.replace("2 N,", "{force: 2 N},"))
    assert "found '2 s', allowed a target, such as 40 %, 10 mm or 2 N" in str(
        mistakes_of(text.replace("2 N", "2 s"))[0]
    )


def test_what_has_one_legal_value_need_not_be_said() -> None:
    for text in (FRAME, GRIPPER):
        assert from_yaml(text).others == "free"
        assert from_yaml(text).speed_ref == "pair"
        assert loads(text).defaults["others"] == "free"
    (missing,) = mistakes_of(STAGE.replace("others: hold\n", ""))
    assert str(missing).endswith("others: found nothing, allowed hold, free or follow on biaxial-hook")


def test_what_is_taken_by_default_is_shown_and_recorded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "Prüfling (2).yaml"
    path.write_text(FRAME.replace("friction: 0.3", "nodes_per_loop: 16"), encoding="utf-8")
    wanted = (
        "speed_ref: pair, others: free, specimen.friction: 0.3, specimen.hook: pin, log.seed: 0, "
        "max_strain_increment: 0.0125"
    )
    assert dry_run(load(path)).defaults["speed_ref"] == "pair"
    monkeypatch.setattr(sys, "argv", ["knitlab", "check", str(path)])
    with pytest.raises(SystemExit):
        main()
    assert f"taken by default: {wanted}\n" in capsys.readouterr().out
    monkeypatch.chdir(tmp_path)
    result = run_protocol(path, None, lambda _share, _text: None)
    record = RunReader(result.folder / "run.h5")
    assert record.provenance["defaults"] == wanted
    assert (record.provenance["speed_ref"], record.provenance["others"]) == ("pair", "free")
    # The name stands as it is in the record; folder and files have one that every system takes.
    assert record.provenance["name"] == "Prüfling (2)"
    assert result.folder.parent.name == "runs"
    stem = result.folder.name
    assert stem.startswith("Prüfling_2-")
    assert {one.name for one in result.folder.iterdir()} >= {f"{stem}_stress_strain.png", f"{stem}.is_tcyclic_Exports"}
