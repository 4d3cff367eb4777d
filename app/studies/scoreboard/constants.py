"""Score of the constants of the paper's experiments, read back from logs and records."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.studies.scoreboard.verdict import Score, is_near, judged

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.studies.scoreboard.analysed import Analysed


def constants(runs: Mapping[str, Analysed]) -> Score:
    """Score speeds, hooks, moduli and loop width: each as stated, within 1 %; poles without friction.

    The strain rate, which the paper calls approximate, counts within 5 %.
    Hooks: two on each boundary loop of the upper and lower edge, and two on each turn of the yarn at the sides, which
    joins two rows.
    """
    planar, micro, hooks = runs["fig3a"].facts, runs["fig5 micro"].facts, runs["fig3a"].hooks()
    found = {
        "speed of the stage [mm/s]": (1e3 * planar["speed C"], 0.2),
        "strain rate of the gripper [1/s]": (micro["speed P"] / micro["height"], 1e-3),
        "hooks per boundary loop of the wale": (hooks["W"] / planar["loops"], 2.0),
        "hooks per turn at the sides": (2.0 * hooks["C"] / planar["rows"], 2.0),
        "E of RGD8530-DM [GPa]": (runs["fig3c RGD8530-DM"].facts["young_modulus"] / 1e9, 0.82),
        "E of VeroUltraWhite [GPa]": (runs["fig3c VeroUltraWhite"].facts["young_modulus"] / 1e9, 2.0),
        "E of IP-Dip [GPa]": (micro["young_modulus"] / 1e9, 3.0),
        "micro loop [µm]": (1e6 * micro["loop_width"], 50.0),
    }
    ours = ", ".join(f"{name} {value:.3g}" for name, (value, _) in found.items())
    wrong = [
        name
        for name, (value, stated) in found.items()
        if not is_near(value, stated, 0.05 if name.startswith("strain rate") else 0.01)
    ]
    rubs = planar["pole_friction"]
    values = {name: value for name, (value, _) in found.items()} | {"pole friction": rubs}
    why = f"not as stated: {', '.join(wrong) or 'poles rub'}"
    return judged(not wrong and rubs == 0.0, f"{ours}, pole friction {rubs:g}", values, why)
