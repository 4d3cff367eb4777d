"""Turn the models of a file into the domain's protocol, and a protocol into text."""

from __future__ import annotations

import io
from contextlib import contextmanager
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML

from app.schemas.locate import locate
from app.schemas.models import (
    SCHEMA,
    CycleStep,
    HoldStep,
    LogModel,
    PreloadStep,
    ProtocolModel,
    RampStep,
    RepeatStep,
    SpecimenModel,
    StepModel,
    StitchModel,
    VolumetricStitchModel,
    ZeroStep,
)
from app.units import write
from knitlab_core.errors import SpecificationError
from knitlab_core.knits import Stitch, VolumetricStitch
from knitlab_core.materials import DEFAULT_FRICTION
from rigs.protocol import Cycle, Hold, LogSpec, Preload, Protocol, Ramp, Repeat, SpecimenSpec, Step, Target, Zero

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from app.schemas.document import Document, Place


def to_domain(model: ProtocolModel, document: Document, name: str) -> Protocol:
    """Return the protocol a model describes.

    Parameters
    ----------
    model : ProtocolModel
        The file's content.
    document : Document
        Its text, for the spots of errors.
    name : str
        Name of a protocol that gives itself none.

    Raises
    ------
    ProtocolError
        For a value out of its range.
    """
    specimen = _specimen(model.specimen, document)
    log = _log(model.log, document)
    steps = _steps(model.steps, document, ("steps",))
    with _at(document, ()):
        return Protocol(
            rig=model.rig,
            mount=model.mount,
            hook=model.specimen.hook,
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
    knit: object = spec.knit
    if isinstance(spec.knit, Stitch | VolumetricStitch):
        knit = {field.name: getattr(spec.knit, field.name) for field in fields(spec.knit)}
    data = {
        "schema": SCHEMA,
        "name": protocol.name,
        "rig": protocol.rig,
        **({} if protocol.mount is None else {"mount": protocol.mount}),
        "specimen": {
            "knit": knit,
            "loops": [spec.rows, spec.loops, *([spec.layers] if "P" in spec.axes else [])],
            "loop": write(spec.loop_width, "length"),
            "material": spec.material,
            "friction": spec.friction,
            "hook": protocol.hook,
            "nodes_per_loop": spec.nodes_per_loop,
            "rest_shape": spec.rest_shape,
        },
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


@contextmanager
def _at(document: Document, place: Place) -> Iterator[None]:
    """Give errors of the domain the spot of the mapping they come from."""
    try:
        yield
    except SpecificationError as error:
        raise locate(document, error, place) from error


def _specimen(model: SpecimenModel, document: Document) -> SpecimenSpec:
    """Return the specimen; inline stitch values may be lengths."""
    knit = model.knit if isinstance(model.knit, str) else _stitch(model.knit, model.loop, document)
    rows, loops, *layers = model.loops
    with _at(document, ("specimen",)):
        spec = SpecimenSpec(
            knit=knit,
            rows=rows,
            loops=loops,
            layers=layers[0] if layers else 1,
            loop_width=model.loop,
            material=model.material,
            friction=DEFAULT_FRICTION.value if model.friction is None else model.friction,
            nodes_per_loop=model.nodes_per_loop,
            rest_shape=model.rest_shape,
        )
        if bool(layers) != ("P" in spec.axes):
            allowed = "[rows, loops in a row, layers]" if not layers else "[rows, loops in a row] of a planar knit"
            raise SpecificationError("loops", model.loops, allowed)
    return spec


def _stitch(
    model: StitchModel | VolumetricStitchModel, loop_width: float, document: Document
) -> Stitch | VolumetricStitch:
    """Return a stitch in loop widths."""
    kind = Stitch if isinstance(model, StitchModel) else VolumetricStitch
    given = {name: getattr(model, name) for name in type(model).model_fields}
    with _at(document, ("specimen", "knit")):
        if model.curvature.metres:
            raise SpecificationError("curvature", "a length", "a pure number, such as 1.5")
        if loop_width <= 0.0:
            raise SpecificationError("loop", f"{loop_width:g} m", "a length above 0")
        return kind(**{name: one.value / loop_width if one.metres else one.value for name, one in given.items()})


def _log(model: LogModel, document: Document) -> LogSpec:
    """Return how the instruments sample."""
    with _at(document, ("log",)):
        return LogSpec(rate=model.rate, noise=model.noise, seed=model.seed)


def _steps(models: Sequence[StepModel], document: Document, place: Place) -> tuple[Step, ...]:
    """Return the steps in order."""
    return tuple(_step(model, document, (*place, number)) for number, model in enumerate(models))


def _step(model: StepModel, document: Document, place: Place) -> Step:
    """Return one step."""
    name = next(iter(type(model).model_fields))
    inner = (*place, name)
    with _at(document, inner):
        match model:
            case ZeroStep(zero=body):
                return Zero(channels=tuple(body.channels))
            case PreloadStep(preload=body):
                return Preload(axes=tuple(body.axes), force=body.force, rate=body.rate, tag=body.tag)
            case RampStep(ramp=body):
                with _at(document, (*inner, "to")):
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
