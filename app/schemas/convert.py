"""Turn the models of a file into the domain's protocol, and a protocol into text."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from ruamel.yaml import YAML

from app.schemas import materials
from app.schemas.convert_specimen import to_specimen, written
from app.schemas.convert_steps import to_steps, written_step
from app.schemas.locate import at
from app.schemas.models import SCHEMA, LogModel, ProtocolModel
from app.units import write
from knitlab_core.materials import Material
from rigs.protocol import LogSpec, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from app.schemas.document import Document


def to_domain(model: ProtocolModel, document: Document, name: str, own: Mapping[str, Material]) -> Protocol:
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

    Raises
    ------
    ProtocolError
        For a value out of its range.
    """
    if isinstance(model.materials, dict):
        own = materials.to_domain(model.materials, document)
    specimen = to_specimen(model.specimen, document, own)
    log = _log(model.log, document)
    steps = to_steps(model.steps, document, ("steps",))
    with at(document, ()):
        return Protocol(
            rig=model.rig,
            mount=model.mount,
            load_cell=model.load_cell,
            hook=model.specimen.hook,
            pole_friction=model.specimen.pole_friction,
            specimen=specimen,
            speed_ref=model.speed_ref,
            others=model.others,
            log=log,
            steps=steps,
            name=name if model.name is None else model.name,
            max_strain_increment=model.max_strain_increment,
        )


def to_yaml(protocol: Protocol) -> str:
    """Return a protocol as the text of a file that reads back as the same protocol."""
    spec = protocol.specimen
    own = {spec.material.name: materials.written(spec.material)} if isinstance(spec.material, Material) else {}
    data = {
        "schema": SCHEMA,
        "name": protocol.name,
        "rig": protocol.rig,
        **({} if protocol.mount is None else {"mount": protocol.mount}),
        **({} if protocol.load_cell is None else {"load_cell": write(protocol.load_cell, "force")}),
        **({"materials": own} if own else {}),
        "specimen": written(spec, protocol.hook, protocol.pole_friction),
        "speed_ref": protocol.speed_ref,
        "others": protocol.others,
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
    text = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]  # a flag that ships as None
    yaml.dump(data, text)
    return text.getvalue()


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
