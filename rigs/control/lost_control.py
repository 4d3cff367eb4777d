"""Message of a controller that could not meet a setpoint: noise, slack or travel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rigs.control.setpoint_search import breaks
from rigs.control.stop_criteria import StopReason
from rigs.machines.rig import read

if TYPE_CHECKING:
    from rigs.axes import Axis
    from rigs.control.setpoint_search import ControlledPoint
    from rigs.control.setpoints import Setpoints

SLACK: Final = 0.05
"""Share of the largest force of a stroke up to which a specimen counts as slack."""

NOISY: Final = 2.0
"""Dead bands up to which a force cannot be told from the noise of its load cell."""


def lost_control(setpoints: Setpoints, settled: ControlledPoint, share: float) -> StopReason:
    """Return the end of a test at the row before a share at which an axis does not meet its setpoint.

    Parameters
    ----------
    setpoints : Setpoints
        The stroke.
    settled : ControlledPoint
        The equilibrium that came nearest to what was asked.
    share : float
        Where on the stroke it was asked [1].
    """
    session, stroke, orders = setpoints.session, setpoints.stroke, setpoints.orders(share)
    force, here = read(settled.step.rig, settled.step.state).force, read(session.rig, session.state).force
    asked = {axis: order.force for axis, order in orders.items() if order.force is not None}
    if not asked:
        met = "no equilibrium was found at which the machine stands where it was sent"
        return StopReason(end="limit", message=f"control failed at {session.whereabouts()}: {met}", test=True)
    axis: Axis = max(asked, key=lambda one: abs(force[one] - asked[one]))
    tare, noise = session.memory.tare[axis], session.controller.acted_on(session.memory, setpoints.time(share))[axis]
    most = max([abs(one) for ends in stroke.force.values() for one in ends] + [abs(one) for one in here.values()])
    far = 1e3 * abs(settled.step.displacement[axis] - session.displacement[axis])
    near = max(abs(asked[axis]), abs(here[axis]))
    jump = f"the axis would have to jump by {far:.3g} mm or more"
    if noise != 0.0 or near <= NOISY * orders[axis].dead_band:
        why = f"noise: the load cell resolves no less than {1e3 * orders[axis].dead_band:.3g} mN; {jump}"
    elif near <= SLACK * most:
        why = f"slack: {jump} before the knit pulls"
    elif breaks(session, settled.step) or settled.step.final:
        why = "travel: a fibre breaks there"
    else:
        why = f"travel: {jump}"
    kind = "force" if axis in stroke.force else "no force, for it gives way,"
    shown = f"{force[axis] - tare:.4g} N in place of {asked[axis] - tare:.4g} N"
    return StopReason(
        end="limit",
        message=f"control failed at {session.whereabouts()}: {kind} on axis {axis}, {shown}; {why}",
        test=True,
    )
