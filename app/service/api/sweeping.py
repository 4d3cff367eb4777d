"""Turn the body of a sweep into jobs: a list of protocols, or a protocol over values of its parameters."""

from __future__ import annotations

from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

from app.check import dry_run
from app.schemas import loads_data
from app.schemas.document import parse_text
from app.service.api.bodies import parse_json, submitted, written
from app.service.api.bounds import check_plan, check_sweep
from app.service.api.problems import ProblemError, beyond, refused
from app.service.jobs import JobSpec
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from app.schemas import Loaded
    from app.service.api.bodies import Submission
    from app.service.api.bounds import Bounds

_LONGEST_NAME = 64


def swept(data: Any, bounds: Bounds) -> list[JobSpec]:  # noqa: ANN401 (whatever JSON holds)
    """Return the jobs of a sweep.

    Parameters
    ----------
    data : dict
        ``{protocols: [...]}``, or ``{protocol, values: {name: [...]}}`` with what else belongs to a protocol; one that
        has a `sweep:` of its own needs no values.
    bounds : Bounds
        How many there may be, and how large.

    Raises
    ------
    ProblemError
        For the first thing that is wrong with any of them; its pointer starts at the body.
    """
    if isinstance(data, dict) and "protocols" in data:
        found = list(_listed(data, bounds))
    elif isinstance(data, dict) and "protocol" in data:
        found = list(_crossed(data, bounds))
    else:
        raise _wrong(
            "",
            "a body without jobs",
            "{protocols: [...]} or {protocol: ..., values: {name: [...]}}; a protocol with sweep: needs no values",
        )
    check_sweep([loaded.protocol for loaded, _ in found], bounds)
    for loaded, _ in found:
        check_plan(dry_run(loaded), bounds)
    return [
        JobSpec(name=loaded.protocol.name, protocol=loaded.text, materials=materials) for loaded, materials in found
    ]


def _listed(data: Mapping[str, Any], bounds: Bounds) -> Iterator[tuple[Loaded, str]]:
    """Yield the protocols of a list."""
    protocols = data["protocols"]
    if len(data) > 1 or not isinstance(protocols, list) or not protocols:
        raise _wrong("/protocols", "something else", "a list of one protocol or more, and nothing beside it")
    _check_count(len(protocols), bounds, "/protocols")
    for number, one in enumerate(protocols):
        sent = submitted(one, "test")
        try:
            yield sent.load(), sent.materials
        except ProblemError as error:
            raise _within(error, f"/protocols/{number}") from error


def _crossed(data: Mapping[str, Any], bounds: Bounds) -> Iterator[tuple[Loaded, str]]:
    """Yield a protocol with every combination of some values of its parameters."""
    sent = submitted({key: value for key, value in data.items() if key != "values"}, "test")
    base = _data_of(sent)
    own = base.pop("sweep", None)
    values = _checked_values(data.get("values", own))
    count = prod(len(one) for one in values.values())
    _check_count(count, bounds, "/values")
    params = base.get("params", {})
    for name in values:
        if not isinstance(params, dict) or name not in params:
            raise _wrong(f"/values/{name}", "no such parameter", "a name under `params` of the protocol")
    name = str(base.get("name", sent.name))
    for number, chosen in enumerate(product(*values.values()), start=1):
        tail = f"-{number:0{len(str(count))}}"
        one = {
            **base,
            "name": f"{name[: _LONGEST_NAME - len(tail)]}{tail}",
            "params": {**params, **dict(zip(values, chosen, strict=True))},
        }
        try:
            yield loads_data(one, written(one), name=name, materials=sent.materials), sent.materials
        except SpecificationError as error:
            raise refused(error, lined=False) from error


def _data_of(sent: Submission) -> dict[str, Any]:
    """Return the data of a protocol, once its text has been read."""
    try:
        data: Any = parse_text(sent.text, "protocol").data
    except SpecificationError as error:
        raise refused(error, lined=sent.lined) from error
    if not isinstance(data, dict):
        raise _wrong("/protocol", "something else", "a protocol")
    # What YAML may hold and JSON not, such as a number too large, is refused here.
    return dict(parse_json(written(data)))


def _checked_values(values: Any) -> dict[str, list[Any]]:  # noqa: ANN401 (whatever JSON holds)
    """Return the values of a sweep, each a list of plain ones."""
    if not isinstance(values, dict) or not values:
        raise _wrong("/values", "something else", "a mapping of names to lists")
    for name, listed in values.items():
        plain = isinstance(listed, list) and all(isinstance(one, str | int | float) for one in listed)
        if not plain or not listed:
            raise _wrong(f"/values/{name}", "something else", "a list of one number or text or more")
    return values


def _check_count(count: int, bounds: Bounds, pointer: str) -> None:
    """Refuse a sweep of too many jobs."""
    if count > bounds.sweep:
        raise beyond("jobs of the sweep", count, bounds.sweep, pointer=pointer)


def _wrong(pointer: str, found: str, allowed: str) -> ProblemError:
    """Return the refusal of a part of the body."""
    detail = f"{pointer or 'sweep'}: found {found}, allowed {allowed}"
    return ProblemError("invalid-request", detail, errors=[{"detail": detail, "pointer": pointer}])


def _within(error: ProblemError, pointer: str) -> ProblemError:
    """Return a refusal with its pointers below another."""
    errors = [{**one, "pointer": f"{pointer}{one.get('pointer', '')}"} for one in error.errors]
    return ProblemError(error.kind, f"{pointer}: {error.detail}", errors=errors)
