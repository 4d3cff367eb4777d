"""A virtual test lab for 3D-printed knits, from Python.

Build a protocol, check it without physics, run it, and read the equilibria of its record; SI units throughout:

>>> import knitlab as kl
>>> specimen = kl.SpecimenSpec(
...     knit="stockinette-default", rows=2, loops=2, loop_width=8e-3, material="RGD8530-DM", nodes_per_loop=32
... )
>>> stretch = kl.Ramp(axes=("C", "W"), to=kl.Target(kind="strain", value=0.05), rate=2e-4)
>>> test = kl.Protocol(specimen=specimen, others="hold", steps=(kl.Zero(), stretch))
>>> kl.check(test).warnings
[]
>>> result = kl.run(test, "runs/first", draw=None)
>>> result.outcome
'target'
>>> run = kl.open_run(result.folder)
>>> strain, force = run.strain("C"), run.force("C")
>>> f"{len(force)} equilibria, to a strain of {strain[-1]:.3f}"
'5 equilibria, to a strain of 0.050'

protocol   Protocol, SpecimenSpec, LogSpec; steps Zero, Preload, Ramp, Hold, Cycle, Waveform, Repeat,
           UntilRupture, Image; Target, Until, Bound, StrainRate, ForceRate, StepLog, Extensometer
specimen   Stitch, VolumetricStitch, Filament, Edges, Yarn, BondLaw, Material, MeasuredYarn, Value, RelaxationTerm;
           materials
files      load, loads, to_yaml, parse_quantity
tests      check, run, resume, sweep; their results Plan, Run (a RunResult with tables and plots), Sweep
records    show gives the Run of a folder, open_run its RunReader; figures
live       Rig, driven step by step; its Reading and Mark; devices_of gives RigDevices for Bluesky
analysis   analyse gives a Table, with Choices; read_measured gives a Measurement for each axis, with a FileMapping;
           compare gives a Comparison, with an Alignment; calibrate gives a Calibration;
           design gives a Design; report writes a page
service    Client
errors     KnitlabError and its children; RunStoppedError

Each name has a line and an example in ``docs/python.md``. This module defines nothing of its own. A name is imported
when it is first used, so that ``import knitlab`` loads neither NumPy nor any other library.
"""

from __future__ import annotations

import sys
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Final

from knitlab_entry import require_own

require_own()

# Sets the threads of BLAS, which show in the last bits of a run, before NumPy is imported.
import app  # noqa: E402, F401

if TYPE_CHECKING:
    from app.checks.dry_run import Plan
    from app.checks.dry_run import dry_run as check
    from app.client import Client
    from app.interactive.calibrations import Calibration, calibrate
    from app.interactive.comparisons import Comparison, compare
    from app.interactive.results import Run
    from app.interactive.running import resume, run, show
    from app.interactive.sweeps import Sweep, sweep
    from app.live.devices import RigDevices, devices_of
    from app.live.readings import Reading
    from app.live.recording import Mark
    from app.live.rig import LiveRig as Rig
    from app.records.analysis import analyse
    from app.records.analysis import read_file as read_measured
    from app.records.reader import RunReader
    from app.records.reader import read_run as open_run
    from app.records.results import figures_of as figures
    from app.runs.publishing import RunResult
    from app.runs.stopped import RunStoppedError
    from app.schemas import Loaded, load, loads, to_yaml
    from app.schemas.errors import ProtocolError
    from app.schemas.material_files import known_materials as materials
    from app.schemas.units import parse as parse_quantity
    from app.service.errors import ServiceError, UnreachableError
    from app.studies.design import Design, design
    from app.version import __version__
    from app.views.report.page import report
    from knitlab_core.contact.bond_law import BondLaw
    from knitlab_core.errors import (
        ConvergenceError,
        FormatError,
        GeometryError,
        KnitlabError,
        SolverError,
        SpecificationError,
        UnitError,
    )
    from knitlab_core.knits import Filament, Stitch, VolumetricStitch, Yarn
    from knitlab_core.materials import Material, MeasuredYarn, RelaxationTerm, Value
    from rigs.analysis.alignment import Alignment
    from rigs.analysis.choices import Choices
    from rigs.analysis.table import Table
    from rigs.measurement import Measurement
    from rigs.protocol.edges import Edges
    from rigs.protocol.protocol import (
        Cycle,
        Extensometer,
        ForceRate,
        Hold,
        Image,
        LogSpec,
        Preload,
        Protocol,
        Ramp,
        Repeat,
        SpecimenSpec,
        StepLog,
        StrainRate,
        Target,
        Until,
        UntilRupture,
        Waveform,
        Zero,
    )
    from rigs.protocol.targets import Bound
    from rigs.readers.mapping import FileMapping

__all__ = [
    "Alignment",
    "BondLaw",
    "Bound",
    "Calibration",
    "Choices",
    "Client",
    "Comparison",
    "ConvergenceError",
    "Cycle",
    "Design",
    "Edges",
    "Extensometer",
    "Filament",
    "FileMapping",
    "ForceRate",
    "FormatError",
    "GeometryError",
    "Hold",
    "Image",
    "KnitlabError",
    "Loaded",
    "LogSpec",
    "Mark",
    "Material",
    "MeasuredYarn",
    "Measurement",
    "Plan",
    "Preload",
    "Protocol",
    "ProtocolError",
    "Ramp",
    "Reading",
    "RelaxationTerm",
    "Repeat",
    "Rig",
    "RigDevices",
    "Run",
    "RunReader",
    "RunResult",
    "RunStoppedError",
    "ServiceError",
    "SolverError",
    "SpecificationError",
    "SpecimenSpec",
    "StepLog",
    "Stitch",
    "StrainRate",
    "Sweep",
    "Table",
    "Target",
    "UnitError",
    "UnreachableError",
    "Until",
    "UntilRupture",
    "Value",
    "VolumetricStitch",
    "Waveform",
    "Yarn",
    "Zero",
    "__version__",
    "analyse",
    "calibrate",
    "check",
    "compare",
    "design",
    "devices_of",
    "figures",
    "load",
    "loads",
    "materials",
    "open_run",
    "parse_quantity",
    "read_measured",
    "report",
    "resume",
    "run",
    "show",
    "sweep",
    "to_yaml",
]

# Where each name is imported from when it is first used; a test compares this with the imports for type checkers.
_HOMES: Final = {
    "Alignment": "rigs.analysis.alignment:Alignment",
    "BondLaw": "knitlab_core.contact.bond_law:BondLaw",
    "Bound": "rigs.protocol.targets:Bound",
    "Calibration": "app.interactive.calibrations:Calibration",
    "Choices": "rigs.analysis.choices:Choices",
    "Client": "app.client:Client",
    "Comparison": "app.interactive.comparisons:Comparison",
    "ConvergenceError": "knitlab_core.errors:ConvergenceError",
    "Cycle": "rigs.protocol.protocol:Cycle",
    "Design": "app.studies.design:Design",
    "Edges": "rigs.protocol.edges:Edges",
    "Extensometer": "rigs.protocol.protocol:Extensometer",
    "Filament": "knitlab_core.knits:Filament",
    "FileMapping": "rigs.readers.mapping:FileMapping",
    "ForceRate": "rigs.protocol.protocol:ForceRate",
    "FormatError": "knitlab_core.errors:FormatError",
    "GeometryError": "knitlab_core.errors:GeometryError",
    "Hold": "rigs.protocol.protocol:Hold",
    "Image": "rigs.protocol.protocol:Image",
    "KnitlabError": "knitlab_core.errors:KnitlabError",
    "Loaded": "app.schemas:Loaded",
    "LogSpec": "rigs.protocol.protocol:LogSpec",
    "Mark": "app.live.recording:Mark",
    "Material": "knitlab_core.materials:Material",
    "MeasuredYarn": "knitlab_core.materials:MeasuredYarn",
    "Measurement": "rigs.measurement:Measurement",
    "Plan": "app.checks.dry_run:Plan",
    "Preload": "rigs.protocol.protocol:Preload",
    "Protocol": "rigs.protocol.protocol:Protocol",
    "ProtocolError": "app.schemas.errors:ProtocolError",
    "Ramp": "rigs.protocol.protocol:Ramp",
    "Reading": "app.live.readings:Reading",
    "RelaxationTerm": "knitlab_core.materials:RelaxationTerm",
    "Repeat": "rigs.protocol.protocol:Repeat",
    "Rig": "app.live.rig:LiveRig",
    "RigDevices": "app.live.devices:RigDevices",
    "Run": "app.interactive.results:Run",
    "RunReader": "app.records.reader:RunReader",
    "RunResult": "app.runs.publishing:RunResult",
    "RunStoppedError": "app.runs.stopped:RunStoppedError",
    "ServiceError": "app.service.errors:ServiceError",
    "SolverError": "knitlab_core.errors:SolverError",
    "SpecificationError": "knitlab_core.errors:SpecificationError",
    "SpecimenSpec": "rigs.protocol.protocol:SpecimenSpec",
    "StepLog": "rigs.protocol.protocol:StepLog",
    "Stitch": "knitlab_core.knits:Stitch",
    "StrainRate": "rigs.protocol.protocol:StrainRate",
    "Sweep": "app.interactive.sweeps:Sweep",
    "Table": "rigs.analysis.table:Table",
    "Target": "rigs.protocol.protocol:Target",
    "UnitError": "knitlab_core.errors:UnitError",
    "UnreachableError": "app.service.errors:UnreachableError",
    "Until": "rigs.protocol.protocol:Until",
    "UntilRupture": "rigs.protocol.protocol:UntilRupture",
    "Value": "knitlab_core.materials:Value",
    "VolumetricStitch": "knitlab_core.knits:VolumetricStitch",
    "Waveform": "rigs.protocol.protocol:Waveform",
    "Yarn": "knitlab_core.knits:Yarn",
    "Zero": "rigs.protocol.protocol:Zero",
    "__version__": "app.version:__version__",
    "analyse": "app.records.analysis:analyse",
    "calibrate": "app.interactive.calibrations:calibrate",
    "check": "app.checks.dry_run:dry_run",
    "compare": "app.interactive.comparisons:compare",
    "design": "app.studies.design:design",
    "devices_of": "app.live.devices:devices_of",
    "figures": "app.records.results:figures_of",
    "load": "app.schemas:load",
    "loads": "app.schemas:loads",
    "materials": "app.schemas.material_files:known_materials",
    "open_run": "app.records.reader:read_run",
    "parse_quantity": "app.schemas.units:parse",
    "read_measured": "app.records.analysis:read_file",
    "report": "app.views.report.page:report",
    "resume": "app.interactive.running:resume",
    "run": "app.interactive.running:run",
    "show": "app.interactive.running:show",
    "sweep": "app.interactive.sweeps:sweep",
    "to_yaml": "app.schemas:to_yaml",
}


if not TYPE_CHECKING:  # or type checkers would take every name for one of the module's

    def __getattr__(name: str) -> object:
        """Import a name of `__all__` when it is first used."""
        if name not in _HOMES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}", name=name, obj=sys.modules[__name__])
        globals()[name] = found = resolve_name(_HOMES[name])
        return found


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
