"""Steps of a file to the domain's; what is out of its range is located in the file."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, cast

from app.schemas.errors import Faults
from app.schemas.locate import at
from app.schemas.step_parts import StepContext
from app.schemas.steps import ENTRIES
from rigs.protocol.steps import Zero

if TYPE_CHECKING:
    from collections.abc import Sequence

    from app.schemas.base import Model
    from app.schemas.document import Document, Place
    from rigs.protocol.step import Step
    from rigs.protocol.steps import Repeat

_STAND_IN: Final[Step | Repeat] = Zero()


def to_steps(models: Sequence[Model], document: Document, place: Place, faults: Faults) -> tuple[Step | Repeat, ...]:
    """Return the steps at a place of a document, in order.

    Parameters
    ----------
    models : sequence of Model
        The file's content, each a mapping of the name of a step to its fields.
    document : Document
        Its text, for the spots of errors.
    place : tuple
        Place of the list.
    faults : Faults
        Takes what is out of its range; a step with such a value is replaced by another.
    """
    return tuple(
        faults.of(partial(_step, model, document, (*place, number), faults), _STAND_IN)
        for number, model in enumerate(models)
    )


def _step(model: Model, document: Document, place: Place, outer: Faults) -> Step | Repeat:
    """Return one step."""
    name = next(iter(type(model).model_fields))
    inner, faults = (*place, name), Faults()
    context = StepContext(faults=faults, steps=lambda models: to_steps(models, document, (*inner, "steps"), outer))
    with at(document, inner):
        step = faults.of(lambda: ENTRIES[name].make(getattr(model, name), context), None)
        faults.raise_any()
    return cast("Step | Repeat", step)
