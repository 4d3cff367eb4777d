"""Where a test strains a fibre beyond a limit of its material that the model does not include."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigs.axes import Axis
    from rigs.protocol.specimen import SpecimenSpec
    from rigs.record import Equilibrium, SpecimenSize
    from rigs.trace import Trace

LimitName: TypeAlias = Literal["strength", "elongation at break"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialLimit:
    """Limit of a material as the strain at the surface of a fibre that reaches it.

    Attributes
    ----------
    name : {'strength', 'elongation at break'}
        Which number of the material it is.
    strain : float
        Strain at the fibre's surface [1]: the elongation itself, or the strength over Young's modulus.
    text : str
        The limit with its value and unit, such as ``strength of 55 MPa``.
    """

    name: LimitName
    strain: float
    text: str

    @property
    def consequence(self) -> str:
        """Return what passing the limit means for the rest of the record."""
        if self.name == "strength":
            return "from there on the elastic fibre carries more than the material does"
        return "from there on a real fibre would have broken"

    def crossed(self, number: int, row: Equilibrium, strain: Mapping[Axis, float]) -> LimitCrossing:
        """Return the crossing at a row of the equilibria, with the strains of the specimen there [1]."""
        return LimitCrossing(limit=self, row=number, time=row.time, strain=strain, fibre_strain=row.fibre_strain)


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitCrossing:
    """Row of a run at which a fibre first passed a limit of its material.

    Attributes
    ----------
    limit : MaterialLimit
        The limit.
    row : int
        Row of the equilibria, from 0.
    time : float
        Time of the row on the rig's clock [s].
    strain : Mapping
        Effective strain of the specimen along each driven axis [1].
    fibre_strain : float
        Largest strain at the surface of any fibre [1].
    """

    limit: MaterialLimit
    row: int
    time: float
    strain: Mapping[Axis, float]
    fibre_strain: float

    def __str__(self) -> str:
        """Return one line for the user."""
        where = ", ".join(f"{axis} {100 * value:.1f} %" for axis, value in self.strain.items())
        return (
            f"{self.limit.text} passed at {self.time:.4g} s, strain {where}: a fibre is strained by "
            f"{100 * self.fibre_strain:.3g} %, limit {100 * self.limit.strain:.3g} %; {self.limit.consequence}"
        )

    def data(self) -> dict[str, Any]:
        """Return the crossing as plain data, SI units."""
        return {
            "name": self.limit.name,
            "limit": self.limit.strain,
            "row": self.row,
            "time": self.time,
            "strain": {str(axis): value for axis, value in self.strain.items()},
            "fibre_strain": self.fibre_strain,
            "text": str(self),
        }


def limits_of(spec: SpecimenSpec) -> tuple[MaterialLimit, ...]:
    """Return the limits of a specimen's material that the model does not keep to, the lowest strain first.

    Where fibres break (`rupture`), strains beyond the breaking strain do not occur; a lower limit may still be passed.
    With `viscoelastic` the stress of a fibre is less than Young's modulus times strain, so its strength says nothing
    of the strain unless it is the only number known; nor does it with `yields`, where stress follows a curve. A yarn by
    measurement has no limits.
    """
    if spec.measured is not None:
        return ()
    material, found = spec.solid, []
    elongation, strength = material.elongation_at_break, material.strength
    if strength is not None and not ((spec.viscoelastic or spec.yields) and elongation is not None):
        text = f"strength of {1e-6 * strength.value:.4g} MPa{' (assumed)' if strength.assumed else ''}"
        found.append(MaterialLimit(name="strength", strain=strength.value / material.young_modulus.value, text=text))
    if elongation is not None:
        text = f"elongation at break of {100 * elongation.value:.4g} %{' (assumed)' if elongation.assumed else ''}"
        found.append(MaterialLimit(name="elongation at break", strain=elongation.value, text=text))
    breaks_at = float("inf") if spec.breaks_at is None else spec.breaks_at
    return tuple(sorted((limit for limit in found if limit.strain < breaks_at), key=lambda limit: limit.strain))


def crossings(trace: Trace, size: SpecimenSize, limits: Sequence[MaterialLimit]) -> tuple[LimitCrossing, ...]:
    """Return where a run first passed each limit, in the order of the limits; those not passed are left out."""
    found = []
    for limit in limits:
        beyond = np.flatnonzero(trace.columns["fibre_strain"] > limit.strain)
        if len(beyond):
            row = int(beyond[0])
            columns = {name: float(column[row]) for name, column in trace.columns.items()}
            found.append(
                LimitCrossing(
                    limit=limit,
                    row=row,
                    time=columns["time"],
                    strain={axis: columns[f"displacement_{axis}"] / size.gauge(axis) for axis in trace.axes},
                    fibre_strain=columns["fibre_strain"],
                )
            )
    return tuple(found)


def unused_yield(trace: Trace, spec: SpecimenSpec) -> str:
    """Return one line for the user where a specimen may yield and no fibre did; empty otherwise."""
    if not spec.yields or not len(trace) or trace.columns["plastic_work"].max() > 0.0:
        return ""
    begins = spec.solid.yield_curve[0].strain.value
    reached = float(trace.columns["fibre_strain"].max())
    return f"nothing yielded: fibres were strained by {reached:.2%} at most, and yield begins at {begins:.2%}"
