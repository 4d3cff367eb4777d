"""What strands bring to the model of a specimen: stored energy, contact samples and their law, the floor of forces."""

from collections.abc import Callable

import numpy as np

from knitlab_core.arrays import BoolArray, FloatArray
from knitlab_core.contact.compression import Compression
from knitlab_core.contact.law import ContactLaw, law_as_printed, make_law, sample_weights
from knitlab_core.contact.neighbours import least_distance
from knitlab_core.contact.samples import Samples
from knitlab_core.errors import GeometryError
from knitlab_core.rods.rod import Rods
from knitlab_core.units import Scales

SLIP = 0.02
"""Elastic slip before sliding [r]: a contact approaches by as much, and the loop area is within 7 % of its limit."""

FLOOR_SHARE = 1.0 / 3.0
"""Floor of the forces by which residuals are judged, in those that bend the loops: EI times mean squared curvature.

In the default stitch 3e-3 E r^2. With a tolerance of 1e-4 a free node is then out of balance by at most 4e-5 N in a
print with loops of 8 mm, below the smallest digit of its load cells (1e-3 N on the stage, 1e-4 N on the frame).
"""

SMALLEST_FLOOR = 1e-4
"""The same for rods that are straight at rest [E r^2]."""

SAMPLE_SPACING = 2.0 / 9.0
"""Distance of contact samples along a strand [r]: ripple of at most 1 % when sliding."""

NARROW_SPACING = 1.0 / 9.0
"""The same where strands were printed nearer than contact's onset, and for `Compression.narrow`: as little ripple."""

MOST_OVERLAP = 0.25
"""Overlap [r] up to which that of printed strands is taken for the mesh's; 0.1 in the coarsest mesh of a thick yarn."""


def contact_of(
    spread: Callable[[float], Samples],
    q: FloatArray,
    scales: Scales,
    *,
    poisson_ratio: float,
    friction: float,
    compression: Compression | None,
    spacing: float,
    printed: bool,
) -> tuple[Samples, ContactLaw]:
    """Return the contact samples of strands, and their law: Hertz's, or that of a yarn that is compressed.

    Parameters
    ----------
    spread : callable
        Spreads samples at a spacing [r].
    q : (N, 4) array
        Positions [r] and angles as made.
    scales : Scales
        Units of the model.
    poisson_ratio, friction, compression, spacing, printed
        As for `make_model`.

    Raises
    ------
    GeometryError
        If printed strands overlap by more than a mesh may.
    """
    if compression is None:
        law = make_law(poisson_ratio, friction, slip=SLIP)
    else:
        law = compression.law(scales, friction, SLIP)
        spacing = min(spacing, NARROW_SPACING) if compression.narrow else spacing
    samples = spread(spacing)
    if printed and least_distance(q, samples, law) < law.reach:
        samples = spread(min(spacing, NARROW_SPACING))
        law = narrowed(law, least_distance(q, samples, law))
    return samples, law


def narrowed(law: ContactLaw, least: float) -> ContactLaw:
    """Return the contact law of strands whose samples are nearer than its reach as printed."""
    overlap = law.distance - least
    most = min(MOST_OVERLAP, 0.5 * law.overlap_limit)
    if overlap > most:
        found = f"strands that overlap by {overlap:.2g} contact radii where they cut the yarn's bends short"
        raise GeometryError("specimen.mesh", found, f"a finer mesh: at most {most:g} contact radii")
    return law_as_printed(law, least)


def force_floor(rods: Rods) -> float:
    """Return the smallest force by which residuals are judged [E r^2]."""
    inner = rods.is_inner
    bent = rods.bend_stiffness[inner] * (rods.rest_curvature[inner] ** 2).sum(axis=1) / rods.span[inner]
    return max(SMALLEST_FLOOR, FLOOR_SHARE * float(bent.sum()) / float(rods.span[inner].sum()))


def storing(rods: Rods, soft: BoolArray) -> Rods:
    """Return rods of which only the nodes (N,) that are soft store energy."""
    return rods._replace(
        stretch_stiffness=rods.stretch_stiffness * soft,
        bend_stiffness=rods.bend_stiffness * soft,
        twist_stiffness=rods.twist_stiffness * soft,
    )


def make_samples(rods: Rods, sizes: tuple[int, ...], edge: float, spacing: float) -> Samples:
    """Spread contact samples along rods of the given node counts and mean edge, as near as may be to a spacing [r]."""
    m = max(1, round(edge / spacing))
    return Samples(
        spans=np.flatnonzero(rods.is_inner),
        weights=sample_weights(m),
        length=rods.span / m,
        strand=np.repeat(np.arange(len(sizes)), sizes),
        arc=np.concatenate([[0.0], np.cumsum(rods.rest_length[:-1])]),
        image=np.zeros(len(rods.span), dtype=np.bool_),
    )
