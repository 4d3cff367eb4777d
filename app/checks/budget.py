"""Estimate before a test how much of its yarn it uses up, and how far a fibre is strained."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from rigs.analysis.material_limits import limits_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from knitlab_core.knits import Fabric, LoopBudget, Yarn
    from rigs.axes import Axis, Direction
    from rigs.protocol.specimen import SpecimenSpec
    from rigs.protocol.strokes import Stroke

#: Strands that lie side by side where a knit that is drawn is at its narrowest.
STRANDS: Final = 4

#: Factors of the estimate of fibre strain, fitted to solved tests; see `fibre_strain`.
COURSE, LOOPS, TURN, LOCKED = 0.6, 2.0, 1.2, 0.046

#: By how much that estimate may be off, either way, where it is 1 % or more.
BAND: Final = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """Arc-length budget: how far a protocol goes, and how far the yarn of a loop reaches.

    Attributes
    ----------
    largest, locking : float
        Largest strain that is planned, and the strain at which a loop has used up its yarn (estimate) [1].
    measure : str
        Which strain both are.
    """

    largest: float
    locking: float
    measure: str

    @property
    def share(self) -> float:
        """Return the largest strain as a share of the locking strain [1]."""
        return max(0.0, self.largest) / self.locking if self.locking > 0.0 else float("inf")


def loop_budgets(fabric: Fabric, yarn: Yarn | None) -> Mapping[Direction, LoopBudget]:
    """Return the budgets of a fabric's loops by the axis across the course along which they reach.

    The yarn is as thick at crossings as its material: loose fibres make room for each other.
    """
    if yarn is None:
        return fabric.budgets(fabric.fibre_radius)
    return fabric.budgets(yarn.contact_radius if yarn.fibres == 1 else replace(yarn, model="yarn").contact_radius)


def budget_of(spec: SpecimenSpec, strokes: Sequence[Stroke], lengths: Mapping[Axis, float]) -> Budget | None:
    """Return the budget of the loops that the strokes bring nearest to their locking; None where none is known.

    Parameters
    ----------
    spec : SpecimenSpec
        The specimen.
    strokes : sequence of Stroke
        Every move that is planned.
    lengths : Mapping
        Initial hook-to-hook distance of each driven axis [m]; sides of other axes are free.
    """
    if spec.relaxed:
        return None
    # An axis that searches a force is only known to start where it does.
    found = [
        budget
        for stroke in strokes
        for height, loop in loop_budgets(spec.fabric, spec.laid).items()
        if (budget := _budget(loop, height, _strains(stroke, lengths))) is not None
    ]
    return max(found, key=lambda budget: budget.share, default=None)


def _strains(stroke: Stroke, lengths: Mapping[Axis, float]) -> dict[Axis, float]:
    """Return the strains at the end of a stroke of the axes that are driven or held [1]."""
    end = stroke.start if stroke.searches else stroke.end
    return {axis: end[axis] / length for axis, length in lengths.items() if axis not in stroke.free}


def _budget(loop: LoopBudget, height: Axis, strain: Mapping[Axis, float]) -> Budget | None:
    """Return what strains ask of one loop, whose yarn is spent along the course once, along its height twice.

    With free sides the loop draws in until its strands lie side by side: the knit locks there at the latest.
    """
    biaxial, share = loop.locking, loop.share
    yarn, narrow = (1.0 + biaxial) * (1.0 + share), 2.0 * STRANDS * loop.fibre_radius
    if "C" in strain and height in strain:
        largest = (strain["C"] + share * strain[height]) / (1.0 + share)
        return Budget(largest=largest, locking=biaxial, measure="as equibiaxial strain")
    if height in strain:
        locking = (yarn - narrow) / share - 1.0
        return Budget(largest=strain[height], locking=locking, measure=f"along {height}, sides free")
    if "C" in strain:
        return Budget(largest=strain["C"], locking=yarn - narrow - 1.0, measure="along C, sides free")
    return None


def fibre_strain(spec: SpecimenSpec, strokes: Sequence[Stroke], lengths: Mapping[Axis, float]) -> float | None:
    """Estimate the largest strain at the surface of a fibre [1]; exact for a filament, else within a factor `BAND`.

    The largest of what four places of a knit reach, with the fibre radius r [loop widths] and the strain e at which the
    loops along a driven axis are spread:

    - ``0.6 r ε_C``: loop heads that are opened along the course;
    - ``2 r e²``: loops that are drawn into each other;
    - ``1.2 r e``: turn-arounds between two rows of which hooks hold both;
    - ``0.046 (e_CW / ε_lock)^3.5``: loops that have used up their yarn and bend around the strand they cross.

    Parameters
    ----------
    spec : SpecimenSpec
        The specimen.
    strokes : sequence of Stroke
        Every move that is planned.
    lengths : Mapping
        Initial hook-to-hook distance of each driven axis [m]; sides of other axes are free.

    Returns
    -------
    float or None
        None where a fabric has no known loops, where nothing moves, and for a yarn by measurement, of whose fibres
        nothing is known.

    References
    ----------
    docs/decisions/0024: how the factors were found, and how far they are off.
    """
    if spec.measured is not None:
        return None
    if spec.fabric.straight:
        return max((abs(stroke.end["C"]) / spec.loop_width for stroke in strokes if "C" in stroke.end), default=0.0)
    budgets = loop_budgets(spec.fabric, spec.laid)
    if not budgets or not strokes:
        return None
    radius = spec.fabric.fibre_radius if spec.laid is None else spec.laid.fibre_radius
    found = 0.0
    for strains in (_strains(stroke, lengths) for stroke in strokes):
        found = max(found, COURSE * radius * strains.get("C", 0.0))
        if len(budgets) > 1:
            # Of the two loops of a volumetric stitch one reaches along the axis: it does what both would.
            found = max(found, *(LOOPS * radius * (2.0 * max(0.0, strains.get(axis, 0.0))) ** 2 for axis in budgets))
        elif "W" in strains:
            found = max(found, _planar_strain(spec, budgets["W"], radius, strains, lengths["W"] / spec.loop_width))
    return found


def _planar_strain(
    spec: SpecimenSpec, loop: LoopBudget, radius: float, strains: Mapping[Axis, float], length: float
) -> float:
    """Return the largest strain of a fibre outside of the loop heads of a planar knit [1]; lengths in loop widths.

    Hooks hold the outermost loops at their far ends, so that only the spacings between rows are left to lengthen; a
    single row lengthens as half a spacing.
    """
    spacings = max(spec.rows - 1.0, 0.5) * 0.5 * loop.share
    spread = max(0.0, strains["W"]) * length / spacings
    largest = LOOPS * radius * spread**2
    if spec.rows <= 2:  # hooks hold both
        largest = max(largest, TURN * radius * spread)
    if "C" in strains:
        # Loops in the middle of the rows lend yarn to those at the edges: a third of what these lack.
        lent = (2.0 * spread + max(0.0, strains["W"])) / 3.0
        used = (max(0.0, strains["C"]) + loop.share * lent) / (1.0 + loop.share) / loop.locking
        largest = max(largest, LOCKED * radius / loop.fibre_radius * used**3.5)
    return largest


def budget_warnings(budget: Budget | None) -> list[str]:
    """Return a warning if the yarn would be used up."""
    if budget is None or budget.largest <= budget.locking:
        return []
    past = f"the protocol goes to {budget.largest:.1%} {budget.measure}, past the estimated locking strain of"
    return [f"arc-length budget: {past} {budget.locking:.1%}: the yarn itself must stretch and forces rise steeply"]


def limit_warnings(spec: SpecimenSpec, strain: float | None) -> list[str]:
    """Return a warning for each limit of the material that a fibre would pass by its estimated strain [1]."""
    if strain is None:
        return []
    return [
        f"material: {limit.text} would be passed: a fibre would be strained by {100 * strain:.2g} %{_band(spec)}, "
        f"limit {100 * limit.strain:.3g} %; {limit.consequence}"
        for limit in limits_of(spec)
        if strain > limit.strain
    ]


def fibre_line(spec: SpecimenSpec, strain: float | None) -> str:
    """Return warnings of limits that the estimated strain of a fibre passes; none for a material without limits."""
    limits = limits_of(spec)
    if strain is None or not limits:
        return ""
    band = 1.0 if spec.fabric.straight else BAND
    bears = [
        f"{100 * limit.strain:.3g} % at its {limit.text}" + ", which may be passed" * (limit.strain / band < strain)
        for limit in limits
    ]
    return f"fibre strain: goes to {100 * strain:.2g} %{_band(spec)}; the material bears {'; '.join(bears)}"


def _band(spec: SpecimenSpec) -> str:
    """Return how far to trust the estimate; that of a filament is exact."""
    return "" if spec.fabric.straight else f" (estimate, within a factor of {BAND:g})"
