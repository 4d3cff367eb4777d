"""Tables of a design: every test, and the target beside what was expected and what was reached."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigs.analysis.table import Table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.studies.design_target import Target
    from app.studies.fit_runs import FitRuns
    from app.studies.search import Trial
    from app.studies.surrogate import Surrogate
    from rigs.analysis.table import Cell
    from rigs.axes import FloatArray

NAN = float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Target of a design beside what the surrogate expected, with its 95 % interval, and what the last test reached.

    Attributes
    ----------
    name, unit : str
        The figure; of a wanted curve its NRMSE, of which 0 is wanted.
    wanted, predicted, low, high, reached : float
        Its values in SI; `reached` is nan where the last test did not come to it.
    distance, within : float
        Difference in what is wanted, and what is near enough [1].
    """

    name: str
    unit: str
    wanted: float
    predicted: float
    low: float
    high: float
    reached: float
    distance: float
    within: float

    @property
    def met(self) -> bool:
        """Return whether the last test is near enough."""
        return self.distance <= self.within


def outcome_of(
    target: Target, surrogate: Surrogate, encoded: FloatArray, features: FloatArray | None, within: float
) -> Outcome:
    """Return the outcome of a design whose last test, at coordinates (1, e), came to some features."""
    distance = float("inf") if features is None else float(target.goal.distance(features))
    if target.scalar:
        expected = surrogate.predict(encoded)
        wanted = float(target.goal.features[0])
        predicted, low, high = (float(one[0, 0]) for one in (expected.mean, expected.low, expected.high))
        reached = NAN if features is None else float(features[0])
    else:
        draws = target.goal.distance(surrogate.draws(encoded))[:, 0]
        wanted, predicted = 0.0, float(np.mean(draws))
        low, high = (float(one) for one in np.quantile(draws, [0.025, 0.975]))
        reached = NAN if features is None else distance
    return Outcome(
        name=target.name,
        unit=target.unit,
        wanted=wanted,
        predicted=predicted,
        low=low,
        high=high,
        reached=reached,
        distance=distance,
        within=within,
    )


def trial_table(trials: Sequence[Trial], runs: FitRuns, target: Target) -> Table:
    """Return every test of a search: its values, what it came to, its distance, and what was expected of it."""
    rows: list[dict[str, Cell]] = []
    for number, one in enumerate(trials, start=1):
        came = one.features is not None and target.scalar
        said = one.predicted if target.scalar else None
        rows.append(
            {
                "test": number,
                "round": one.round,
                **{name: _cell(value) for name, value in runs.values(one.z).items()},
                target.name: float(one.features[0]) if came and one.features is not None else NAN,
                "predicted": NAN if said is None else float(said.mean[0, 0]),
                "low 95 %": NAN if said is None else float(said.low[0, 0]),
                "high 95 %": NAN if said is None else float(said.high[0, 0]),
                "distance": one.distance if np.isfinite(one.distance) else NAN,
            }
        )
    units = dict.fromkeys((target.name, "predicted", "low 95 %", "high 95 %"), target.unit) | {"distance": "1"}
    return Table(name="design", columns={name: [row[name] for row in rows] for name in rows[0]}, units=units)


def _cell(value: object) -> Cell:
    return value if isinstance(value, int | float) and not isinstance(value, bool) else str(value)
