"""Conversion of the models of a file to the domain's protocol, and of a protocol to text."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, cast

from app.schemas import materials
from app.schemas.convert_specimen import to_specimen, written
from app.schemas.convert_steps import to_steps
from app.schemas.document import text_of
from app.schemas.errors import Faults
from app.schemas.locate import at
from app.schemas.models import SCHEMA, LogModel, ProtocolModel
from app.schemas.specimen import VolumetricStitchModel
from app.schemas.steps import written_step
from app.schemas.units import write
from knitlab_core.knits import fabric_named, fabric_names
from knitlab_core.materials import MATERIALS
from rigs.protocol.catalogue import CATALOGUE, require_others
from rigs.protocol.extensometer import WORDS, Extensometer
from rigs.protocol.protocol import LogSpec, Protocol
from rigs.protocol.specimen import SpecimenSpec

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Document
    from app.schemas.files_beside import NamedText
    from app.schemas.specimen import SpecimenModel
    from knitlab_core.materials import Substance

_ANY: Final = next(iter(MATERIALS.values()))
"""A material, where one has mistakes."""


def to_domain(
    model: ProtocolModel,
    document: Document,
    name: str,
    own: Mapping[str, Substance],
    centreline: NamedText | None = None,
) -> Protocol:
    """Return the protocol a model describes.

    Parameters
    ----------
    model : ProtocolModel
        The file's content.
    document : Document
        Its text, for the spots of errors.
    name : str
        Name of a protocol that gives itself none.
    own : Mapping
        The materials of the file that it names.
    centreline : NamedText, optional
        The centreline that it names.

    Raises
    ------
    ProtocolError
        For a value out of its range.
    """
    faults = Faults()
    if isinstance(model.materials, dict):
        brought = model.materials
        own = faults.of(lambda: materials.to_domain(brought, document), dict.fromkeys(brought, _ANY))
    specimen = faults.of(lambda: to_specimen(model.specimen, document, own, centreline), _stand_in(model.specimen))
    log = faults.of(lambda: _log(model.log, document), LogSpec())
    steps = to_steps(model.steps, document, ("steps",), faults)
    rig = CATALOGUE[model.rig]
    others, grips = model.others or rig.others[0], model.specimen.grips

    def whole() -> Protocol:
        with at(document, ()):
            return Protocol(
                rig=model.rig,
                mount=model.mount,
                load_cell=model.load_cell,
                grips=grips if isinstance(grips, str) else grips.by_axis,
                hook=model.specimen.hook,
                pole_friction=model.specimen.pole_friction,
                specimen=specimen,
                extensometer=_extensometer(model, specimen),
                speed_ref=model.speed_ref,
                others=others,
                log=log,
                steps=steps,
                name=name if model.name is None else model.name,
                max_strain_increment=model.max_strain_increment,
            )

    with at(document, ()):
        if model.others is None and len(rig.others) > 1:
            faults.of(lambda: require_others(model.rig, "nothing"), None)
        protocol = faults.of(whole, None)
        faults.raise_any()
    return cast("Protocol", protocol)


def _stand_in(model: SpecimenModel) -> SpecimenSpec:
    """Return a specimen with the faces of one that has mistakes, to look for more of them with."""
    named = fabric_named(model.knit) if isinstance(model.knit, str) and model.knit in fabric_names() else None
    volumetric = isinstance(model.knit, VolumetricStitchModel) or (named is not None and "P" in named.axes)
    knit = next(name for name in fabric_names() if ("P" in fabric_named(name).axes) == volumetric)
    # Clamps and pins are looked at with as many stitches as the file has, where a knit can have them.
    rows, loops, *layers = (min(max(count, 1), 20) if volumetric else min(max(count, 1), 100) for count in model.loops)
    depth = layers[0] if volumetric and layers else 1
    spec = SpecimenSpec(knit=knit, rows=rows, loops=loops, layers=depth, loop_width=1e-3, material=_ANY)
    return replace(spec, periodic=model.periodic and (not volumetric or depth % 2 == 0))


def to_data(protocol: Protocol) -> dict[str, Any]:
    """Return a protocol as the data of a file, defaults included."""
    spec = protocol.specimen
    own = {} if isinstance(spec.material, str) else {spec.material.name: materials.written(spec.material)}
    return {
        "schema": SCHEMA,
        "name": protocol.name,
        "rig": protocol.rig,
        **({} if protocol.mount is None else {"mount": protocol.mount}),
        **({} if protocol.load_cell is None else {"load_cell": write(protocol.load_cell, "force")}),
        **({"materials": own} if own else {}),
        "specimen": written(spec, protocol),
        "speed_ref": protocol.speed_ref,
        "others": protocol.others,
        **({} if protocol.extensometer is None else {"extensometer": _written_pins(protocol.extensometer)}),
        "log": {
            "rate": write(protocol.log.rate, "frequency"),
            **({} if protocol.log.events is None else {"events": write(protocol.log.events, "frequency")}),
            **({} if protocol.log.every_cycle == 1 else {"every_cycle": protocol.log.every_cycle}),
            "noise": "on" if protocol.log.noise else "off",
            "seed": protocol.log.seed,
            **({} if protocol.log.clock_offset is None else {"clock_offset": write(protocol.log.clock_offset, "time")}),
            **({} if protocol.log.clock_skew is None else {"clock_skew": protocol.log.clock_skew}),
        },
        "max_strain_increment": protocol.max_strain_increment,
        "steps": [written_step(step) for step in protocol.steps],
    }


def _written_pins(extensometer: Extensometer) -> dict[str, list[int]]:
    """Return an extensometer as the data of a file."""
    return {WORDS[axis]: list(pair) for axis, pair in extensometer.pairs.items()}


def to_yaml(protocol: Protocol) -> str:
    """Return a protocol as the text of a file that reads back as the same protocol."""
    return text_of(to_data(protocol))


def _extensometer(model: ProtocolModel, specimen: SpecimenSpec) -> Extensometer | None:
    """Return the extensometer of a test; where its pins are not said they are about half of the knit apart."""
    said = model.extensometer
    if isinstance(said, bool):
        return Extensometer.inner_half(specimen.counts) if said else None
    pairs = {name: getattr(said, name) for name in WORDS.values()}
    return Extensometer(**{name: None if pair is None else (pair[0], pair[1]) for name, pair in pairs.items()})


def _log(model: LogModel, document: Document) -> LogSpec:
    """Return how the instruments sample."""
    with at(document, ("log",)):
        return LogSpec(
            rate=model.rate,
            events=model.events,
            every_cycle=model.every_cycle,
            noise=model.noise,
            seed=model.seed,
            clock_offset=model.clock_offset,
            clock_skew=model.clock_skew,
        )
