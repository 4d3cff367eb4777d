"""The model of a periodic cell: strands that leave on one side and enter on the other, with images all around.

Every strand of the cell repeats along one lattice vector, a sum of whole multiples of the cell's vectors. Its first two
nodes follow its last one as images, so that its last spans are whole; images of all strands lie around the cell, and
touch it. Of two images that are each other's opposite one is enough: a pair of strands that meet across a side of the
cell meets across the opposite side as well, and is counted once (`half_space`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray, IndexArray
from knitlab_core.contact.compression import Compression
from knitlab_core.contact.samples import Samples
from knitlab_core.equilibrium.cell_links import cell_links
from knitlab_core.equilibrium.model import DECIMALS, Model, State, unstressed
from knitlab_core.equilibrium.strands import SAMPLE_SPACING, contact_of, force_floor, make_samples, storing
from knitlab_core.equilibrium.ties import Ties
from knitlab_core.rods.rod import Rods, make_rods
from knitlab_core.rods.section import SOLID, Section, with_section
from knitlab_core.units import Scales

Shift = tuple[int, ...]


class Period(NamedTuple):
    """One strand of a cell: `nodes` (n, 3) of one period [m], `shift` (D,) to the next in multiples of the vectors."""

    nodes: FloatArray
    shift: Shift


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Where the nodes of a cell's model come from.

    Attributes
    ----------
    copied : (N,) array
        Node of the cell of which a node is an image, or that it is itself; -1 at the nodes of the cell's vectors.
    shifts : (N, D) array
        Multiples of the cell's vectors between the two.
    sizes : tuple of int
        Nodes of every strand, images of strands and nodes of vectors after those of the cell.
    own : int
        Strands of the cell.
    """

    copied: IndexArray
    shifts: IndexArray
    sizes: tuple[int, ...]
    own: int

    @property
    def cell(self) -> IndexArray:
        """Return the nodes whose positions are the cell's vectors, (D,)."""
        return np.flatnonzero(self.copied < 0)

    @property
    def images(self) -> IndexArray:
        """Return the nodes that are images, (G,)."""
        return np.flatnonzero((self.copied >= 0) & (self.copied != np.arange(self.copied.size)))

    @property
    def ties(self) -> Ties:
        """Return what ties the images."""
        images = self.images
        return Ties.of(self.copied.size, images, self.copied[images], self.shifts[images], self.cell)


def half_space(reach: Sequence[int]) -> list[Shift]:
    """Return the images around a cell up to so many cells away along each vector, one of every two opposite ones."""
    every = product(*(range(-most, most + 1) for most in reach))
    return [shift for shift in every if shift[::-1] > (0,) * len(reach)]


def lay_out(strands: Sequence[Period], reach: Sequence[int]) -> Layout:
    """Return the nodes of a cell: its strands each with two nodes of the next period, their images, its vectors."""
    copied, shifts, sizes = [], [], []
    first = 0
    for nodes, shift in strands:
        own = np.arange(first, first + len(nodes))
        copied.append(np.concatenate([own, own[:2]]))
        shifts.append(np.concatenate([np.zeros((len(nodes), len(shift)), np.int64), np.tile(shift, (2, 1))]))
        sizes.append(len(nodes) + 2)
        first += len(nodes) + 2
    every, far = np.concatenate(copied), np.concatenate(shifts)
    around = half_space(reach)
    none = np.zeros((len(reach), len(reach)), np.int64)
    return Layout(
        copied=np.concatenate([every, *[every for _ in around], np.full(len(reach), -1)]),
        shifts=np.concatenate([far, *[far + np.array(shift) for shift in around], none]),
        sizes=(*sizes, *sizes * len(around), *(1 for _ in reach)),
        own=len(strands),
    )


def _placed(strands: Sequence[Period], vectors: FloatArray, layout: Layout, radius: float) -> FloatArray:
    """Return where the nodes of a layout are as printed (N, 3) [r]."""
    cell = np.round(np.asarray(vectors) / radius, DECIMALS)
    own = [np.concatenate([nodes, nodes[:2]]) for nodes, _ in strands]
    masters = np.round(np.concatenate(own) / radius, DECIMALS)
    x = np.empty((layout.copied.size, 3))
    x[layout.cell] = cell
    real = layout.copied >= 0
    # Summed vector by vector: a matrix product may round otherwise elsewhere.
    moved = masters[layout.copied[real]]
    for d in range(len(cell)):
        moved = moved + layout.shifts[real, d : d + 1] * cell[d]
    x[real] = moved
    return x


def make_cell(  # noqa: PLR0913 (each is a part of the model)
    strands: Sequence[Period],
    vectors: FloatArray,
    reach: Sequence[int],
    *,
    neighbours: Sequence[tuple[int, int]] | None = None,
    stitches: int = 1,
    radius: float,
    young_modulus: float,
    poisson_ratio: float,
    friction: float,
    straight: bool = False,
    section: Section = SOLID,
    compression: Compression | None = None,
    sample_spacing: float = SAMPLE_SPACING,
) -> tuple[Model, State]:
    """Make the model of a periodic cell and its state as printed, free of stress.

    Parameters
    ----------
    strands : sequence of Period
        The strands of the cell.
    vectors : (D, 3) array
        The cell's vectors [m].
    reach : sequence of int
        So many cells away along each vector strands may touch.
    neighbours : sequence of (int, int), optional
        Pairs of strands that are linked where nothing else holds them (`cell_links`); by default each with the next.
    stitches : int
        Stitches of a strand in the cell that one link holds.
    radius, young_modulus, poisson_ratio, friction, straight, section, compression, sample_spacing
        As for `make_model`; a yarn that is not straight at rest is taken as printed.

    Returns
    -------
    Model, State
        The position of one node is prescribed, against motions of the cell as a whole, and so are the cell's vectors.
        Those of their components that shall be free are for the caller to set free.

    Raises
    ------
    GeometryError
        If printed strands overlap by more than a mesh may.
    """
    layout = lay_out(strands, reach)
    pairs = list(pairwise(range(len(strands)))) if neighbours is None else neighbours
    x, ties = _placed(strands, vectors, layout, radius), layout.ties
    n, sizes = len(x), layout.sizes
    soft = np.arange(n) < sum(sizes[: layout.own])
    rods, frames = make_rods(x, sizes, poisson_ratio=poisson_ratio, straight=straight)
    rods = _of_cell(storing(with_section(rods, section), soft), soft)
    fixed = np.zeros((n, 4), dtype=np.bool_)
    fixed[:, 3] = ~rods.has_edge
    fixed[_middle(x, layout), :3] = True
    fixed[layout.cell] = True
    state = unstressed(np.column_stack([x, np.zeros(n)]), frames)
    edge = float(rods.rest_length[rods.has_edge & soft].mean())
    scales = Scales(radius=radius, young_modulus=young_modulus)
    samples, law = contact_of(
        partial(_samples, rods, layout, edge),
        state.q,
        scales,
        poisson_ratio=poisson_ratio,
        friction=friction,
        compression=compression,
        spacing=sample_spacing,
        printed=not straight,
    )
    model = Model(
        rods=rods,
        force_floor=force_floor(rods._replace(is_inner=rods.is_inner & soft)),
        samples=samples,
        law=law,
        fixed=fixed,
        scales=scales,
        ties=ties,
        links=cell_links(x, [nodes for nodes, _ in strands], layout.sizes, layout.cell, pairs, stitches),
    )
    return model, state


def _of_cell(rods: Rods, soft: BoolArray) -> Rods:
    """Return rods without the halves of edges at their ends, which belong to spans of the next period."""
    return rods._replace(
        stretch_stiffness=np.where(rods.is_inner, rods.stretch_stiffness, 0.0), is_inner=rods.is_inner & soft
    )


def _middle(x: FloatArray, layout: Layout) -> int:
    """Return the node of the cell that is nearest to its middle."""
    own = np.flatnonzero(layout.copied == np.arange(len(x)))
    away = x[own] - x[own].mean(axis=0)
    return int(own[np.argmin((away * away).sum(axis=1))])


def _samples(rods: Rods, layout: Layout, edge: float, spacing: float) -> Samples:
    """Spread contact samples along the strands of a cell and their images, numbered along strands without end."""
    inner = rods.has_edge.copy()
    inner[1:] &= rods.has_edge[:-1]
    inner[0] = False
    samples = make_samples(rods._replace(is_inner=inner), layout.sizes, edge, spacing)
    own = sum(layout.sizes[: layout.own])
    strand, arc = samples.strand.copy(), samples.arc.copy()
    repeats = (len(strand) - len(layout.cell)) // own
    image = np.zeros(len(strand), dtype=np.bool_)
    image[own:] = True
    ends = np.cumsum(layout.sizes[: layout.own])
    for k, (end, size) in enumerate(zip(ends, layout.sizes, strict=False)):
        first = end - size
        length = float(rods.rest_length[first : end - 2].sum())
        along = layout.shifts[end - 1]
        for copy in range(repeats):
            at = slice(copy * own + first, copy * own + end)
            strand[at] = k
            # An image further along its own strand goes on where the strand ends.
            moved = layout.shifts[copy * own + first]
            ahead = _multiple(moved, along)
            if ahead is None:
                strand[at] = len(ends) + copy * len(ends) + k
                ahead = 0
            arc[at] = arc[first:end] - arc[first] + ahead * length
    return samples._replace(strand=strand, arc=arc, image=image)


def _multiple(shift: IndexArray, of: IndexArray) -> int | None:
    """Return k where a shift is k times another, None where it is no multiple."""
    axis = int(np.argmax(np.abs(of)))
    k, rest = divmod(int(shift[axis]), int(of[axis]))
    return k if rest == 0 and np.array_equal(shift, k * of) else None
