"""Make a yarn of fibres: how many, how thick, and how they wind around the yarn's centreline."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from knitlab_core.angles import cosine, sine
from knitlab_core.errors import GeometryError, SpecificationError
from knitlab_core.knits.directors import directors
from knitlab_core.knits.loop_shape import is_positive

if TYPE_CHECKING:
    from knitlab_core.arrays import FloatArray, IndexArray
    from knitlab_core.knits.centreline import Centreline

YarnModel: TypeAlias = Literal["yarn", "bundle"]

MOST_FIBRES: Final = 64
LARGEST_RADIUS: Final = 0.5
LARGEST_TWIST: Final = 200.0
PRINTED_GAP: Final = 0.1
"""Gap between neighbouring fibres as printed, unless told otherwise [fibre radii]: more than the contact's onset."""

LARGEST_TURN: Final = 0.5
"""Largest turn of a bundle's fibres from node to node [rad]: splines then keep R to 0.05 %."""

_TURN_SAMPLES: Final = 4097


@dataclass(frozen=True, slots=True, kw_only=True)
class Yarn:
    """Yarn of fibres, and the model that the solver has of it.

    Fibre j runs at ``gamma(s) + R (cos th e2 + sin th e3)``, ``th = twist s + phase + 2 pi j / n``, where s is
    the arc length of the yarn's centreline from its start and e2, e3 are its rotation-minimising directors.

    Parameters
    ----------
    fibres : int
        ``n``, 1 to 64.
    fibre_radius : float
        ``r`` [loop widths].
    winding_radius : float
        ``R``: distance of each fibre's centre from the yarn's [loop widths]; 0 for one fibre alone.
    twist : float
        ``omega`` [rad per loop width of the centreline's arc length], positive for a right-handed helix.
    phase : float
        Angle of the first fibre from the director e2 at the yarn's start, which is the out-of-plane axis [rad].
    model : {'yarn', 'bundle'}
        One rod with the section of all fibres, or each fibre a rod of its own (``docs/decisions/0008``).
    bonding : float
        Only for ``yarn``: 0 for fibres that slide on each other freely, 1 for fibres glued together.

    Raises
    ------
    SpecificationError
        If a value is out of its bounds.
    GeometryError
        If the fibres of a straight yarn overlap.

    References
    ----------
    Cline et al., "Entanglement-driven responses through multiscale 3D-printed knits"; it takes Frenet's
    frame, which stitches without inflections share up to their torsion.
    """

    fibres: int = 1
    fibre_radius: float
    winding_radius: float = 0.0
    twist: float = 0.0
    phase: float = 0.0
    model: YarnModel = "yarn"
    bonding: float = 0.0

    def __post_init__(self) -> None:
        count: object = self.fibres
        if not isinstance(count, int) or isinstance(count, bool) or not 1 <= count <= MOST_FIBRES:
            raise SpecificationError("yarn.fibres", count, f"a whole number from 1 to {MOST_FIBRES}")
        if not is_positive(self.fibre_radius) or self.fibre_radius > LARGEST_RADIUS:
            allowed = f"a number above 0 and at most {LARGEST_RADIUS:g}, in loop widths"
            raise SpecificationError("yarn.fibre_radius", self.fibre_radius, allowed)
        _check_number("winding_radius", self.winding_radius, 0.0, LARGEST_RADIUS, "in loop widths")
        _check_number("twist", self.twist, -LARGEST_TWIST, LARGEST_TWIST, "in rad per loop width of yarn")
        _check_number("phase", self.phase, -2.0 * math.pi, 2.0 * math.pi, "in rad")
        _check_number("bonding", self.bonding, 0.0, 1.0, "from loose to glued")
        if self.model not in ("yarn", "bundle"):
            raise SpecificationError("yarn.model", self.model, "'yarn' or 'bundle'")
        if self.fibres == 1 and self.winding_radius > 0.0 and self.model == "yarn":
            raise SpecificationError("yarn.model", self.model, "'bundle' for one fibre that winds: it is a spring")
        if self.straight_gap <= 0.0:
            found = f"fibres whose centres are {self.straight_gap + 2.0 * self.fibre_radius:.4g} loop widths apart"
            allowed = f"more than 2 r = {2.0 * self.fibre_radius:.4g} loop widths: a larger R or less twist"
            raise GeometryError("yarn.winding_radius", found, allowed)

    @property
    def outer_radius(self) -> float:
        """Return R + r, the radius of the tube that holds all fibres [loop widths]."""
        return self.winding_radius + self.fibre_radius

    @property
    def contact_radius(self) -> float:
        """Return the radius at which a yarn seen as one rod touches others [loop widths].

        Loose fibres make room for each other until a yarn is as thick as its material, r sqrt(n); glued ones keep
        the outer radius; between them it goes with the bonding. The fibres of a bundle touch at their own radius.
        """
        if self.model == "bundle":
            return self.fibre_radius
        packed = self.fibre_radius * math.sqrt(self.fibres)
        return packed + self.bonding * (self.outer_radius - packed)

    @property
    def phases(self) -> FloatArray:
        """Return the angle (n,) of each fibre at the yarn's start [rad]."""
        spread: FloatArray = self.phase + 2.0 * np.pi * np.arange(self.fibres) / self.fibres
        return spread

    @property
    def straight_gap(self) -> float:
        """Return the least gap between the surfaces of neighbouring fibres of a straight yarn [loop widths].

        Infinite for one fibre that is not wound, or not twisted.
        """
        if self.fibres == 1 and self.winding_radius * self.twist == 0.0:
            return math.inf
        least = _helix_distance(self.fibres, self.winding_radius, self.twist)
        return least - 2.0 * self.fibre_radius


def same_area(
    single_radius: float,
    fibres: int,
    *,
    gap: float = PRINTED_GAP,
    model: YarnModel = "yarn",
    bonding: float = 0.0,
) -> Yarn:
    """Divide a single fibre into n that have its area together, untwisted and just apart.

    Parameters
    ----------
    single_radius : float
        Radius of the single fibre, r1 [loop widths].
    fibres : int
        ``n``; each has the radius r1 / sqrt(n).
    gap : float
        Gap between neighbours [fibre radii].
    model : {'yarn', 'bundle'}
        How the solver shall see the yarn.
    bonding : float
        Of a yarn seen as one rod, from 0, loose, to 1, glued.

    Returns
    -------
    Yarn
        With ``R = r (1 + gap/2) / sin(pi/n)``; R = 0 for one fibre.
    """
    radius = single_radius / math.sqrt(fibres)
    winding = 0.0 if fibres == 1 else radius * (1.0 + 0.5 * gap) / float(sine(np.array(math.pi / fibres)))
    return Yarn(fibres=fibres, fibre_radius=radius, winding_radius=winding, model=model, bonding=bonding)


def fibre_strands(centreline: Centreline, arc_lengths: FloatArray, yarn: Yarn) -> tuple[FloatArray, ...]:
    """Return the points of every fibre beside given spots of the centreline.

    Parameters
    ----------
    centreline : Centreline
        The yarn's middle.
    arc_lengths : FloatArray
        (m,) spots on it [loop widths]; they may be as dense as one likes.
    yarn : Yarn
        The fibres.

    Returns
    -------
    tuple of FloatArray
        n arrays (m, 3) [loop widths]. Point k of each fibre is in the centreline's cross-section at spot k.
    """
    middle = centreline.position(arc_lengths)
    if yarn.winding_radius == 0.0:
        return (middle,)
    e2, e3 = directors(centreline, arc_lengths)
    angles = yarn.twist * arc_lengths + yarn.phases[:, None]
    return tuple(
        middle + yarn.winding_radius * (cosine(angle)[:, None] * e2 + sine(angle)[:, None] * e3) for angle in angles
    )


def check_turn(yarn: Yarn, arc_lengths: FloatArray) -> None:
    """Refuse nodes between which fibres turn about the yarn by more than `LARGEST_TURN`.

    Parameters
    ----------
    yarn : Yarn
        The fibres; only those of a bundle have nodes of their own.
    arc_lengths : FloatArray
        (m,) nodes along the centreline [loop widths].

    Raises
    ------
    SpecificationError
        Saying how much longer the edges are than they may be.
    """
    turn = abs(yarn.twist) * float(np.diff(arc_lengths).max())
    if yarn.model == "bundle" and turn > LARGEST_TURN:
        found = f"edges along which fibres turn by {turn:.3g} rad"
        allowed = f"at most {LARGEST_TURN:g} rad: {turn / LARGEST_TURN:.3g} times as many nodes, or less twist"
        raise SpecificationError("specimen.nodes_per_loop", found, allowed)


def fibre_sites(sites: IndexArray, *, nodes: int, fibres: int) -> IndexArray:
    """Return the nodes that a hook on the yarn holds: one of each fibre.

    Parameters
    ----------
    sites : IndexArray
        (k,) node numbers on a yarn of one strand.
    nodes : int
        Nodes per strand.
    fibres : int
        Strands, concatenated one after the other.

    Returns
    -------
    IndexArray
        (k, n) node numbers in the concatenation, a row per hook.
    """
    held: IndexArray = np.add.outer(sites, nodes * np.arange(fibres))
    return held


def _check_number(field: str, found: object, low: float, high: float, unit: str) -> None:
    if not isinstance(found, int | float) or isinstance(found, bool) or not low <= found <= high:
        raise SpecificationError(f"yarn.{field}", found, f"a number from {low:g} to {high:g}, {unit}")


def _helix_distance(fibres: int, winding_radius: float, twist: float) -> float:
    """Return the least distance between neighbouring helices, or between turns of a single one.

    ``d^2 = 2 R^2 (1 - cos(2 pi/n - psi)) + (psi / omega)^2``, psi the angle by which the second is farther along.
    """
    apart = 2.0 * math.pi / fibres
    if twist == 0.0:
        return 2.0 * winding_radius * math.sin(0.5 * apart)
    # Of a single helix the half turn next to the point itself is left out.
    psi = np.linspace(0.5 * apart if fibres == 1 else 0.0, apart, _TURN_SAMPLES)
    squared = 2.0 * winding_radius**2 * (1.0 - np.cos(apart - psi)) + (psi / twist) ** 2
    return math.sqrt(float(squared.min()))
