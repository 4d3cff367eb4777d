"""What a specimen is to the solver: rods, samples, contact law and prescribed unknowns."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.contact.bond_law import BondLaw
from knitlab_core.contact.bonds import Bonds, BondState, find_bonds
from knitlab_core.contact.compression import Compression
from knitlab_core.contact.friction import Memory
from knitlab_core.contact.law import ContactLaw
from knitlab_core.contact.samples import Samples
from knitlab_core.equilibrium.hook_friction import Hooks, PoleMemory
from knitlab_core.equilibrium.links import Links
from knitlab_core.equilibrium.strands import (
    SAMPLE_SPACING,
    SMALLEST_FLOOR,
    contact_of,
    force_floor,
    make_samples,
    storing,
)
from knitlab_core.equilibrium.ties import Ties, spread
from knitlab_core.rods.frames import Frames
from knitlab_core.rods.relaxation import Relaxation
from knitlab_core.rods.rod import Rods, make_rods
from knitlab_core.rods.section import SOLID, Section, with_section
from knitlab_core.rods.yielding import Yielding
from knitlab_core.units import Scales

DECIMALS = 9
"""Decimals of positions and of the fixtures' travel [r]: far below any tolerance, far above rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """Everything that does not change in a test, in the solver's units.

    Parameters
    ----------
    rods, samples, law
        Rest state and stiffness, contact samples, contact and friction law.
    fixed : (N, 4) bool array
        Unknowns that are prescribed; the dummy angle at each rod's end is always among them.
    scales : Scales
        What one unit is in SI.
    force_floor : float
        Smallest force by which residuals are judged [E r^2].
    relaxation : Relaxation or None
        How the rods' stiffness relaxes; None for elastic rods.
    yielding : Yielding or None
        How sections of the rods yield; None for rods that do not.
    bonds : Bonds or None
        Fused points as printed; None where strands do not fuse.
    hooks : Hooks or None
        Hooks on poles that rub, and wires; None where hooks are pins that slide freely.
    ties : Ties or None
        Nodes that are images of others in a periodic cell; None in a specimen with edges.
    links : Links or None
        Weak springs that hold strands where nothing else does; None where fixtures do.
    """

    rods: Rods
    samples: Samples
    law: ContactLaw
    fixed: BoolArray
    scales: Scales
    force_floor: float = SMALLEST_FLOOR
    relaxation: Relaxation | None = None
    yielding: Yielding | None = None
    bonds: Bonds | None = None
    hooks: Hooks | None = None
    ties: Ties | None = None
    links: Links | None = None

    def moved(self, q: FloatArray, target: FloatArray) -> FloatArray:
        """Return the motion (N, 4) from `q` of the fixed unknowns to a target, and of the images that follow them."""
        motion = np.where(self.fixed, target - q, 0.0)
        if self.ties is not None:
            spread(self.ties, motion)
        return motion


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """An equilibrium, with all that the next one depends on.

    Parameters
    ----------
    q : (N, 4) array
        Positions [r] and edge angles [rad].
    frames : Frames
        Reference frames of `q`.
    memory : Memory
        Friction's memory.
    reaction : (N, 4) array
        Force that the fixtures exert at fixed unknowns [E r^2], zero elsewhere.
    increment : (N, 4) array
        Motion since the equilibrium before.
    response : (N, 4) array or None
        Linear response to the motion of the fixtures since then, at this equilibrium; None where it is not known.
    contacts : int
        Sample pairs that press on each other.
    energies : (4,) array
        Stretching, bending, twisting and contact energy [E r^3].
    external_work, friction_work : float
        Work of the fixtures and loads, and against friction, since the start [E r^3].
    slip_change : float
        How much slip changed its rate in the step that led here [1]; see `step_control.path_error`.
    largest_load : float
        Largest sum of all pairs' loads so far [E r^2].
    history : (M, N, 5) array or None
        Inner strains of rods that relax; None where nothing has yet been strained, or nothing relaxes.
    plastic : (N, K, P) array or None
        Plastic strains in the sections of rods that yield; None where nothing has yet been strained, or nothing yields.
    viscous_work, plastic_work, fracture_work, snap_work : float
        Work lost by relaxing and yielding, and energy set free by fibres that broke and by snaps, in all [E r^3].
    bonds : BondState
        Which fused points are whole, their loads and their energies; empty where strands do not fuse.
    poles : PoleMemory
        Elastic slip and load of hooks on poles; empty where none rubs.
    """

    q: FloatArray
    frames: Frames
    memory: Memory
    reaction: FloatArray
    increment: FloatArray
    contacts: int
    energies: FloatArray
    external_work: float
    friction_work: float
    response: FloatArray | None = None
    slip_change: float = 0.0
    largest_load: float = 0.0
    history: FloatArray | None = None
    plastic: FloatArray | None = None
    viscous_work: float = 0.0
    plastic_work: float = 0.0
    fracture_work: float = 0.0
    snap_work: float = 0.0
    bonds: BondState = field(default_factory=lambda: BondState.printed(0))
    poles: PoleMemory = field(default_factory=PoleMemory.empty)


def make_model(  # noqa: PLR0913 (each is a part of the model)
    strands: Sequence[FloatArray],
    *,
    radius: float,
    young_modulus: float,
    poisson_ratio: float,
    friction: float,
    straight: bool = False,
    printed: bool = False,
    section: Section = SOLID,
    compression: Compression | None = None,
    sample_spacing: float = SAMPLE_SPACING,
    bonds: BondLaw | None = None,
    wires: Sequence[FloatArray] = (),
) -> tuple[Model, State]:
    """Make the model of strands of one kind and their state as given, free of stress.

    Parameters
    ----------
    strands : sequence of (n, 3) arrays
        Nodes of each strand [m].
    radius : float
        Radius at which strands touch [m]: the fibre's, or a yarn's outer one.
    young_modulus : float
        Of the fibre's material [Pa], also in contact; of a yarn by measurement its reference modulus.
    poisson_ratio, friction : float
        Poisson's ratio and Coulomb's coefficient.
    straight : bool
        Rest shape straight instead of as given.
    printed : bool
        Strands are clear of each other and of wires as given, so contact stores nothing there (decision 0023). Else
        its force begins at the onset of `make_law`, and strands may be given pressed together.
    section : Section
        Stiffness of a strand relative to a solid round rod of that radius.
    compression : Compression, optional
        How strands of that radius are flattened where they touch; by default as Hertz has it of solids.
    sample_spacing : float
        Distance of contact samples along a strand [r].
    bonds : BondLaw, optional
        How strands that were printed near each other are fused; by default they are not.
    wires : sequence of (n, 3) arrays
        Rigid strands, whose nodes come after those of the others [m]. They store nothing and fuse with nothing;
        whoever makes them prescribes them.

    Returns
    -------
    Model, State
        With nothing prescribed yet but the dummy angles.

    Raises
    ------
    GeometryError
        If printed strands overlap by more than a mesh may.
    """
    every = [*strands, *wires]
    sizes = tuple(len(s) for s in every)
    soft = np.arange(sum(sizes)) < sum(len(s) for s in strands)
    # Rounding of the last digits would grow wherever strands snap: a knit of any size starts from the same numbers.
    # Kernels would be compiled again for arrays in column order, as knits come.
    x = np.ascontiguousarray(np.round(np.concatenate(every) / radius, DECIMALS))
    rods, frames = make_rods(x, sizes, poisson_ratio=poisson_ratio, straight=straight)
    fixed = np.zeros((len(x), 4), dtype=np.bool_)
    fixed[:, 3] = ~rods.has_edge
    rods = storing(with_section(rods, section), soft)
    state = unstressed(np.column_stack([x, np.zeros(len(x))]), frames)
    edge = float(rods.rest_length[rods.has_edge & soft].mean())
    scales = Scales(radius=radius, young_modulus=young_modulus)
    samples, law = contact_of(
        partial(make_samples, rods, sizes, edge),
        state.q,
        scales,
        poisson_ratio=poisson_ratio,
        friction=friction,
        compression=compression,
        spacing=sample_spacing,
        printed=printed,
    )
    model = Model(
        rods=rods,
        force_floor=force_floor(rods),
        samples=samples,
        law=law,
        fixed=fixed,
        scales=scales,
    )
    if bonds is None:
        return model, state
    fusing = samples._replace(spans=samples.spans[soft[samples.spans]])
    found = find_bonds(state.q, frames, rods.has_edge, fusing, law, bonds, model.scales, poisson_ratio)
    return replace(model, bonds=found), replace(state, bonds=BondState.printed(found.a.size))


def unstressed(q: FloatArray, frames: Frames) -> State:
    """Return the state of rods as they were made: nothing stored, nothing remembered."""
    return State(
        q=q,
        frames=frames,
        memory=Memory.empty(),
        reaction=np.zeros_like(q),
        increment=np.zeros_like(q),
        contacts=0,
        energies=np.zeros(4),
        external_work=0.0,
        friction_work=0.0,
    )
