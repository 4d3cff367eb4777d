"""The smallest test that uses the whole solver and its log."""

from typing import Final

PROTOCOL: Final = """\
schema: knitlab/protocol@1
name: warm
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
speed_ref: pair
others: hold
log: {rate: 1 Hz, noise: off}
steps:
  - cycle: {axes: [C, W], lower: 0, upper: 1 %, rate: 1 mm/s, n: 1}
"""
