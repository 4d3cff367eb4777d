"""Test of one specimen: specimen, rig, steps and log; SI floats throughout.

These dataclasses are also the Python builder, and this is the one module to import them from; `app.schemas` converts
protocol files to them and back. A value outside its range raises when it is made.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from knitlab_core.errors import SpecificationError, raise_all
from knitlab_core.knits import clamp_faces
from rigs.axes import SHEARS, spans
from rigs.protocol.bounds import require, require_all, require_count, require_frequency, require_label
from rigs.protocol.catalogue import arranged, clamped_axes, require_others, rig_named
from rigs.protocol.edges import OPEN
from rigs.protocol.extensometer import Extensometer
from rigs.protocol.specimen import SpecimenSpec
from rigs.protocol.step import Step
from rigs.protocol.steps import Cycle, Hold, Image, Preload, Ramp, Repeat, UntilRupture, Zero
from rigs.protocol.targets import Channel, Control, ForceRate, Rate, StepLog, StrainRate, Target, Until
from rigs.protocol.unrolled import axes_of, stroke_count
from rigs.protocol.waveform import Waveform

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigs.axes import Axis, Direction
    from rigs.protocol.catalogue import Drive, Fixture, Grips, Hook, Others, RigName

__all__ = [
    "Channel",
    "Control",
    "Cycle",
    "Extensometer",
    "ForceRate",
    "Hold",
    "Image",
    "LogSpec",
    "Preload",
    "Protocol",
    "Ramp",
    "Rate",
    "Repeat",
    "SpecimenSpec",
    "Step",
    "StepLog",
    "StrainRate",
    "Target",
    "Until",
    "UntilRupture",
    "Waveform",
    "Zero",
    "stroke_count",
]

MAX_STROKES = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class LogSpec:
    """Sampling of the instruments: rate, and rate near events [Hz], noise or none, and the noise's seed [1].

    Events are the jumps of the specimen: a fibre or a fused point that breaks, a snap. Of the cycles of a step `cycle`
    the first, the last and every n-th is kept. A step may say otherwise.

    On a rig of two machines also what the clock of the one shows when the frame's starts [s], and how much faster it
    runs [1]; None for what its data file says.
    """

    rate: float = 10.0
    events: float | None = None
    every_cycle: int = 1
    noise: bool = True
    seed: int = 0
    clock_offset: float | None = None
    clock_skew: float | None = None

    def __post_init__(self) -> None:
        offset, skew = self.clock_offset or 0.0, self.clock_skew or 0.0
        hours, least = "a time from -3600 s to 3600 s", "a number from -0.01 to 0.01"
        require_all(
            lambda: require_frequency("rate", self.rate),
            lambda: require_frequency("events", self.events),
            lambda: require_count("every_cycle", self.every_cycle),
            lambda: require(0 <= self.seed < 2**63, "seed", self.seed, "a whole number from 0 to 2^63 - 1"),
            lambda: require(abs(offset) <= 3600.0, "clock_offset", f"{offset:g} s", hours),
            lambda: require(abs(skew) <= 0.01, "clock_skew", f"{skew:g}", least),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """One test on one specimen.

    Parameters
    ----------
    specimen : SpecimenSpec
        What is mounted.
    speed_ref : {'pair', 'grip'}
        Whether a rate is that of the hook-to-hook length, or of one carriage that moves.
    others : {'hold', 'free', 'follow'}
        What the axes do that a step does not name: stay, give way so that they carry no force, or have the same
        strain. Beside the frame the specimen's sides are free.
    steps : tuple of Step or Repeat
        The steps, in order; none where they are given to a live rig one by one.
    log : LogSpec
        How the instruments sample.
    rig : RigName
        A rig of the catalogue.
    load_cell : float or None
        Capacity of the load cell that is fitted where a machine has several [N]; None for the one it comes with.
    mount : Axis or None
        Which axis of the specimen is along the frame; None on a rig that drives every axis it has.
    grips : {'hooks', 'clamps'} or Mapping
        What holds the specimen's edges: two hooks per boundary loop, or clamps that hold the edge stitches as a whole.
        A mapping says it by axis; an axis that it leaves out has hooks.
    hook : {'pin', 'wire'}
        How a hook holds its loop: 'pin' ties the nearest node of the yarn, 'wire' is a rigid wire through the loop.
    pole_friction : float or None
        Coefficient between hooks and their poles [1]; None for the machines' own.
    extensometer : Extensometer or None
        Pins in stitches whose distance is logged; None for none.
    name : str
        Name of the test; it names the files of its run.
    max_strain_increment : float
        Largest strain between two equilibria [1].
    """

    specimen: SpecimenSpec
    speed_ref: Literal["pair", "grip"] = "pair"
    others: Others
    steps: tuple[Step | Repeat, ...] = ()
    log: LogSpec = field(default_factory=LogSpec)
    rig: RigName = "biaxial-hook"
    mount: Axis | None = None
    load_cell: float | None = None
    grips: Grips | Mapping[Axis, Grips] = "hooks"
    hook: Hook = "pin"
    pole_friction: float | None = None
    extensometer: Extensometer | None = None
    name: str = "test"
    max_strain_increment: float = 0.0125

    def __post_init__(self) -> None:
        count, increment, friction = stroke_count(self.steps), self.max_strain_increment, self.pole_friction
        most = f"{MAX_STROKES} strokes or fewer"
        require_all(
            lambda: require(count <= MAX_STROKES, "steps", f"{count} strokes", most),
            lambda: require_label("name", self.name),
            lambda: require(1e-5 <= increment <= 0.1, "max_strain_increment", increment, "a strain from 1e-5 to 0.1"),
            self._require_rig,
            self._require_grips,
            self._require_cell,
            self._require_hooks,
            self._require_pins,
            lambda: require(
                friction is None or 0.0 <= friction <= 2.0, "pole_friction", friction, "a coefficient from 0 to 2"
            ),
        )

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Return the axes that are driven."""
        return rig_named(self.rig).axes if self.mount is None else (self.mount,)

    @property
    def drives(self) -> Mapping[Axis, Drive]:
        """Return the carriages of each axis in use, with what they hold the specimen by."""
        return arranged(self.rig, self.mount, self.grips)

    @property
    def fixtures(self) -> Mapping[Axis, Fixture]:
        """Return what holds the two faces of each axis that is driven."""
        return {axis: drive.fixture for axis, drive in self.drives.items()}

    @property
    def clamped(self) -> tuple[Direction, ...]:
        """Return the directions across whose faces clamps hold the edges."""
        return clamped_axes(self.fixtures)

    def _require_cell(self) -> None:
        """Raise unless a rig that drives a periodic cell has one, whose shear is its own to drive."""
        rig, spec = rig_named(self.rig), self.specimen
        edges = f"one that holds edges: {self.rig} drives a periodic cell alone (specimen: periodic: on)"
        require(spec.periodic or not rig.cells_only, "rig", self.rig, edges)
        undriven = [axis for axis in SHEARS if spans(axis) <= {*spec.axes} and axis not in self.axes]
        require(spec.shear == "held" or bool(undriven), "shear", spec.shear, f"held: {self.rig} drives the shear")

    def _require_grips(self) -> None:
        """Raise unless clamps, where the edges are to be held by them, can hold the knit."""
        if self.grips == "hooks":
            return
        if not isinstance(self.grips, str):
            strange = [axis for axis in self.grips if axis not in self.axes]
            require(not strange, "grips", ", ".join(strange), f"what is driven: {_both(self.axes)}")
        if not self.clamped:
            return
        plates = any(drive.fixture == "plates" for drive in rig_named(self.rig).drives.values())
        require(not plates, "grips", "clamps", f"hooks: {self.rig} holds a knit by the plates it is printed into")
        rubs = "none: clamps have no poles"
        edges = "hooks, which need not be said: a periodic cell has no edges"
        require(not self.specimen.periodic, "grips", "clamps", edges)
        require_all(
            lambda: require(
                self.hook == "pin", "hook", self.hook, "pin: clamps have no hooks, and those beside them are pins"
            ),
            lambda: require(
                self.pole_friction is None or len(self.clamped) < len(self.axes),
                "pole_friction",
                self.pole_friction,
                rubs,
            ),
            self._require_jaws,
        )

    def _require_jaws(self) -> None:
        """Raise unless the knit has edge stitches for clamps, and stitches between them."""
        spec = self.specimen
        clamp_faces(spec.fabric, spec.counts, [axis for axis in self.clamped if axis in spec.axes])

    def _require_pins(self) -> None:
        """Raise unless the knit has the stitches that the extensometer's pins are in."""
        if self.extensometer is not None:
            cell = "off: the strain of a periodic cell is the fabric's"
            require(not self.specimen.periodic, "extensometer", "on", cell)
            self.extensometer.check(self.specimen.counts)

    def _require_hooks(self) -> None:
        """Raise unless the hooks can hold the knit and its yarn."""
        planar = "P" not in self.specimen.axes
        require(self.hook == "pin" or planar, "hook", self.hook, "pin: wires hold the boundary loops of a planar knit")
        bundle = self.specimen.yarn is not None and self.specimen.yarn.model == "bundle"
        require(self.hook == "pin" or not bundle, "hook", self.hook, "pin: wires hold a yarn that is one rod")
        plates = any(drive.fixture == "plates" for drive in self.drives.values())
        printed = f"one without plates, into which {self.rig} takes the faces of a knit: a periodic cell has none"
        require(not (plates and self.specimen.periodic), "rig", self.rig, printed)
        chained = self.specimen.edges != OPEN
        require(self.hook == "pin" or not chained, "hook", self.hook, "pin: chained edges leave no room for wires")
        hooked = "nothing hangs on hooks in a periodic cell"
        require(self.hook == "pin" or not self.specimen.periodic, "hook", self.hook, f"pin: {hooked}")
        friction = self.pole_friction
        require(friction is None or not self.specimen.periodic, "pole_friction", friction, f"none: {hooked}")
        straight = self.specimen.rest_shape == "straight"
        require(self.hook == "pin" or not straight, "hook", self.hook, "pin: wires hold a yarn at rest as printed")

    def _require_rig(self) -> None:
        """Raise unless the rig of the catalogue can do what is asked for."""
        rig = rig_named(self.rig)
        clocks = len({drive.machine for drive in rig.drives.values()})
        driven = self.axes if rig.mounts_one else rig.axes
        clock = f"none: {self.rig} has one clock"
        require_all(
            self._require_faces,
            lambda: require_others(self.rig, self.others),
            lambda: require(
                self.log.clock_offset is None or clocks > 1, "log.clock_offset", self.log.clock_offset, clock
            ),
            lambda: require(self.log.clock_skew is None or clocks > 1, "log.clock_skew", self.log.clock_skew, clock),
            lambda: require_driven(self.steps, driven),
        )

    def _require_faces(self) -> None:
        """Raise unless the specimen has the faces that the rig pulls, and one of them is mounted where it must be."""
        rig = rig_named(self.rig)
        able = [axis for axis in rig.axes if spans(axis) <= {*self.specimen.axes}]
        if rig.mounts_one:
            require(
                self.mount in able, "mount", self.mount or "nothing", f"{' or '.join(able)}: the axis along the frame"
            )
        else:
            require(self.mount is None, "mount", self.mount, f"no mount: {self.rig} drives {_both(rig.axes)}")
            found = f"a knit with faces across {_both(self.specimen.axes)}"
            wanted = f"one with faces across {_both(rig.directions)}, which {self.rig} pulls"
            require(able == list(rig.axes), "knit", found, wanted)


def require_driven(steps: Sequence[Step | Repeat], axes: Sequence[Axis]) -> None:
    """Raise unless every step drives axes alone that the rig does."""
    faults = []
    for place, named in axes_of(steps):
        wrong = [axis for axis in named if axis not in axes]
        if wrong:
            faults.append(SpecificationError(place, ", ".join(wrong), f"what is driven: {_both(axes)}"))
    raise_all(faults)


def _both(axes: Sequence[Axis]) -> str:
    """Return the names of axes as a sentence has them.

    Examples
    --------
    >>> _both(["C"]), _both(["C", "W"]), _both(["C", "W", "P"])
    ('C', 'C and W', 'C, W and P')
    """
    *most, last = axes
    return f"{', '.join(most)} and {last}" if most else last
