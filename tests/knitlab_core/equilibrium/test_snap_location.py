"""A snap that a long step passes: the rows before and after it are close, and the march can be resumed around it."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from knitlab_core.equilibrium import march as marching
from knitlab_core.equilibrium.advance import advance
from knitlab_core.equilibrium.march import march
from knitlab_core.equilibrium.newton import Report
from knitlab_core.equilibrium.rupture import OVERSHOOT, reach_rupture, weakest
from knitlab_core.equilibrium.snap_location import SUDDEN, snaps
from knitlab_core.equilibrium.snap_through import doubt, kept
from knitlab_core.equilibrium.step_control import LOCATED, Pace, StepControl
from knitlab_core.equilibrium.workspace import Workspace
from tests.knitlab_core.equilibrium.test_snap_through import MIDDLE, RISE, arch, height

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray
    from knitlab_core.equilibrium.model import State

    Row = tuple[float, State]

LONGEST, SPREAD, LOAD = 0.25, 0.75, -0.0031
"""Longest step of the march, how far each foot goes outwards in it [r], and the load [E r^2]."""


def pressed() -> tuple[Workspace, State]:
    """Return an arch under a load beside its middle, which it bears until its feet are spread."""
    model, state = arch()
    work = Workspace(model)

    def load(share: float) -> FloatArray:
        work.dead.loads[MIDDLE - 4, 1] = share * LOAD
        return state.q

    *_, (_, found, _) = march(work, state, load, longest=0.1)
    return work, found


def spread(state: State, share: float) -> FloatArray:
    """Return the target (N, 4) with the feet spread to a share [r]."""
    target = state.q.copy()
    target[:2, 0] -= share * SPREAD
    target[-2:, 0] += share * SPREAD
    return target


def follow(work: Workspace, state: State, pace: Pace | None = None, **more: Any) -> list[tuple[Row, Pace]]:  # noqa: ANN401
    """Spread the feet; return every row and the pace at it."""
    pace = pace or Pace()
    found = march(work, state, lambda share: spread(state, share), **{"longest": LONGEST, **more}, pace=pace)
    return [((at, one), replace(pace)) for at, one, _ in found]


def follow_without_location(**more: Any) -> list[tuple[Row, Pace]]:  # noqa: ANN401
    """Spread the feet in steps none of which is gone again for the snap that it passed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StepControl, "is_long", lambda *_: False)
        return follow(*pressed(), **more)


def snap_of(rows: list[tuple[Row, Pace]]) -> tuple[Row, Row]:
    """Return the rows before and after the arch went through."""
    heights = [height(state) for (_, state), _ in rows]
    last = int(np.argmin(np.diff(heights)))
    return rows[last][0], rows[last + 1][0]


@pytest.fixture(scope="module")
def located() -> list[tuple[Row, Pace]]:
    return follow(*pressed())


def test_a_snap_is_between_rows_as_close_as_it_is_located(located: list[tuple[Row, Pace]]) -> None:
    (at, before), (to, after) = snap_of(located)
    assert to - at == pytest.approx(LOCATED * LONGEST)
    assert after.snap_work > before.snap_work
    # The march goes on in long steps, on their grid.
    assert {LONGEST, 2.0 * LONGEST, 3.0 * LONGEST, 1.0} <= {at for (at, _), _ in located}
    # Even short steps, without location, find it at the same place.
    short = LONGEST / 16.0
    (known, _), (by, _) = snap_of(follow_without_location(longest=short))
    assert known <= at <= to <= by + short


def test_without_location_it_lies_somewhere_in_a_long_step() -> None:
    (at, _), (to, _) = snap_of(follow_without_location())
    assert to - at > 4.0 * LOCATED * LONGEST


def test_a_march_resumed_at_any_row_that_allows_it_has_the_same_rows() -> None:
    work, state = pressed()
    pace, kept = Pace(), []

    def path(share: float) -> FloatArray:
        return spread(state, share)

    for at, found, _ in march(work, state, path, longest=LONGEST, pace=pace):
        kept.append((replace(pace), found, work.solver_state))
        assert pace.at == at
    assert not all(pace.resumable for pace, *_ in kept)
    assert kept[-1][0].resumable
    whole = [(pace.at, found.q.tobytes()) for pace, found, _ in kept]
    for number, (stands, found, carried) in enumerate(kept[:-1]):
        if not stands.resumable:
            continue
        fresh = Workspace(work.model)
        fresh.dead.loads[:] = work.dead.loads
        assert carried is not None
        fresh.restore(carried)
        rest = march(fresh, found, path, longest=LONGEST, pace=stands)
        assert [(at, one.q.tobytes()) for at, one, _ in rest] == whole[number + 1 :]


def test_where_no_short_step_passes_a_snap_the_long_one_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    (_, _), (beyond, known) = snap_of(follow_without_location())

    def unguided(*arguments: Any, ahead: FloatArray | None = None, **more: Any) -> tuple[State | None, Report]:  # noqa: ANN401
        # Only what was found beyond the snap is below the feet.
        if ahead is not None and ahead[MIDDLE, 1] < -0.5 * RISE:
            return None, Report(converged=False, iterations=1, residual=1.0, node=MIDDLE, contacts=0)
        return advance(*arguments, ahead=ahead, **more)

    monkeypatch.setattr(marching, "advance", unguided)
    (at, before), (to, after) = snap_of(follow(*pressed()))
    assert to == beyond
    assert LOCATED * LONGEST < to - at < LONGEST
    assert height(before) > 0.0
    assert after.q.tobytes() == known.q.tobytes()


def test_what_sets_hardly_anything_free_is_no_snap_to_look_for(located: list[tuple[Row, Pace]]) -> None:
    (_, before), (_, after) = snap_of(located)
    # So small a motion of the fixtures that the rule of their work is hardly wrong.
    after = replace(after, increment=1e-6 * (after.q - before.q))
    assert snaps(before, after)
    lost = {field.name: getattr(after, field.name) for field in fields(after)}["external_work"]
    size = float(after.energies.sum()) + after.friction_work + after.viscous_work + after.snap_work
    free = after.snap_work - before.snap_work
    hardly = replace(after, external_work=lost - free + 0.5 * SUDDEN * size)
    assert not snaps(before, hardly)
    assert snaps(before, replace(after, external_work=lost - free + 2.0 * SUDDEN * size))


def test_a_snap_on_the_way_to_a_break_is_counted() -> None:
    work, rest = pressed()
    end, _ = advance(work, rest, spread(rest, 0.4))
    assert end is not None
    # The arch is strained most right after it went through.
    limit = weakest(work.model, end).strain / (1.0 + 0.5 * OVERSHOOT)
    _, found, _, report = reach_rupture(work, rest, lambda at: spread(rest, 0.4 * at), limit=limit)
    assert found is not None
    assert report is not None
    assert height(rest) > 0.0 > height(found)
    lost = kept(rest) - kept(found)
    assert lost > doubt(rest, found)
    assert found.snap_work - rest.snap_work == pytest.approx(lost, rel=1e-12)
