from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from app.schemas import ProtocolError, from_yaml, json_schema, load, loads, materials, to_yaml
from app.schemas.units import parse
from knitlab_core.errors import GeometryError
from knitlab_core.knits import NAMED_STITCHES, Stitch, VolumetricStitch, Yarn, fabric_names, same_area
from rigs.protocol.protocol import Cycle, Ramp, Zero

EXAMPLES = Path(__file__).parents[3] / "examples"

# Line and column of what the cases below spoil are read off this text.
GOOD = """\
schema: knitlab/protocol@1
rig: biaxial-hook
specimen:
  knit: plain-knit
  loops: [4, 5]
  loop: 8 mm
  material: RGD8530-DM
  friction: 0.3
speed_ref: pair
others: hold
log: {rate: 10 Hz, noise: off}
params: {pre: 0.2}
steps:
  - zero: {channels: [force]}
  - ramp: {axes: [W], to: {strain: "${pre}"}, rate: 0.2 mm/s}
  - cycle: {axes: [C], lower: 0, upper: 40 %, rate: 0.2 mm/s, n: 2}
  - hold: {for: 10 s}
"""


class Bad(NamedTuple):
    """One way to spoil the text: `old` becomes `new`; the error stands at line:column and says so."""

    old: str
    new: str
    line: int
    column: int
    says: str


STITCH = "{curvature: 1.5, height: 0.8, depth: 0.25, row_spacing: 0.86, fibre_radius: 0.05}"
FUSED = "fused: {gap: 0.4 mm, patch_radius: 0.2 mm, strength: 20 MPa}"
OWN = """materials: {mine: {young_modulus: {value: 1 GPa, source: mine}, poisson_ratio: {value: 0.3, source: mine}}}
params:"""
BAD = [
    # What is there and should not be
    Bad("rig:", "rgi: x\nrig:", 2, 1, "rgi: found an unknown field, allowed schema, name, rig, "),
    Bad("  loop: 8", "  lop: 8", 6, 3, "specimen.lop: found an unknown field, "),
    Bad("  loop: 8", "  lop: 8", 6, 3, "(did you mean loop?)"),
    Bad("n: 2}", "n: 2, rte: 1}", 16, 69, "steps[2].cycle.rte: found an unknown field"),
    # What is missing
    Bad("rig: biaxial-hook\n", "", 1, 1, "rig: found nothing, allowed biaxial-hook, uniaxial-frame, tri"),
    Bad("  loop: 8 mm\n", "", 4, 3, "specimen.loop: found nothing, allowed a length with its unit, such as 8 mm"),
    Bad("others: hold\n", "", 1, 1, "others: found nothing, allowed hold"),
    Bad(", rate: 0.2 mm/s, n: 2", ", n: 2", 16, 12, "steps[2].cycle.rate: found nothing, allowed a speed"),
    Bad("material: RGD8530-DM", "material:", 7, 3, "specimen.material: found nothing, allowed the name of a material"),
    # Units and dimensions
    Bad("loop: 8 mm", "loop: 8", 6, 9, "specimen.loop: found 8, allowed a length with its unit"),
    Bad("loop: 8 mm", "loop: 8 s", 6, 9, "found '8 s', allowed a length"),
    Bad("loop: 8 mm", "loop: 8 furlong_s", 6, 9, "found '8 furlong_s', allowed a length"),
    Bad("loop: 8 mm", "loop: -8 mm", 6, 9, "specimen.loop: found -0.008 m, allowed a length from 1 um to 1 m"),
    Bad("loop: 8 mm", "loop: 9**9**9**9 mm", 6, 9, "allowed a length"),
    Bad("10 Hz", "600 rpm", 11, 13, "log.rate: found '600 rpm', allowed a frequency"),
    Bad("10 Hz", "-1 Hz", 11, 13, "log.rate: found -1 Hz, allowed a frequency above 0"),
    Bad("0.2 mm/s}", "0.2 mm}", 15, 53, "steps[1].ramp.rate: found '0.2 mm', allowed a speed"),
    Bad("40 %", "40 deg", 16, 41, "steps[2].cycle.upper: found '40 deg', allowed a strain"),
    Bad("40 %", "-10 %", 16, 41, "steps[2].cycle.upper: found -0.1, allowed a strain above lower (0)"),
    Bad("10 s}", "1e999 s}", 17, 17, "steps[3].hold.for: found '1e999 s', allowed a time"),
    Bad("10 s}", "0 s}", 17, 17, "steps[3].hold.for: found 0 s, allowed a time above 0"),
    Bad("noise: off", "events: 1 m", 11, 28, "log.events: found '1 m', allowed a frequency with its unit"),
    Bad("noise: off", "every_cycle: 0", 11, 33, "log.every_cycle: found 0, allowed a whole number from 1 to 10000"),
    Bad("10 s}", "10 s, log: {rate: 0 Hz}}", 17, 35, "steps[3].hold.log.rate: found 0 Hz, allowed a frequency above 0"),
    Bad("10 s}", "10 s, log: {}}", 17, 28, "steps[3].hold.log: found nothing, allowed one or more of rate, events"),
    Bad(
        "10 s}",
        "10 s, log: {every_cycle: 2}}",
        17,
        29,
        "steps[3].hold.log.every_cycle: found an unknown field, allowed rate, events",
    ),
    Bad(
        "n: 2}",
        "n: 2, log: {seed: 2}}",
        16,
        75,
        "steps[2].cycle.log.seed: found an unknown field, allowed rate, events, every",
    ),
    # Wrong types
    Bad("[4, 5]", "[4, 5.5]", 5, 14, "specimen.loops[1]: found 5.5, allowed a whole number"),
    Bad("[4, 5]", "[4]", 5, 10, "specimen.loops: found a list, allowed [rows, loops in a row]"),
    Bad("[4, 5]", "6", 5, 10, "specimen.loops: found 6, allowed [rows, loops in a row]"),
    Bad("[4, 5]", "[4, 5, 1]", 5, 10, "specimen.loops: found a list, allowed [rows, loops in a row] of a planar knit"),
    Bad("[4, 5]", "[4, 5, 2]", 5, 10, "specimen.loops: found 2, allowed 1: a planar knit has one layer"),
    Bad("[4, 5]", "[0, 5]", 5, 10, "specimen.loops: found 0, allowed a whole number from 1 to 200"),
    Bad("friction: 0.3", "friction: high", 8, 13, "specimen.friction: found 'high', allowed a coefficient"),
    Bad("friction: 0.3", "friction: -1", 8, 13, "specimen.friction: found -1.0, allowed a coefficient from 0 to 2"),
    Bad("n: 2}", "n: twice}", 16, 66, "steps[2].cycle.n: found 'twice', allowed a whole number from 1"),
    Bad("n: 2}", "n: true}", 16, 66, "steps[2].cycle.n: found true, allowed a whole number"),
    Bad(
        "noise: off",
        "clock_offset: 1 s",
        11,
        34,
        "found 1.0, allowed none: biaxial-hook has one clock",
    ),
    Bad("noise: off", "clock_skew: fast", 11, 32, "log.clock_skew: found 'fast', allowed a number such as 2e-5"),
    Bad("noise: off", "clock_skew: 2", 11, 32, "log.clock_skew: found 2, allowed a number from -0.01 to 0.01"),
    Bad("noise: off", "noise: loud", 11, 27, "log.noise: found 'loud', allowed on or off"),
    Bad("[C]", "C", 16, 19, "steps[2].cycle.axes: found 'C', allowed a list of axes"),
    Bad("[C]", "[C, C]", 16, 19, "steps[2].cycle.axes: found a list, allowed one or more axes of the rig, each once"),
    Bad("{for: 10 s}", "10 s", 17, 11, "steps[3].hold: found '10 s', allowed a mapping of fields: for, axes, "),
    Bad("{pre: 0.2}", "{pre: 3 s}", 15, 36, "steps[1].ramp.to.strain: found '3 s', allowed a strain"),
    Bad(
        '{strain: "${pre}"}',
        '{strain: "${pre}", displacement: 1 mm}',
        15,
        27,
        "steps[1].ramp.to: found a mapping, allowed one of strain, displacement and force",
    ),
    Bad("others:", "name: a/b\nothers:", 10, 7, "name: found a/b, allowed up to 64 letters"),
    # Words that are not among the known ones
    Bad("biaxial-hook", "biaxial-hok", 2, 6, "found 'biaxial-hok', allowed biaxial-hook, uniaxial-frame, triaxial"),
    Bad("rig: biaxial-hook", "rig: triaxial", 4, 9, "knit: found a knit with faces across C and W, allowed one with"),
    Bad("others: hold", "others: fre", 10, 9, "others: found 'fre', allowed hold, free or follow (did you mean free?)"),
    Bad("protocol@1", "protocol@2", 1, 9, "schema: found 'knitlab/protocol@2', allowed knitlab/protocol@1"),
    Bad("[C]", "[P]", 16, 19, "steps[2].cycle.axes: found P, allowed what is driven: C and W"),
    Bad("[C]", "[Q]", 16, 20, "steps[2].cycle.axes[0]: found 'Q', allowed C or W"),
    Bad("RGD8530-DM", "RGD8350-DM", 7, 13, "specimen.material: found RGD8350-DM, allowed"),
    Bad("plain-knit", "plainknit", 4, 9, "specimen.knit: found plainknit, allowed one of stockinette-default"),
    Bad("hold: {", "hodl: {", 17, 5, "steps[3]: found step 'hodl', allowed a step: zero, preload"),
    # What is controlled, and at which rate
    Bad("n: 2}", "n: 2, control: force}", 16, 31, "steps[2].cycle.lower: found 0, allowed a force with its unit, such"),
    Bad("upper: 40 %", "upper: 8 mm", 16, 41, "found '8 mm', allowed a strain as a pure number or in per cent, such a"),
    Bad("lower: 0,", "lower: [0],", 16, 31, "steps[2].cycle.lower: found a list, allowed a strain, or with its unit a"),
    Bad("n: 2}", "n: 2, control: speed}", 16, 78, "control: found 'speed', allowed strain, displacement or force"),
    Bad("0.2 mm/s}", "0.2 N/s}", 15, 53, "steps[1].ramp.rate: found 0.2 N/s, allowed a speed or a strain rate, for st"),
    Bad("0.2 mm/s}", "0.2 mm/s, control: force}", 15, 27, "steps[1].ramp.to: found strain with control: force, allowe"),
    Bad("0, upper: 40 %", "0 N, upper: 1 N, control: force", 16, 70, "rate: found 0.0002 m/s, allowed a force rate, f"),
    Bad("0.2 mm/s}", "0 /s}", 15, 53, "steps[1].ramp.rate: found '0 /s', allowed a strain rate above 0"),
    Bad("0.2 mm/s}", "0.2}", 15, 53, "steps[1].ramp.rate: found 0.2, allowed a speed, a strain rate or a force rate"),
    Bad("{for: 10 s}", "{for: 10 s, control: force}", 17, 11, "steps[3].hold.axes: found nothing, allowed a list of t"),
    # What ends a step early
    Bad("0.2 mm/s}", "0.2 mm/s, until: {}}", 15, 70, "steps[1].ramp.until: found nothing, allowed one or more of forc"),
    Bad("0.2 mm/s}", "0.2 mm/s, until: 2 N}", 15, 70, "steps[1].ramp.until: found '2 N', allowed a mapping of what en"),
    Bad("0.2 mm/s}", "0.2 mm/s, until: {force: 2}}", 15, 78, "until.force: found 2, allowed a force with its unit"),
    Bad(
        "0.2 mm/s}",
        "0.2 mm/s, until: {force: '> 2'}}",
        15,
        78,
        "until.force: found '> 2', allowed a force with its unit",
    ),
    Bad(
        "0.2 mm/s}",
        "0.2 mm/s, until: {strain: '= 2'}}",
        15,
        79,
        "until.strain: found '= 2', allowed a strain as a pure",
    ),
    Bad(
        "0.2 mm/s}",
        "0.2 mm/s, until: {strain: '< x'}}",
        15,
        79,
        "until.strain: found '< x', allowed a strain as a pure",
    ),
    Bad("0.2 mm/s}", "0.2 mm/s, until: {drop: 120 %}}", 15, 77, "until.drop: found 1.2, allowed a share above 0 and u"),
    Bad("0.2 mm/s}", "0.2 mm/s, until: {tme: 2 s}}", 15, 71, "until.tme: found an unknown field, allowed force, stra"),
    Bad("hold: {for: 10 s}", "until_rupture: {axes: [C]}", 17, 20, "steps[3].until_rupture.rate: found nothing, allow"),
    Bad(
        "hold: {for: 10 s}",
        "until_rupture: {axes: [C], rate: 1 mm/s, to: {force: 1 N}}",
        17,
        50,
        "until_rupture.to: found a force, allowed a strain or a displacement",
    ),
    Bad(
        "hold: {for: 10 s}",
        "until_rupture: {axes: [C], rate: 1 mm/s, control: force}",
        17,
        55,
        "until_rupture.control: found force, allowed strain or displacement: under a controlled force no drop is seen",
    ),
    Bad("hold: {for: 10 s}", "image: {every: 20}", 17, 20, "steps[3].image.every: found 20, allowed a time between"),
    Bad("hold: {for: 10 s}", "image: {every: never}", 17, 20, "steps[3].image.every: found 'never', allowed a time be"),
    # Sweeps
    Bad("params:", "sweep: {per: [0, 1]}\nparams:", 12, 9, "sweep.per: found 'per', allowed a name under params: pre "),
    Bad("params:", "sweep: {pre: []}\nparams:", 12, 14, "sweep.pre: found an empty list, allowed one value or more"),
    Bad("params:", "sweep: {pre: 1}\nparams:", 12, 14, "sweep.pre: found 1, allowed a list of values"),
    Bad("params:", "sweep: {pre: [1, 1]}\nparams:", 12, 18, "sweep.pre[1]: found 1, allowed each value once"),
    Bad(
        "params:",
        f"sweep: {{pre: {list(range(10_001))}}}\nparams:",
        12,
        8,
        "sweep: found 10001 points, allowed 10000 points or fewer",
    ),
    Bad("- hold: {for: 10 s}", "- hold", 17, 5, "steps[3]: found 'hold', allowed a step"),
    Bad("friction: 0.3", "hook: wir", 8, 9, "specimen.hook: found 'wir', allowed pin or wire (did you mean wire?)"),
    Bad(
        "friction: 0.3",
        "hook: wire\n  yarn: {fibres: 3, model: bundle}",
        8,
        9,
        "specimen.hook: found wire, allowed pin: wires hold",
    ),
    Bad(
        "friction: 0.3",
        "hook: wire\n  rest_shape: straight",
        8,
        9,
        "found wire, allowed pin: wires hold a yarn at rest",
    ),
    Bad("friction: 0.3", "pole_friction: 3", 8, 18, "specimen.pole_friction: found 3.0, allowed a coefficient from 0"),
    Bad("friction: 0.3", "pole_friction: some", 8, 18, "specimen.pole_friction: found 'some', allowed a coefficient"),
    Bad("friction: 0.3", "grips: clam", 8, 10, "specimen.grips: found 'clam', allowed hooks or clamps (did you mean"),
    Bad("friction: 0.3", "grips: clamps\n  hook: wire", 9, 9, "specimen.hook: found wire, allowed pin: clamps have no"),
    Bad(
        "friction: 0.3", "grips: clamps\n  pole_friction: 0.1", 9, 18, "pole_friction: found 0.1, allowed none: clamps"
    ),
    Bad("friction: 0.3", "grips: {W: clam}", 8, 14, "specimen.grips.W: found 'clam', allowed hooks or clamps (did you"),
    Bad("friction: 0.3", "grips: {P: clamps}", 8, 11, "specimen.grips.P: found an unknown field, allowed C, W"),
    Bad(
        "friction: 0.3", "grips: {W: clamps}\n  hook: wire", 9, 9, "specimen.hook: found wire, allowed pin: clamps have"
    ),
    Bad(
        "speed_ref:", "extensometer: maybe\nspeed_ref:", 9, 15, "extensometer: found 'maybe', allowed on, off, or a map"
    ),
    Bad(
        "speed_ref:",
        "extensometer: {cours: [0, 1]}\nspeed_ref:",
        9,
        16,
        "extensometer.cours: found an unknown field, a",
    ),
    Bad(
        "speed_ref:",
        "extensometer: {course: [0, 6]}\nspeed_ref:",
        9,
        24,
        "allowed two of the 5 stitches of a row, counted",
    ),
    Bad(
        "speed_ref:",
        "extensometer: {pile: [0, 1]}\nspeed_ref:",
        9,
        22,
        "extensometer.pile: found a list, allowed two of",
    ),
    # Rigs
    Bad("rig: ", "mount: C\nrig: ", 2, 8, "mount: found C, allowed no mount: biaxial-hook drives C and W"),
    Bad("rig: biaxial-hook", "rig: uniaxial-frame", 1, 1, "mount: found nothing, allowed C or W: the axis along the"),
    Bad("rig: biaxial-hook", "rig: uniaxial-frame\nmount: P", 3, 8, "mount: found P, allowed C or W: the axis along"),
    Bad("rig: biaxial-hook", "rig: uniaxial-frame\nmount: C", 11, 9, "others: found hold, allowed free on uniaxial-fr"),
    # What the yarn is made of, and what goes beyond elastic rods
    Bad("friction: 0.3", "rest_shape: bent", 8, 15, "specimen.rest_shape: found 'bent', allowed as-printed or straigh"),
    Bad(
        "friction: 0.3",
        "laid_in: 0.3 mm",
        8,
        12,
        "specimen.laid_in: found 0.3 mm, allowed none of a yarn at rest as",
    ),
    Bad(
        "friction: 0.3", "laid_in: 2 mm\n  rest_shape: straight", 8, 12, "laid_in: found 2 mm, allowed a radius above 0"
    ),
    Bad("friction: 0.3", "laid_in: thin", 8, 12, "specimen.laid_in: found 'thin', allowed a contact radius as laid"),
    Bad(
        "friction: 0.3",
        "laid_in: relaxed\n  rest_shape: straight",
        8,
        12,
        "specimen.laid_in: found relaxed, allowed a radius: only a yarn by measurement is relaxed so",
    ),
    # Chained edges
    Bad("friction: 0.3", "edges: {top: sewn}", 8, 16, "specimen.edges.top: found 'sewn', allowed open or bound-off"),
    Bad("friction: 0.3", "edges: {top: cast-on}", 8, 16, "edges.top: found 'cast-on', allowed open or bound-off"),
    Bad(
        "friction: 0.3", "edges: {sides: open}", 8, 11, "specimen.edges.sides: found an unknown field, allowed top, bo"
    ),
    Bad(
        "friction: 0.3", "edges: {top: bound-off, slack: 50 %}", 8, 34, "edges.slack: found 0.5, allowed 0 to 35% of a"
    ),
    Bad("friction: 0.3", "edges: {slack: 5 %}", 8, 18, "specimen.edges.slack: found 0.05, allowed 0: no edge is"),
    Bad("friction: 0.3", "edges: bound-off", 8, 10, "edges: found 'bound-off', allowed a mapping such as {top: bound-"),
    Bad(
        "friction: 0.3",
        "edges: {top: bound-off}\n  periodic: on",
        8,
        10,
        "specimen.edges: found top: bound-off, allowed none: a periodic cell has no edges",
    ),
    Bad(
        "friction: 0.3",
        "edges: {bottom: cast-on}\n  hook: wire",
        9,
        9,
        "hook: found wire, allowed pin: chained edges leave no room for wires",
    ),
    Bad(
        "plain-knit",
        "volumetric-default\n  edges: {bottom: cast-on}",
        5,
        10,
        "specimen.edges: found bottom: cast-on, allowed open in this knit: plain stockinette can be bound off and cast",
    ),
    Bad("plain-knit", "rib-1x1\n  edges: {top: bound-off}", 5, 10, "allowed open in this knit: plain stockinette can"),
    Bad("[4, 5]", "[4, 1]\n  edges: {bottom: cast-on}", 6, 19, "edges.bottom: found cast-on, allowed open in a row of"),
    Bad("friction: 0.3", "yarn: 3", 8, 9, "specimen.yarn: found 3, allowed a mapping that makes the yarn of fibres"),
    Bad("friction: 0.3", "yarn: {fibres: 0}", 8, 18, "specimen.yarn.fibres: found 0, allowed a whole number from 1 to"),
    Bad("friction: 0.3", "yarn: {fibers: 3}", 8, 10, "yarn.fibers: found an unknown field, allowed fibres, model, fi"),
    Bad(
        "friction: 0.3", "yarn: {fibres: 3, model: rope}", 8, 28, "specimen.yarn.model: found 'rope', allowed yarn or b"
    ),
    Bad("friction: 0.3", "yarn: {fibres: 3, twist: 3 mm}", 8, 28, "found '3 mm', allowed a number of radians per loop"),
    Bad(
        "friction: 0.3",
        "yarn: {fibres: 2, fibre_radius: 1 s}",
        8,
        35,
        "specimen.yarn.fibre_radius: found '1 s', allowe",
    ),
    Bad(
        "friction: 0.3",
        "yarn: {fibres: 2, winding_radius: 0}",
        8,
        37,
        "specimen.yarn.winding_radius: found fibres whos",
    ),
    Bad(
        "friction: 0.3",
        "fused: on",
        8,
        10,
        "specimen.fused: found 'on', allowed a mapping such as {gap: 0.3 mm, patch_",
    ),
    Bad(
        "friction: 0.3",
        "fused: {gap: 1 mm}",
        8,
        10,
        "specimen.fused.patch_radius: found nothing, allowed the radius of",
    ),
    Bad(
        "friction: 0.3", FUSED.replace("0.4 mm", "0 mm"), 8, 16, "specimen.fused.gap: found 0.0, allowed a number above"
    ),
    Bad(
        "friction: 0.3",
        FUSED.replace("20 MPa", "20 N"),
        8,
        56,
        "specimen.fused.strength: found '20 N', allowed a stress",
    ),
    Bad(
        "friction: 0.3",
        FUSED + "\n  rest_shape: straight",
        8,
        10,
        "none in a yarn that is straight at rest: points fus",
    ),
    Bad("friction: 0.3", "viscoelastic: maybe", 8, 17, "specimen.viscoelastic: found 'maybe', allowed on or off"),
    Bad(
        "RGD8530-DM", "cotton-2-ply\n  viscoelastic: on", 8, 17, "allowed off: nothing is known of the relaxation of co"
    ),
    Bad("RGD8530-DM", "cotton-2-ply\n  yield: on", 8, 10, "allowed off: nothing is known of the yield curve of cotton"),
    Bad("friction: 0.3", "yield: yes please", 8, 10, "specimen.yield: found 'yes please', allowed on or off"),
    Bad(
        "friction: 0.3",
        "yield: on\n  rest_shape: straight",
        8,
        10,
        "allowed off in a yarn that is straight at rest: it",
    ),
    Bad("friction: 0.3", "rupture: go", 8, 12, "specimen.rupture: found 'go', allowed off, stop or go on"),
    # Materials of one's own
    Bad(
        "params:",
        "materials: own.yaml\nparams:",
        12,
        12,
        "materials: found own.yaml, allowed materials by name: a text",
    ),
    Bad(
        "params:",
        "materials: {IP-Dip: {}}\nparams:",
        12,
        21,
        "materials.IP-Dip.young_modulus: found nothing, allowed a",
    ),
    Bad(
        "params:",
        OWN.replace("young", "yuong"),
        12,
        20,
        "materials.mine.yuong_modulus: found an unknown field, allowed",
    ),
    Bad("params:", OWN.replace("0.3,", "0.7,"), 12, 88, "materials.mine.poisson_ratio.value: found 0.7, allowed above"),
    Bad("params:", OWN.replace("mine", "IP-Dip"), 12, 13, "no name of the catalogue"),
    # Stitch values
    Bad("plain-knit", STITCH.replace("0.05}", "-0.05}"), 4, 85, "specimen.knit.fibre_radius: found -0.05, allowed"),
    Bad("plain-knit", STITCH.replace("0.05}", "1 s}"), 4, 85, "found '1 s', allowed a number of loop widths"),
    Bad("plain-knit", STITCH.replace("1.5", "12 mm"), 4, 21, "specimen.knit.curvature: found a length, allowed a pure"),
    Bad("plain-knit", "volumetric-default", 5, 10, "specimen.loops: found a list, allowed [rows, loops in a row, la"),
    Bad("plain-knit", "{wale_height: 1.6}", 4, 9, "specimen.knit.curvature: found nothing, allowed a pure number"),
    Bad("plain-knit", "{wale_height: 1.6, height: 1}", 4, 28, "specimen.knit.height: found an unknown field, allowed"),
    Bad("plain-knit", "{wale_height: 1.6, height: 1}", 4, 28, "depth, row_spacing, layer_spacing, fibre_radius"),
    Bad("plain-knit", "{curvature: 1.5}", 4, 9, "specimen.knit.height: found nothing, allowed a number of loop"),
    # Parameters
    Bad("{pre: 0.2}", "{per: 0.2}", 15, 36, "found '${pre}', allowed a name under params: per (did you mean per?)"),
    Bad('"${pre}"', '"${pre} %"', 15, 36, "found '${pre} %', allowed a whole value such as ${name}"),
    Bad('"${pre}"', "0.2", 12, 10, "params.pre: found no use of it, allowed a use as ${pre}"),
    Bad("{pre: 0.2}", "{pre: [0, 1]}", 12, 15, "params.pre: found a list, allowed a number or a text"),
    Bad("{pre: 0.2}", "{pre: 20 mm}", 15, 36, "steps[1].ramp.to.strain: found '20 mm', allowed a strain"),
    # YAML itself
    Bad("rig: biaxial-hook", "rig: [biaxial", 3, 9, "protocol: found "),
    Bad(
        "friction: 0.3", "material: IP-Dip", 8, 3, "specimen.material: found the same key again, allowed each key once"
    ),
    Bad("rig: ", "rig: !!str ", 2, 6, "rig: found tag tag:yaml.org,2002:str, allowed plain values without tags"),
    Bad("rig: ", "rig: !python/object:os.system ", 2, 6, "allowed plain values without tags"),
    Bad("others: hold", "others: *x", 10, 9, "others: found *x, allowed an alias to an anchor that is complete"),
    Bad("others: hold", "others: &x [*x]", 10, 13, "allowed an alias to an anchor that is complete"),
    Bad("others: hold", "? [a]\n: 1", 10, 3, "found a key that is not plain text"),
    Bad("others: hold", "others: " + "[" * 40 + "]" * 40, 10, 33, "others: found deeper nesting, allowed 24 levels"),
    Bad("rig: b", "\trig: b", 2, 1, "protocol: found "),
    Bad("  - hold: {for: 10 s}\n", "---\na: 1\n", 17, 1, "found a second document, allowed one document"),
]


def error_of(text: str) -> ProtocolError:
    with pytest.raises(ProtocolError) as raised:
        loads(text, "p.yaml")
    return raised.value


def test_the_text_that_is_spoilt_is_good() -> None:
    protocol = from_yaml(GOOD)
    assert protocol.specimen.loop_width == 8e-3
    assert (protocol.specimen.rows, protocol.specimen.loops) == (4, 5)
    zero, ramp, cycle, _ = protocol.steps
    assert isinstance(zero, Zero)
    assert isinstance(ramp, Ramp)
    assert ramp.to.value == 0.2
    assert isinstance(cycle, Cycle)
    assert (cycle.upper, cycle.rate) == (0.4, 2e-4)


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: bad.says[:50])
def test_a_bad_protocol_is_one_line_with_its_place(bad: Bad) -> None:
    assert GOOD.count(bad.old) >= 1
    line = str(error_of(GOOD.replace(bad.old, bad.new, 1)))
    assert line.startswith(f"p.yaml:{bad.line}:{bad.column}: ")
    assert bad.says in line
    assert ", allowed " in line
    assert "\n" not in line


def test_there_are_many_ways_to_be_wrong() -> None:
    assert len(BAD) >= 50


@pytest.mark.parametrize("text", ["", "# nothing\n", "- 1\n", "42\n"])
def test_what_is_no_mapping_is_refused(text: str) -> None:
    assert "allowed a mapping of fields: schema, name, rig" in str(error_of(text))


def test_the_first_of_several_errors_is_named() -> None:
    text = GOOD.replace("others: hold", "others: fee").replace("loop: 8 mm", "loop: 8 s")
    assert error_of(text).spot.line == 6


def test_aliases_are_counted_out_before_they_are_followed() -> None:
    lines = ["a: &a [" + ", ".join("x" * 9) + "]"]
    lines += [
        f"{name}: &{name} [{', '.join([f'*{last}'] * 9)}]" for last, name in zip("abcdefgh", "bcdefghi", strict=True)
    ]
    assert "20000 values or fewer" in str(error_of("\n".join(lines)))


def test_an_alias_stands_for_its_value() -> None:
    text = GOOD.replace("- cycle: {", "- cycle: &c {").replace("- hold: {for: 10 s}", "- cycle: *c")
    steps = from_yaml(text).steps
    assert steps[2] == steps[3]


def test_control_characters_never_reach_the_terminal() -> None:
    line = str(error_of(GOOD + '"\\e[31mred\\e[0m": 1\n'))
    assert line.isprintable()


def test_files_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    for path, content, says in (
        (tmp_path / "none.yaml", None, "no such file or directory"),
        (tmp_path, None, "is a directory"),
        (
            tmp_path / "latin.yaml",
            b"rig: a\nname: caf\xe9\n",
            "latin.yaml:2:10: protocol: found byte 0xe9, allowed text",
        ),
        (tmp_path / "large.yaml", b"#" * 1_000_001, "1000000 bytes or fewer"),
        (tmp_path / "null.yaml", b"rig: \x00\n", "protocol: found "),
    ):
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(ProtocolError) as raised:
            load(path)
        line = str(raised.value)
        assert line.startswith(str(path))
        assert says in line
        assert "\n" not in line


def test_a_protocol_without_a_name_takes_its_files(tmp_path: Path) -> None:
    path = tmp_path / "first.yaml"
    path.write_text(GOOD, encoding="utf-8")
    assert load(path).protocol.name == "first"
    assert load(path).text == GOOD


def test_stitch_values_may_be_loop_widths_or_lengths() -> None:
    text = GOOD.replace("plain-knit", STITCH.replace("fibre_radius: 0.05", "fibre_radius: 0.4 mm"))
    knit = from_yaml(text).specimen.knit
    assert isinstance(knit, Stitch)
    assert knit.fibre_radius == pytest.approx(0.05)
    assert knit.height == 0.8


@pytest.mark.parametrize(
    ("field", "line", "column"),
    [("specimen.loops", 5, 10), ("rows", 5, 10), ("specimen.knit", 4, 9), ("clearance", 4, 9), ("log.rate", 11, 13)],
)
def test_an_error_found_later_is_placed(field: str, line: int, column: int) -> None:
    error = loads(GOOD, "p.yaml").locate(GeometryError(field, "strands 0.1 mm apart", "more than 0.8 mm"))
    assert str(error).startswith(f"p.yaml:{line}:{column}: ")
    assert "found strands 0.1 mm apart, allowed more than 0.8 mm" in str(error)


PROTOCOLS = sorted(
    path for path in EXAMPLES.rglob("*.yaml") if "knitlab/protocol@1" in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("path", PROTOCOLS, ids=lambda path: path.stem)
def test_examples_read_back(path: Path) -> None:
    protocol = load(path).protocol
    assert from_yaml(to_yaml(protocol)) == protocol
    assert protocol.name == path.stem


FRAME = (
    GOOD.replace("biaxial-hook", "uniaxial-frame\nmount: W")
    .replace("others: hold", "others: free")
    .replace("[C]", "[W]")
)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            "axes: [W], lower",
            "axes: [C], lower",
            "p.yaml:17:19: steps[2].cycle.axes: found C, allowed what is driven: W",
        ),
        (
            "- hold: {for: 10 s}",
            "- repeat: {n: 2, steps: [hold: {for: 1 s}, ramp: {axes: [W, C], to: {strain: 0}, rate: 1 mm/s}]}",
            "p.yaml:18:59: steps[3].repeat.steps[1].ramp.axes: found C, allowed what is driven: W",
        ),
    ],
)
def test_a_step_may_drive_only_what_is_mounted(old: str, new: str, says: str) -> None:
    assert from_yaml(FRAME).axes == ("W",)
    assert str(error_of(FRAME.replace(old, new))).startswith(says)


def test_volumetric_stitch_values_may_be_lengths_too() -> None:
    values = (
        "{curvature: 1.5, wale_height: 1.6, pile_height: 12.8 mm, depth: 0.25, row_spacing: 1.1, layer_spacing: 10 mm"
    )
    text = GOOD.replace("plain-knit", values + ", fibre_radius: 0.05}").replace("[4, 5]", "[2, 3, 4]")
    spec = from_yaml(text).specimen
    assert isinstance(spec.knit, VolumetricStitch)
    assert (spec.rows, spec.loops, spec.layers) == (2, 3, 4)
    assert (spec.knit.pile_height, spec.knit.layer_spacing) == pytest.approx((1.6, 1.25))
    assert from_yaml(to_yaml(from_yaml(text))) == from_yaml(text)


def test_the_published_schema_knows_every_step() -> None:
    schema = json_schema()
    text = json.dumps(schema)
    assert schema["required"] == ["schema", "rig", "specimen", "steps"]
    for step in ("zero", "preload", "ramp", "hold", "cycle", "waveform", "repeat", "until_rupture", "image"):
        assert f'"required": ["{step}"]' in text


@pytest.mark.parametrize("schema", [json_schema(), materials.json_schema()], ids=["protocol", "material"])
def test_the_published_schema_says_what_every_field_is(schema: dict[str, Any]) -> None:
    parts = [one for part in [schema, *schema["$defs"].values()] for one in [part, *part.get("anyOf", [])]]
    fields = [field for part in parts for field in part.get("properties", {}).items()]
    assert len(fields) > 30
    assert [name for name, field in fields if field["title"] == name] == []
    # The wrapper of a step has its name alone.
    bare = [part for part in parts if not str(part.get("title", "")).endswith("Step")]
    assert [
        name for part in bare for name, field in part.get("properties", {}).items() if not field["description"]
    ] == []


def test_the_published_schema_knows_names_and_units() -> None:
    parts = json_schema()["$defs"]
    knit = parts["SpecimenModel"]["properties"]["knit"]["oneOf"][0]
    assert set(knit["examples"]) == set(fabric_names())
    assert "RGD8530-DM" in parts["SpecimenModel"]["properties"]["material"]["anyOf"][0]["examples"]
    assert {"mm/s", "1/s", "N/s"} <= set(parts["RampModel"]["properties"]["rate"]["x-units"])
    # Whatever is offered is read.
    for unit in parts["PreloadModel"]["properties"]["force"]["x-units"]:
        assert parse(f"1 {unit}", "force") > 0.0


def test_fibres_have_the_stitchs_area_unless_told_otherwise() -> None:
    def yarn(text: str) -> Yarn:
        found = from_yaml(GOOD.replace("friction: 0.3", text)).specimen.yarn
        assert found is not None
        return found

    assert yarn("yarn: {fibres: 3}") == same_area(NAMED_STITCHES["plain-knit"].fibre_radius, 3, bonding=1.0)
    given = yarn("yarn: {fibres: 2, model: bundle, fibre_radius: 0.2 mm, winding_radius: 0.25 mm, twist: 2}")
    assert (given.fibre_radius, given.winding_radius) == pytest.approx((0.2 / 8, 0.25 / 8))
    assert (given.model, given.twist, given.bonding) == ("bundle", 2.0, 0.0)
    # Neighbours lie a tenth of a radius apart, whatever the radius.
    half = yarn("yarn: {fibres: 2, fibre_radius: 0.2 mm}")
    assert half.straight_gap == pytest.approx(0.1 * half.fibre_radius)


@pytest.mark.parametrize(
    ("yarn", "bonding"),
    [
        ("{fibres: 3}", 1.0),
        ("{fibres: 3, fibre_radius: 0.1 mm}", 1.0),
        ("{fibres: 3, bonding: 0}", 0.0),
        ("{fibres: 3, bonding: 0.4}", 0.4),
        # Fibres that are set apart, or laid in, or rods of their own, are loose.
        ("{fibres: 3, fibre_radius: 0.1 mm, winding_radius: 0.2 mm}", 0.0),
        ("{fibres: 3}\n  rest_shape: straight", 0.0),
        ("{fibres: 3, model: bundle}", 0.0),
    ],
)
def test_fibres_printed_just_apart_are_glued_unless_told_otherwise(yarn: str, bonding: float) -> None:
    loaded = loads(GOOD.replace("friction: 0.3", f"yarn: {yarn}"))
    found = loaded.one_test().protocol.specimen.yarn
    assert found is not None
    assert found.bonding == bonding
    shown = None if "bonding" in yarn or "bundle" in yarn else f"{bonding:g}"
    assert loaded.defaults.get("specimen.yarn.bonding") == shown
    written = to_yaml(loaded.one_test().protocol)
    assert from_yaml(written).specimen.yarn == found


def test_a_mesh_has_a_name_or_a_number() -> None:
    for text, nodes in (("mesh: draft", 32), ("mesh: default", 48), ("mesh: fine", 96), ("nodes_per_loop: 40", 40)):
        spec = from_yaml(GOOD.replace("friction: 0.3", text)).specimen
        assert spec.nodes_per_loop == nodes
    assert from_yaml(GOOD).specimen.nodes_per_loop == 48
    both = error_of(GOOD.replace("friction: 0.3", "mesh: fine\n  nodes_per_loop: 40"))
    assert "mesh: found fine and nodes_per_loop, allowed one of the two" in str(both)
    assert "mesh" in str(error_of(GOOD.replace("friction: 0.3", "mesh: coarse")))


def test_on_stops_at_a_rupture() -> None:
    for word, meant in (("on", "stop"), ("off", "off"), ("stop", "stop"), ("go on", "go on"), ("true", "stop")):
        assert from_yaml(GOOD.replace("friction: 0.3", f"rupture: {word}")).specimen.rupture == meant


def test_a_material_of_ones_own_comes_with_its_numbers() -> None:
    text = GOOD.replace("params:", OWN).replace("RGD8530-DM", "mine")
    spec = from_yaml(text).specimen
    assert spec.solid.young_modulus.value == 1e9
    assert from_yaml(to_yaml(from_yaml(text))) == from_yaml(text)


def test_materials_of_a_file_stand_beside_the_protocol(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(GOOD.replace("params:", "materials: own.yaml\nparams:").replace("RGD8530-DM", "creeping-resin"))
    with pytest.raises(ProtocolError, match=r"own\.yaml:1:1: materials: found no such file"):
        load(path)
    own = (EXAMPLES / "materials" / "my-resins.yaml").read_text(encoding="utf-8")
    (tmp_path / "own.yaml").write_text(own, encoding="utf-8")
    loaded = load(path)
    assert loaded.protocol.specimen.substance.name == "creeping-resin"
    # A record holds both texts, and they say the same protocol again.
    assert from_yaml(loaded.text, loaded.materials) == replace(loaded.protocol, name="test")
    unknown = path.read_text().replace("creeping-resin", "creping-resin")
    path.write_text(unknown)
    with pytest.raises(ProtocolError, match=r"p\.yaml:7:13: .* brittle-ip-dip \(did you mean creeping-resin\?\)"):
        load(path)
