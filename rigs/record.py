"""Record of a run: equilibria, frames and outcome."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from math import prod
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from knitlab_core.equilibrium.stopwatch import Cost
from rigs.axes import FACE

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigs.axes import Axis, Direction, FloatArray

Phase = Literal["Zero", "Preload", "Stretch", "Recover", "Hold"]
End = Literal["target", "limit", "rupture", "timeout", "abort", "diverged", "slipped", "unravelled"]

#: The order gives the index under which a phase is stored.
PHASES: tuple[Phase, ...] = get_args(Phase)
ENDS: tuple[End, ...] = get_args(End)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecimenSize:
    """Lengths that turn travel into strain and force into stress.

    Attributes
    ----------
    extents : Mapping
        Initial hook-to-hook distance along each direction [m]. A planar knit's along the pile is its thickness by
        convention: the paper assumes a membrane of unit thickness, 1 mm.
    fibre_radius : float
        Radius of the yarn's tube [m].
    convention : {'unit', 'specimen'}
        Whether the thickness is agreed or the specimen's own.
    """

    extents: Mapping[Direction, float]
    fibre_radius: float
    convention: Literal["unit", "specimen"] = "unit"

    def gauge(self, axis: Axis) -> float:
        """Return the initial length by which the travel of an axis is strain [m]; of a shear that across its face."""
        return self.extents[FACE[axis]]

    def section(self, axis: Axis) -> float:
        """Return the initial area of the face that carries the force of an axis [m²]: both extents along it."""
        return prod(extent for across, extent in self.extents.items() if across != FACE[axis])


@dataclass(frozen=True, slots=True, kw_only=True)
class Equilibrium:
    """One accepted equilibrium, as the solver found it, before any instrument reads it.

    Attributes
    ----------
    time : float
        Time on the rig's clock [s].
    displacement : Mapping
        Change of the hook-to-hook distance of each driven axis [m]; of a shear how far its face went along it.
    crosshead : Mapping
        Way of the crosshead or carriages that the encoder of each axis sees [m]: with what the machine itself gives,
        and with a gripper's gap. On a rigid machine it is the displacement, which stands for it unless it is given.
    force : Mapping
        What the load cell of each driven axis feels [N], positive in tension.
    lateral_force : float
        Largest force of a hook along its pole [N].
    fixture_force : Mapping
        Force of every clamp or plate on the specimen along each direction [N], ``W+_C``: of the upper wale clamp along
        the course; empty where hooks hold it.
    pin_distance : Mapping
        Distance of the extensometer's two pins along each axis that it measures [m]; empty without one.
    elastic_stretch, elastic_bend, elastic_twist, contact_energy : float
        Stored energies [J].
    friction_work, external_work : float
        Work since the start: dissipated, and done by the carriages [J].
    viscous_work, plastic_work, fracture_work, snap_work : float
        Work lost since the start by a yarn that relaxes or yields; energy set free by fibres that broke, by snaps [J].
    bond_energy, bond_released : float
        Stored in fused points [J], and set free by those that broke since the start [J].
    bonds_whole, bonds_broken : int
        Fused points that hold, and that broke.
    clasps : Mapping
        Clasps that hold, by what they join: ``rows``, and ``layers`` of a volumetric knit; empty where unknown.
    cell : Mapping
        Lengths of a periodic cell along its axes, those that nothing drives too [m]; where it is free to shear also how
        far a vector leans along another axis, ``WC`` the wale's along the course. Empty for a specimen with edges.
    fibre_strain : float
        Largest strain at the surface of any fibre, |axial| + r |bending| [1].
    residual : float
        Largest free nodal force, friction's loads taken from the equilibrium itself, over the mean fixture force [1].
    contacts, iterations, factorisations : int
        Touching sample pairs; Newton iterations and factorisations since the row before, failed tries included.
    seconds : float
        Wall time of searches since the row before [s].
    cycle : int
        Counter of the set, from 1.
    phase : Phase
        What the axes were doing when they arrived here.
    tag : str or None
        Label of the protocol step.
    step : int
        Turn of the step in the test, from 0.
    """

    time: float
    displacement: Mapping[Axis, float]
    crosshead: Mapping[Axis, float] = field(default_factory=dict)
    force: Mapping[Axis, float]
    lateral_force: float
    fixture_force: Mapping[str, float] = field(default_factory=dict)
    pin_distance: Mapping[Axis, float] = field(default_factory=dict)
    elastic_stretch: float
    elastic_bend: float
    elastic_twist: float
    contact_energy: float
    friction_work: float
    external_work: float
    viscous_work: float = 0.0
    plastic_work: float = 0.0
    fracture_work: float = 0.0
    snap_work: float = 0.0
    bond_energy: float = 0.0
    bond_released: float = 0.0
    bonds_whole: int = 0
    bonds_broken: int = 0
    clasps: Mapping[str, int] = field(default_factory=dict)
    cell: Mapping[str, float] = field(default_factory=dict)
    fibre_strain: float = 0.0
    residual: float
    contacts: int
    iterations: int
    factorisations: int
    seconds: float
    cycle: int
    phase: Phase
    tag: str | None = None
    step: int = 0

    def __post_init__(self) -> None:
        if not self.crosshead:
            object.__setattr__(self, "crosshead", dict(self.displacement))

    def numbers(self) -> dict[str, float]:
        """Return the numbers under the names of their columns, ``force_C`` for that of the course."""
        flat: dict[str, float] = {}
        for one in fields(self):
            value = getattr(self, one.name)
            if isinstance(value, Mapping):
                flat |= {f"{one.name}_{axis}": part for axis, part in value.items()}
            elif one.name not in {"phase", "tag"}:
                flat[one.name] = value
        return flat


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """Shape of the knit at one equilibrium.

    Attributes
    ----------
    time : float
        Time on the rig's clock [s].
    nodes : FloatArray, shape (N, 3)
        Node positions [m].
    axial_strain : FloatArray, shape (E,)
        Axial strain of every edge, strand by strand [1]; nan where the fibre is broken.
    bending_strain : FloatArray, shape (E,)
        Strain of the fibre's surface by bending, at that end of the edge that bends more [1]; nan as above.
    contact_force : FloatArray, shape (N,)
        Sum of the contact loads on the yarn around every node [N].
    wires : FloatArray, shape (W, 2, 3)
        Both ends of every wire that the knit hangs on [m].
    strain : Mapping
        Effective strain of the specimen along each driven axis [1].
    cycle : int
        Counter of the set, from 1.
    phase : Phase
        What the axes were doing.
    image : str or None
        Name of the image that a microscope takes of this shape; None if it takes none.
    """

    time: float
    nodes: FloatArray
    axial_strain: FloatArray
    bending_strain: FloatArray
    contact_force: FloatArray
    strain: Mapping[Axis, float]
    cycle: int
    phase: Phase
    image: str | None = None
    wires: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 3)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How a run ended; a limit or a rupture is a result, not an error.

    Attributes
    ----------
    end : End
        ``target`` when the protocol was carried out to its last step.
    message : str
        One line for the user; empty when there is nothing to add.
    unfinished : Cost
        What was spent on searches after the last row, which came to no row.
    """

    end: End
    message: str = ""
    unfinished: Cost = field(default_factory=Cost)


def units(
    axes: Sequence[Axis],
    clasps: Iterable[str] = (),
    cell: Iterable[str] = (),
    fixtures: Iterable[str] = (),
    pins: Iterable[Axis] = (),
) -> dict[str, str]:
    """Return the SI unit of every column of an `Equilibrium`, in its order.

    Parameters
    ----------
    axes : sequence of Axis
        The axes that are driven.
    clasps : iterable of str
        What the knit's clasps join.
    cell : iterable of str
        Components of a periodic cell's vectors, ``C``, ``WC``.
    fixtures : iterable of str
        Forces of clamps or plates, ``W+_C``.
    pins : iterable of Axis
        Axes along which an extensometer measures.
    """
    return {
        "time": "s",
        **{f"displacement_{axis}": "m" for axis in axes},
        **{f"crosshead_{axis}": "m" for axis in axes},
        **{f"force_{axis}": "N" for axis in axes},
        "lateral_force": "N",
        **{f"fixture_force_{name}": "N" for name in fixtures},
        **{f"pin_distance_{axis}": "m" for axis in pins},
        "elastic_stretch": "J",
        "elastic_bend": "J",
        "elastic_twist": "J",
        "contact_energy": "J",
        "friction_work": "J",
        "external_work": "J",
        "viscous_work": "J",
        "plastic_work": "J",
        "fracture_work": "J",
        "snap_work": "J",
        "bond_energy": "J",
        "bond_released": "J",
        "bonds_whole": "1",
        "bonds_broken": "1",
        **{f"clasps_{joined}": "1" for joined in clasps},
        **{f"cell_{axis}": "m" for axis in cell},
        "fibre_strain": "1",
        "residual": "1",
        "contacts": "1",
        "iterations": "1",
        "factorisations": "1",
        "seconds": "s",
        "cycle": "1",
        "step": "1",
    }
