"""Jobs from the body of a sweep, and their plan: a list of protocols, or a protocol over values of its parameters."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import islice
from math import prod
from typing import TYPE_CHECKING, Any, Final

from app.checks.dry_run import dry_run, plan_log
from app.schemas import ProtocolError, loads_document
from app.schemas.document import parse_text
from app.schemas.errors import shown
from app.schemas.sweep import combinations
from app.service.api.bodies import PATH, field_of_file, parse_json, submitted, written
from app.service.api.bounds import check_protocol, check_rows, check_sweep, check_texts
from app.service.api.problems import ProblemError, beyond, refused
from app.service.jobs import JobSpec
from app.views.plan_tables import plan_data
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from app.checks.dry_run import LogPlan
    from app.schemas import Loaded
    from app.schemas.document import Document
    from app.schemas.errors import Spot
    from app.schemas.sweep import Scalar
    from app.service.api.bodies import Submission
    from app.service.api.bounds import Bounds

_LONGEST_NAME = 64

MOST_PLANNED: Final = 100
"""Jobs of a sweep that its plan looks at; what more there are is estimated from these."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Place:
    """Place of a protocol in the body of a sweep, for error messages.

    Attributes
    ----------
    within : str
        JSON pointer of what holds it and its materials.
    protocol : str
        JSON pointer of the protocol itself.
    which : str
        Which of many it is, for people.
    lined : bool
        Whether lines and columns of its text are the user's own.
    """

    within: str
    protocol: str
    which: str
    lined: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wanted:
    """A protocol of a sweep, its materials, its place in the body, and the values of its parameters."""

    loaded: Loaded
    materials: str
    place: _Place
    point: Mapping[str, Scalar] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asked:
    """How many jobs a sweep has, and its protocols, made one by one."""

    count: int
    wanted: Iterator[_Wanted]


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
    found = list(_asked(data, bounds).wanted)
    _checked(found, bounds)
    return [
        JobSpec(name=one.loaded.protocol.name, protocol=one.loaded.text, materials=one.materials, point=dict(one.point))
        for one in found
    ]


def planned_sweep(data: Any, bounds: Bounds) -> dict[str, Any]:  # noqa: ANN401 (whatever JSON holds)
    """Return what a sweep would do as plain data, SI units; the arguments and errors are those of `swept`.

    Of more than `MOST_PLANNED` jobs the first are looked at, and the totals of all are estimated from these.
    """
    asked = _asked(data, bounds)
    found = list(islice(asked.wanted, MOST_PLANNED))
    logs = _checked(found, bounds)
    with _placed(found[0].place):
        first = plan_data(dry_run(found[0].loaded))
    whole = asked.count / len(found)
    return {
        "count": asked.count,
        "looked_at": len(found),
        "duration_s": whole * sum(log.duration for log in logs),
        "rows": round(whole * sum(log.rows for log in logs)),
        "log_bytes": whole * sum(log.size for log in logs),
        "points": [
            {
                "name": one.loaded.protocol.name,
                "values": dict(one.point),
                "duration_s": log.duration,
                "rows": log.rows,
                "log_bytes": log.size,
            }
            for one, log in zip(found, logs, strict=True)
        ],
        "first": first,
    }


def _asked(data: Any, bounds: Bounds) -> _Asked:  # noqa: ANN401 (whatever JSON holds)
    """Return the jobs that a body asks for."""
    if isinstance(data, dict) and "protocols" in data:
        return _listed(data, bounds)
    if isinstance(data, dict) and "protocol" in data:
        return _crossed(data, bounds)
    raise _wrong(
        "",
        "a body without jobs",
        "{protocols: [...]} or {protocol: ..., values: {name: [...]}}; a protocol with sweep: needs no values",
    )


def _checked(found: Sequence[_Wanted], bounds: Bounds) -> list[LogPlan]:
    """Return how long the test of each protocol is, after a check that all are within the bounds."""
    for one in found:
        with _placed(one.place):
            check_protocol(one.loaded.protocol, bounds)
    check_sweep([one.loaded.protocol for one in found], bounds)
    logs = []
    for one in found:
        with _placed(one.place):
            logs.append(plan_log(one.loaded))
            check_rows(logs[-1].rows, bounds)
    return logs


def _listed(data: Mapping[str, Any], bounds: Bounds) -> _Asked:
    """Return the protocols of a list."""
    protocols = data["protocols"]
    if len(data) > 1 or not isinstance(protocols, list) or not protocols:
        raise _wrong("/protocols", "something else", "a list of one protocol or more, and nothing beside it")
    _check_count(len(protocols), bounds, "/protocols")
    return _Asked(count=len(protocols), wanted=_each_of(protocols, bounds))


def _each_of(protocols: Sequence[Any], bounds: Bounds) -> Iterator[_Wanted]:
    """Yield the protocols of a list."""
    size = 0
    for number, one in enumerate(protocols):
        within = f"/protocols/{number}"
        with _placed(_Place(within=within, protocol=within, which=within)):
            sent = submitted(one, "test")
        size += sent.size
        check_texts(size, bounds, "/protocols")
        enveloped = isinstance(one, dict) and "protocol" in one
        place = _Place(
            within=within, protocol=f"{within}/protocol" if enveloped else within, which=within, lined=sent.lined
        )
        with _placed(place):
            document = parse_text(sent.text, PATH)
            loaded = loads_document(document, name=sent.name, materials=sent.materials, files=sent.files)
        yield _Wanted(loaded=loaded, materials=loaded.beside(sent.materials), place=place)


def _crossed(data: Mapping[str, Any], bounds: Bounds) -> _Asked:
    """Return a protocol with every combination of the values of its parameters, or at every point of its design."""
    sent = submitted({key: value for key, value in data.items() if key != "values"}, "test")
    whole = _Place(within="", protocol="/protocol", which="", lined=sent.lined)
    with _placed(whole):
        document = parse_text(sent.text, PATH)
    base = _data_of(document)
    own, design = base.pop("sweep", None), base.pop("sample", None)
    if "values" not in data and design is not None:
        with _placed(whole):
            drawn = loads_document(document, name=sent.name, materials=sent.materials, files=sent.files).points
        pointer, count, points = "/protocol/sample", len(drawn), iter([one.values for one in drawn])
    else:
        pointer = "/values" if "values" in data else "/protocol/sweep"
        text = document if sent.lined and "values" not in data else None
        values = _checked_values(data.get("values", own), base.get("params"), pointer, text)
        count, points = prod(len(one) for one in values.values()), combinations(values)
    _check_count(count, bounds, pointer)
    check_texts(count * sent.size, bounds, pointer)
    made = _at_points(document, base, sent, points, count, whole)
    return _Asked(count=count, wanted=made)


def _at_points(
    document: Document,
    base: Mapping[str, Any],
    sent: Submission,
    points: Iterator[Mapping[str, Scalar]],
    count: int,
    whole: _Place,
) -> Iterator[_Wanted]:
    """Yield a protocol with the values of each point, named by the number of the point."""
    name, params = str(base.get("name", sent.name)), base.get("params", {})
    for number, point in enumerate(points, start=1):
        tail = f"-{number:0{len(str(count))}}"
        one = {**base, "name": f"{name[: _LONGEST_NAME - len(tail)]}{tail}", "params": {**params, **point}}
        place = replace(whole, which=", ".join(f"{key} = {shown(value)}" for key, value in point.items()))
        with _placed(place):
            # Places of the text that was sent, values of this job.
            made = replace(document, text=written(one), data=one)
            loaded = loads_document(made, name=name, materials=sent.materials, files=sent.files)
        yield _Wanted(loaded=loaded, materials=loaded.beside(sent.materials), place=place, point=point)


def _data_of(document: Document) -> dict[str, Any]:
    """Return the data of a protocol's text."""
    if not isinstance(document.data, dict):
        raise _wrong("/protocol", "something else", "a protocol")
    # What YAML may hold and JSON not, such as a number too large, is refused here.
    return dict(parse_json(written(document.data)))


def _checked_values(
    values: Any,  # noqa: ANN401 (whatever JSON holds)
    params: Any,  # noqa: ANN401
    pointer: str,
    document: Document | None,
) -> dict[str, list[Any]]:
    """Return the values of a sweep, each a list of plain values of a parameter; those of a `document` have a line."""

    def wrong(name: str, found: str, allowed: str) -> ProblemError:
        spot = None if document is None else document.spot(("sweep", *filter(None, [name])), key=True)
        return _wrong(f"{pointer}/{name}".removesuffix("/"), found, allowed, spot)

    if not isinstance(values, dict) or not values:
        raise wrong("", "something else", "a mapping of names to lists")
    for name, listed in values.items():
        plain = isinstance(listed, list) and all(isinstance(one, str | int | float) for one in listed)
        if not plain or not listed:
            raise wrong(name, "something else", "a list of one number or text or more")
    for name in values:
        if not isinstance(params, dict) or name not in params:
            raise wrong(name, "no such parameter", "a name under `params` of the protocol")
    return values


def _check_count(count: int, bounds: Bounds, pointer: str) -> None:
    """Refuse a sweep of too many jobs."""
    if count > bounds.sweep:
        raise beyond("jobs of the sweep", count, bounds.sweep, pointer=pointer)


def _wrong(pointer: str, found: str, allowed: str, spot: Spot | None = None) -> ProblemError:
    """Return the error of a part of the body, at a spot of the protocol's text where there is one."""
    detail = f"{pointer or 'sweep'}: found {found}, allowed {allowed}"
    place = {"detail": detail, "pointer": pointer}
    line = {} if spot is None else {"line": spot.line, "column": spot.column}
    return ProblemError("invalid-request", detail, errors=[{**place, **line}])


@contextmanager
def _placed(place: _Place) -> Iterator[None]:
    """Locate the errors of one protocol in this block; their pointers start at the body."""
    try:
        yield
    except SpecificationError as error:
        path = error.path if isinstance(error, ProtocolError) else PATH
        pointer = place.protocol if path == PATH else f"{place.within}{field_of_file(path)}"
        raise _within(refused(error, lined=place.lined, path=PATH), pointer, place.which) from error
    except ProblemError as error:
        raise _within(error, place.protocol, place.which) from error


def _within(error: ProblemError, pointer: str, which: str) -> ProblemError:
    """Return an error with its pointers below another."""
    errors = [{**one, "pointer": f"{pointer}{one.get('pointer', '')}"} for one in error.errors]
    return ProblemError(error.kind, f"{which}: {error.detail}" if which else error.detail, errors=errors)
