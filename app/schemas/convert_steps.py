"""Turn the steps of a file into the domain's, and back into the data of a file."""

from __future__ import annotations

from dataclasses import fields
from functools import partial
from typing import TYPE_CHECKING, Any, Final, cast

from app.schemas.errors import Faults
from app.schemas.locate import at
from app.schemas.steps import (
    CycleLogModel,
    CycleModel,
    HoldStep,
    ImageStep,
    PreloadModel,
    RampModel,
    RepeatStep,
    StepModel,
    UntilRuptureModel,
    ZeroStep,
)
from app.schemas.units import parse, write
from knitlab_core.errors import SpecificationError, UnitError
from rigs.protocol.step import step_name
from rigs.protocol.steps import Cycle, Hold, Image, Preload, Ramp, Repeat, UntilRupture, Zero
from rigs.protocol.targets import ForceRate, StepLog, StrainRate, Target, Until

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from app.schemas.document import Document, Place
    from app.schemas.steps import HoldModel, StepLogModel, TargetModel, UntilModel
    from app.schemas.units import Dimension
    from rigs.protocol.step import Step
    from rigs.protocol.targets import Control, Rate

_MEASURES: Final[Mapping[Control, Dimension]] = {"strain": "strain", "displacement": "length", "force": "force"}


def to_steps(models: Sequence[StepModel], document: Document, place: Place, faults: Faults) -> tuple[Step, ...]:
    """Return the steps that stand at a place of a document, in order.

    Parameters
    ----------
    models : sequence of StepModel
        The file's content.
    document : Document
        Its text, for the spots of errors.
    place : tuple
        Where the list stands.
    faults : Faults
        Takes what is out of its range; another step stands in for one with such a value.
    """
    stand_in: Step = Zero()
    return tuple(
        faults.of(partial(_step, model, document, (*place, number), faults), stand_in)
        for number, model in enumerate(models)
    )


def _step(model: StepModel, document: Document, place: Place, faults: Faults) -> Step:
    """Return one step."""
    name = next(iter(type(model).model_fields))
    inner = (*place, name)
    with at(document, inner):
        match model:
            case ZeroStep(zero=body):
                return Zero(channels=tuple(body.channels))
            case RepeatStep(repeat=body):
                return Repeat(n=body.n, steps=to_steps(body.steps, document, (*inner, "steps"), faults))
            case ImageStep(image=body):
                return Image(every=body.every, tag=body.tag)
            case HoldStep(hold=held):
                return _hold(held, document, inner)
            case _:
                return _drive(getattr(model, name), document, inner)


def _hold(body: HoldModel, document: Document, place: Place) -> Hold:
    """Return a step that stands still or keeps forces."""
    faults, axes = Faults(), tuple(body.axes or ())
    until = faults.of(lambda: _until(body.until, document, place), None)
    log = faults.of(lambda: _log(body.log, document, place), None)

    def make() -> Hold:
        return Hold(duration=body.duration, axes=axes, control=body.control, until=until, log=log, tag=body.tag)

    with at(document, place):
        hold = faults.of(make, None)
        faults.raise_any()
    return cast("Hold", hold)


def _drive(
    body: PreloadModel | RampModel | CycleModel | UntilRuptureModel, document: Document, place: Place
) -> Preload | Ramp | Cycle | UntilRupture:
    """Return a step that drives axes."""
    faults = Faults()
    common: dict[str, Any] = {
        "axes": tuple(body.axes),
        "rate": body.rate,
        "control": body.control,
        "until": faults.of(lambda: _until(body.until, document, place), None),
        "log": faults.of(lambda: _log(body.log, document, place), None),
        "tag": body.tag,
    }
    make: Callable[[], Preload | Ramp | Cycle | UntilRupture]
    match body:
        case PreloadModel():
            make = partial(Preload, force=body.force, **common)
        case RampModel():
            make = partial(Ramp, to=faults.of(partial(_target, body.to, document, place), _anywhere(body.to)), **common)
        case CycleModel():
            lower, upper = (faults.of(partial(_level, body, name), None) for name in ("lower", "upper"))
            # Ends that are fine stand in for those that are not.
            ends = (0.0, 1.0) if lower is None or upper is None else (lower, upper)
            make = partial(Cycle, lower=ends[0], upper=ends[1], n=body.n, **common)
        case UntilRuptureModel(to=ceiling):
            to = None
            if ceiling is not None:
                to = faults.of(partial(_target, ceiling, document, place), _anywhere(ceiling))
            make = partial(UntilRupture, drop=body.drop, to=to, **common)
    step = faults.of(make, None)
    faults.raise_any()
    return cast("Preload | Ramp | Cycle | UntilRupture", step)


def _anywhere(model: TargetModel) -> Target:
    """Return a target of the kind that is given, to stand in for one out of its range."""
    kinds: tuple[Control, ...] = ("strain", "displacement", "force")
    return Target(kind=next(kind for kind in kinds if getattr(model, kind) is not None), value=0.0)


def _target(model: TargetModel, document: Document, place: Place) -> Target:
    """Return the one target that is given."""
    with at(document, (*place, "to")):
        if model.strain is not None:
            return Target(kind="strain", value=model.strain)
        if model.displacement is not None:
            return Target(kind="displacement", value=model.displacement)
        return Target(kind="force", value=0.0 if model.force is None else model.force)


def _until(model: UntilModel | None, document: Document, place: Place) -> Until | None:
    """Return what ends a step early."""
    if model is None:
        return None
    with at(document, place):
        return Until(**{one.name: getattr(model, one.name) for one in fields(Until)})


def _log(model: StepLogModel | None, document: Document, place: Place) -> StepLog | None:
    """Return how a step is logged."""
    if model is None:
        return None
    with at(document, place):
        every = model.every_cycle if isinstance(model, CycleLogModel) else None
        return StepLog(rate=model.rate, events=model.events, every_cycle=every)


def _level(body: CycleModel, name: str) -> float:
    """Return an end of a cycle, in what its `control` measures."""
    value = getattr(body, name)
    try:
        return parse(value, _MEASURES[body.control], name)
    except UnitError as error:
        expected = f"{error.expected}, for {body.control} is controlled"
        raise SpecificationError(name, repr(value), expected) from error


def written_step(step: Step) -> dict[str, Any]:
    """Return one step as the data of a file."""
    match step:
        case Zero():
            body: dict[str, Any] = {"channels": list(step.channels)}
        case Repeat():
            body = {"n": step.n, "steps": [written_step(inner) for inner in step.steps]}
        case Image():
            every = step.every if step.every is None or step.every == "off" else _time(step.every)
            body = _given(every=every, tag=step.tag)
        case _:
            body = {
                **_given(axes=list(step.axes) or None, **_own(step)),
                **_given(
                    control=step.control, until=_written_until(step.until), log=_written_log(step.log), tag=step.tag
                ),
            }
    return {step_name(step): body}


def _own(step: Preload | Ramp | Hold | Cycle | UntilRupture) -> dict[str, Any]:
    """Return the fields that a step has for itself."""
    match step:
        case Hold():
            return {"for": _time(step.duration)}
        case Preload():
            return {"force": write(step.force, "force"), "rate": _rate(step.rate)}
        case Ramp():
            return {"to": _written_target(step.to), "rate": _rate(step.rate)}
        case UntilRupture():
            return {"to": _written_target(step.to), "rate": _rate(step.rate), "drop": step.drop}
        case Cycle():
            ends = {name: _written(step.control, getattr(step, name)) for name in ("lower", "upper")}
            return {**ends, "rate": _rate(step.rate), "n": step.n}


def _given(**values: object) -> dict[str, Any]:
    """Return the fields that have a value."""
    return {name: value for name, value in values.items() if value is not None}


def _written(kind: Control, value: float) -> float | str:
    """Return a level as a file writes it."""
    return value if kind == "strain" else write(value, _MEASURES[kind])


def _written_target(to: Target | None) -> dict[str, float | str] | None:
    """Return a target as the data of a file."""
    return None if to is None else {to.kind: _written(to.kind, to.value)}


def _written_until(until: Until | None) -> dict[str, Any] | None:
    """Return what ends a step as the data of a file."""
    if until is None:
        return None
    return _given(
        force=_written_bound("force", until),
        strain=_written_bound("strain", until),
        displacement=_written_bound("displacement", until),
        time=None if until.time is None else _time(until.time),
        drop=until.drop,
    )


def _written_log(log: StepLog | None) -> dict[str, Any] | None:
    """Return how a step is logged as the data of a file."""
    if log is None:
        return None
    return _given(
        rate=None if log.rate is None else write(log.rate, "frequency"),
        events=None if log.events is None else write(log.events, "frequency"),
        every_cycle=log.every_cycle,
    )


def _written_bound(kind: Control, until: Until) -> float | str | None:
    """Return a level that ends a step, with its side if one is said."""
    level, side = until.level(kind), until.side(kind)
    if level is None or side is None:
        return None if level is None else _written(kind, level)
    return f"{side} {level!r}" if kind == "strain" else f"{side} {_written(kind, level)}"


def _rate(rate: Rate) -> str:
    """Return a rate as a file writes it."""
    match rate:
        case StrainRate():
            return write(rate.value, "strain rate")
        case ForceRate():
            return write(rate.value, "force rate")
        case _:
            return write(rate, "speed")


def _time(time: float) -> str:
    return write(time, "time")
