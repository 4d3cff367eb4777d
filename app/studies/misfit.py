"""Differences between measured tests and runs, over coordinates of the parameters; their derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from app.records.folder import RECORD
from app.records.reader import RunReader
from app.views.overlay import run_groups
from knitlab_core.errors import SpecificationError
from rigs.analysis.comparison import quantities
from rigs.analysis.estimation import STEP
from rigs.analysis.residuals import residuals

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from app.studies.fit_runs import FitRuns
    from rigs.analysis.alignment import Alignment
    from rigs.analysis.comparison import Across, Along, Group
    from rigs.analysis.residuals import Residuals
    from rigs.axes import FloatArray


@dataclass(slots=True, kw_only=True)
class Misfit:
    """Residuals of the runs at coordinates of the parameters, in the order of tests and branches."""

    runs: FitRuns
    groups: Sequence[Group]
    how: Alignment
    _layout: list[tuple[object, ...]] | None = None
    _kept: dict[Path, dict[tuple[str, str], list[Residuals]]] = field(default_factory=dict)

    def __call__(self, z: FloatArray) -> FloatArray:
        """Return all residuals (m,); infinite where values cannot be run, which makes the search's step smaller."""
        return self._vector(self.runs.at([z])[0])

    def parts(self, z: FloatArray) -> dict[tuple[str, str], list[Residuals]]:
        """Return the residuals branch by branch."""
        folder = self.runs.at([z])[0]
        return {} if folder is None else self._parts(folder)

    def forward(self, z: FloatArray) -> FloatArray:
        """Return the Jacobian (m, p) by one step of each parameter, back where there is no room ahead."""
        steps = [STEP if place + STEP <= 1.0 else -STEP for place in z]
        return self._differences(z, [(z, _moved(z, k, step)) for k, step in enumerate(steps)])

    def central(self, z: FloatArray) -> FloatArray:
        """Return the Jacobian (m, p) by a step each way, within the bounds."""
        return self._differences(z, [(_moved(z, k, -STEP), _moved(z, k, STEP)) for k in range(len(z))])

    def _differences(self, z: FloatArray, pairs: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
        """Return finite differences; from the middle where one of the ends cannot be run."""
        self.runs.at([z, *(end for pair in pairs for end in pair)])
        columns = []
        for k, pair in enumerate(pairs):
            ends = [end for end in (pair[0], z, pair[1]) if np.isfinite(self(end)).all()]
            width = float(ends[-1][k] - ends[0][k])
            if width == 0.0:
                raise SpecificationError(
                    "--fit", self.runs.said(pair[1]), "bounds within which the protocol can be run"
                )
            columns.append((self(ends[-1]) - self(ends[0])) / width)
        return np.stack(columns, axis=1)

    def quantities(self, folder: Path | None) -> tuple[Across, Along]:
        """Return what is compared over what."""
        return quantities([*self.groups, *([] if folder is None else run_groups(folder, self.how))])

    def uncovered(self, z: FloatArray) -> list[str]:
        """Return a note of every branch that the best run does not reach the end of."""
        return [
            f"{name}{', ' * bool(axis)}{axis}, {one.name}: the best run covers {100.0 * one.covered:.0f} % of the rows"
            for (name, axis), each in self.parts(z).items()
            for one in each
            if one.covered < 0.98
        ]

    def _vector(self, folder: Path | None) -> FloatArray:
        parts = {} if folder is None else self._parts(folder)
        layout: list[tuple[object, ...]] = [(*key, one.name, len(one.x)) for key, each in parts.items() for one in each]
        if self._layout is None:
            self._layout = layout
        if layout != self._layout or not layout:
            # The first run says which branches count.
            return np.full(max(sum(int(str(one[-1])) for one in self._layout), 1), np.inf)
        return np.concatenate([one.scaled for each in parts.values() for one in each])

    def _parts(self, folder: Path) -> dict[tuple[str, str], list[Residuals]]:
        """Return the residuals of a run, read once."""
        if folder not in self._kept:
            self._kept[folder] = self._compared(folder)
        return self._kept[folder]

    def _compared(self, folder: Path) -> dict[tuple[str, str], list[Residuals]]:
        if len(RunReader(folder / RECORD).trace) < 2:
            return {}
        models = {group.axis: group.tests[0] for group in run_groups(folder, self.how)}
        across, along = self.quantities(folder)
        found = {}
        for group in self.groups:
            axis = group.axis or (next(iter(models)) if len(models) == 1 else "")
            if axis not in models:
                expected = f"one of {', '.join(models)}, which the protocol drives"
                raise SpecificationError("--axis", axis or f"none in {group.name}", expected)
            for number, test in enumerate(group.tests, start=1):
                name = group.name if len(group.tests) == 1 else f"{group.name}, {number}"
                found[name, axis] = residuals(test, models[axis], across, along)
        return found


def _moved(z: FloatArray, k: int, step: float) -> FloatArray:
    """Return coordinates with one of them moved, within 0 and 1."""
    found = z.copy()
    found[k] = min(max(found[k] + step, 0.0), 1.0)
    return found
