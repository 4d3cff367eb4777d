"""Load train of an axis: what lies between the crosshead, or the carriages, and the specimen's fixture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigs.machines.machine import MachineData


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadTrain:
    """Load train of an axis: everything between the crosshead, or the carriages, and the specimen's fixture.

    Attributes
    ----------
    compliance : float
        How far the machine gives way under a force [m/N].
    gap : float
        Way that a gripper makes before it takes hold [m].
    slowest, fastest : float
        Speeds that the machine has, as those of the hook-to-hook length [m/s].
    digit : float
        Smallest digit of the axis' load cell [N].
    """

    compliance: float
    gap: float
    slowest: float
    fastest: float
    digit: float

    @property
    def rigid(self) -> bool:
        """Return whether the fixture stands where the crosshead does."""
        return self.compliance == 0.0 and self.gap == 0.0

    def beyond(self, travel: float, force: float) -> float:
        """Return where the crosshead stands [m] that holds a fixture at a travel [m] under a force [N]."""
        return travel + self.compliance * force + self.gap


def load_train(numbers: MachineData) -> LoadTrain:
    """Return what lies between crosshead and fixture on a machine."""
    carriage = numbers.carriage
    return LoadTrain(
        compliance=carriage.compliance.value,
        gap=0.0 if carriage.gap is None else carriage.gap.value,
        slowest=0.0 if carriage.min_speed is None else carriage.min_speed.value,
        fastest=carriage.max_speed.value,
        digit=numbers.load_cell.resolution.value,
    )
