"""Turn the models of a file into the domain's protocol, and a protocol into text."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML

from app.schemas import materials
from app.schemas.convert_specimen import to_specimen, written
from app.schemas.locate import at
from app.schemas.models import (
    SCHEMA,
    CycleStep,
    HoldStep,
    LogModel,
    PreloadStep,
    ProtocolModel,
    RampStep,
    RepeatStep,
    StepModel,
    ZeroStep,
)
from app.units import write
from knitlab_core.materials import Material
from rigs.protocol import Cycle, Hold, LogSpec, Preload, Protocol, Ramp, Repeat, Step, Target, Zero

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from app.schemas.document import Document, Place


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
    steps = _steps(model.steps, document, ("steps",))
    with at(document, ()):
        return Protocol(
            rig=model.rig,
            mount=model.mount,
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
        **({"materials": own} if own else {}),
        "specimen": written(spec, protocol.hook, protocol.pole_friction),
        "speed_ref": protocol.speed_ref,
        "others": protocol.others,
        "log": {
            "rate": write(protocol.log.rate, "frequency"),
            "noise": "on" if protocol.log.noise else "off",
            "seed": protocol.log.seed,
        },
        "max_strain_increment": protocol.max_strain_increment,
        "steps": [_written(step) for step in protocol.steps],
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
        return LogSpec(rate=model.rate, noise=model.noise, seed=model.seed)


def _steps(models: Sequence[StepModel], document: Document, place: Place) -> tuple[Step, ...]:
    """Return the steps in order."""
    return tuple(_step(model, document, (*place, number)) for number, model in enumerate(models))


def _step(model: StepModel, document: Document, place: Place) -> Step:
    """Return one step."""
    name = next(iter(type(model).model_fields))
    inner = (*place, name)
    with at(document, inner):
        match model:
            case ZeroStep(zero=body):
                return Zero(channels=tuple(body.channels))
            case PreloadStep(preload=body):
                return Preload(axes=tuple(body.axes), force=body.force, rate=body.rate, tag=body.tag)
            case RampStep(ramp=body):
                with at(document, (*inner, "to")):
                    to = _target(body.to.strain, body.to.displacement)
                return Ramp(axes=tuple(body.axes), to=to, rate=body.rate, tag=body.tag)
            case HoldStep(hold=body):
                return Hold(duration=body.duration, tag=body.tag)
            case CycleStep(cycle=body):
                axes = tuple(body.axes)
                return Cycle(axes=axes, lower=body.lower, upper=body.upper, rate=body.rate, n=body.n, tag=body.tag)
            case RepeatStep(repeat=body):
                return Repeat(n=body.n, steps=_steps(body.steps, document, (*inner, "steps")))


def _target(strain: float | None, displacement: float | None) -> Target:
    """Return the one target that is given."""
    if strain is not None:
        return Target(kind="strain", value=strain)
    return Target(kind="displacement", value=0.0 if displacement is None else displacement)


def _written(step: Step) -> dict[str, Any]:
    """Return one step as the data of a file."""
    match step:
        case Zero():
            return {"zero": {"channels": list(step.channels)}}
        case Hold():
            return {"hold": {"for": write(step.duration, "time"), **_tag(step.tag)}}
        case Repeat():
            return {"repeat": {"n": step.n, "steps": [_written(inner) for inner in step.steps]}}
        case _:
            pass
    drive: dict[str, Any] = {"axes": list(step.axes)}
    end = {"rate": write(step.rate, "speed"), **_tag(step.tag)}
    match step:
        case Preload():
            return {"preload": {**drive, "force": write(step.force, "force"), **end}}
        case Ramp():
            value = step.to.value if step.to.kind == "strain" else write(step.to.value, "length")
            return {"ramp": {**drive, "to": {step.to.kind: value}, **end}}
        case Cycle():
            return {"cycle": {**drive, "lower": step.lower, "upper": step.upper, "n": step.n, **end}}


def _tag(tag: str | None) -> dict[str, str]:
    """Return the field of a tag that is there."""
    return {} if tag is None else {"tag": tag}
