"""What is known of a specimen before any physics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

from app.checks.budget import loop_budgets
from knitlab_core.knits import clasp_counts
from rigs.axes import FACE
from rigs.machines.pins import distance, pins_on
from rigs.protocol.made_specimen import gauge_lengths, make_specimen
from rigs.protocol.specimen import SpecimenSpec

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from knitlab_core.knits import Specimen
    from rigs.axes import Axis, Direction
    from rigs.protocol.catalogue import Fixture
    from rigs.protocol.extensometer import Extensometer
    from rigs.protocol.protocol import Protocol

_ANY = "RGD8530-DM"  # a material, where none matters


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecimenFacts:
    """Facts of a specimen before any physics.

    Parameters
    ----------
    nodes : int
        Nodes of the yarn [1].
    yarn_length, clearance, fibre_radius : float
        Whole length, least surface distance of strands, radius of the fibre [m].
    gauge_lengths : Mapping
        Initial distance of the hooks, clamps or plates along each direction [m].
    locking_strain : float or None
        Estimated equibiaxial strain at which a loop has used up its yarn [1]; None where loops are
        not all alike.
    clasps : Mapping
        Heads that hold a loop, by what is joined: ``rows``, and ``layers`` of a volumetric knit; empty where unknown.
    pins : Mapping
        Distance of the extensometer's pins along each axis that it measures, as laid in [m].
    """

    nodes: int
    yarn_length: float
    clearance: float
    fibre_radius: float
    gauge_lengths: Mapping[Direction, float]
    locking_strain: float | None
    clasps: Mapping[str, int]
    pins: Mapping[Axis, float]

    def gauges(self, axes: Iterable[Axis]) -> dict[Axis, float]:
        """Return the gauge length of some axes [m]; of a shear that across its face."""
        return {axis: self.gauge_lengths[FACE[axis]] for axis in axes}


def describe(
    specimen: Specimen,
    fixtures: Mapping[Axis, Fixture] | None = None,
    extensometer: Extensometer | None = None,
) -> SpecimenFacts:
    """Return what is known of a specimen before any physics, between hooks or other fixtures of some axes.

    Raises
    ------
    SpecificationError
        If its stitches are not known, and an extensometer's pins are to be in them.
    """
    budgets = list(loop_budgets(specimen.fabric, specimen.yarn).values())
    return SpecimenFacts(
        nodes=len(specimen.nodes),
        yarn_length=specimen.yarn_length,
        clearance=specimen.clearance,
        fibre_radius=specimen.radius,
        gauge_lengths=gauge_lengths(specimen, fixtures),
        locking_strain=budgets[0].locking if len(budgets) == 1 else None,
        clasps=clasp_counts(specimen),
        pins={axis: distance(pins, axis, specimen.nodes) for axis, pins in pins_on(specimen, extensometer).items()},
    )


def shape_of(spec: SpecimenSpec) -> SpecimenSpec:
    """Return the specimen that represents all of the same shape, whatever they are made of."""
    if spec.grows_to is not None or spec.relaxed:
        return spec
    plain = SpecimenSpec(
        knit=spec.knit, rows=spec.rows, loops=spec.loops, loop_width=spec.loop_width, material=_ANY, layers=spec.layers
    )
    return replace(
        plain,
        nodes_per_loop=spec.nodes_per_loop,
        yarn=spec.laid,
        periodic=spec.periodic,
        rest_shape="as-printed" if spec.laid_in is None else "straight",
        laid_in=spec.laid_in,
        edges=spec.edges,
    )


@lru_cache(maxsize=256)
def _facts(
    shape: SpecimenSpec, fixtures: tuple[tuple[Axis, Fixture], ...], extensometer: Extensometer | None
) -> SpecimenFacts:
    """Return what is known of a shape; kept, for a sweep needs it a thousand times."""
    return describe(make_specimen(shape), dict(fixtures), extensometer)


def facts_of(protocol: Protocol) -> SpecimenFacts:
    """Return what is known of the specimen of a protocol."""
    return _facts(shape_of(protocol.specimen), tuple(protocol.fixtures.items()), protocol.extensometer)
