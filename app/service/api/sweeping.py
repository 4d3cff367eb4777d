"""Jobs from the body of a sweep: a list of protocols, or a protocol over values of its parameters."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING, Any

from app.checks.dry_run import count_rows
from app.schemas import ProtocolError, loads_document
from app.schemas.document import parse_text
from app.schemas.errors import shown
from app.schemas.sweep import combinations
from app.service.api.bodies import PATH, field_of_file, parse_json, submitted, written
from app.service.api.bounds import check_protocol, check_rows, check_sweep, check_texts
from app.service.api.problems import ProblemError, beyond, refused
from app.service.jobs import JobSpec
from knitlab_core.errors import SpecificationError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from app.schemas import Loaded
    from app.schemas.document import Document
    from app.service.api.bounds import Bounds

_LONGEST_NAME = 64


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
    """A protocol of a sweep, its materials, and its place in the body."""

    loaded: Loaded
    materials: str
    place: _Place


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
    for one in found:
        with _placed(one.place):
            check_protocol(one.loaded.protocol, bounds)
    check_sweep([one.loaded.protocol for one in found], bounds)
    for one in found:
        with _placed(one.place):
            check_rows(count_rows(one.loaded), bounds)
    return [JobSpec(name=one.loaded.protocol.name, protocol=one.loaded.text, materials=one.materials) for one in found]


def _listed(data: Mapping[str, Any], bounds: Bounds) -> Iterator[_Wanted]:
    """Yield the protocols of a list."""
    protocols = data["protocols"]
    if len(data) > 1 or not isinstance(protocols, list) or not protocols:
        raise _wrong("/protocols", "something else", "a list of one protocol or more, and nothing beside it")
    _check_count(len(protocols), bounds, "/protocols")
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


def _crossed(data: Mapping[str, Any], bounds: Bounds) -> Iterator[_Wanted]:
    """Yield a protocol with every combination of the values of its parameters."""
    sent = submitted({key: value for key, value in data.items() if key != "values"}, "test")
    whole = _Place(within="", protocol="/protocol", which="", lined=sent.lined)
    with _placed(whole):
        document = parse_text(sent.text, PATH)
    base = _data_of(document)
    own = base.pop("sweep", None)
    pointer = "/values" if "values" in data else "/protocol/sweep"
    values = _checked_values(data.get("values", own), pointer)
    count = prod(len(one) for one in values.values())
    _check_count(count, bounds, pointer)
    check_texts(count * sent.size, bounds, pointer)
    params = base.get("params", {})
    for name in values:
        if not isinstance(params, dict) or name not in params:
            raise _wrong(f"{pointer}/{name}", "no such parameter", "a name under `params` of the protocol")
    name = str(base.get("name", sent.name))
    for number, point in enumerate(combinations(values), start=1):
        tail = f"-{number:0{len(str(count))}}"
        one = {**base, "name": f"{name[: _LONGEST_NAME - len(tail)]}{tail}", "params": {**params, **point}}
        place = replace(whole, which=", ".join(f"{key} = {shown(value)}" for key, value in point.items()))
        with _placed(place):
            # Places of the text that was sent, values of this job.
            made = replace(document, text=written(one), data=one)
            loaded = loads_document(made, name=name, materials=sent.materials, files=sent.files)
        yield _Wanted(loaded=loaded, materials=loaded.beside(sent.materials), place=place)


def _data_of(document: Document) -> dict[str, Any]:
    """Return the data of a protocol's text."""
    if not isinstance(document.data, dict):
        raise _wrong("/protocol", "something else", "a protocol")
    # What YAML may hold and JSON not, such as a number too large, is refused here.
    return dict(parse_json(written(document.data)))


def _checked_values(values: Any, pointer: str) -> dict[str, list[Any]]:  # noqa: ANN401 (whatever JSON holds)
    """Return the values of a sweep, each a list of plain values."""
    if not isinstance(values, dict) or not values:
        raise _wrong(pointer, "something else", "a mapping of names to lists")
    for name, listed in values.items():
        plain = isinstance(listed, list) and all(isinstance(one, str | int | float) for one in listed)
        if not plain or not listed:
            raise _wrong(f"{pointer}/{name}", "something else", "a list of one number or text or more")
    return values


def _check_count(count: int, bounds: Bounds, pointer: str) -> None:
    """Refuse a sweep of too many jobs."""
    if count > bounds.sweep:
        raise beyond("jobs of the sweep", count, bounds.sweep, pointer=pointer)


def _wrong(pointer: str, found: str, allowed: str) -> ProblemError:
    """Return the error of a part of the body."""
    detail = f"{pointer or 'sweep'}: found {found}, allowed {allowed}"
    return ProblemError("invalid-request", detail, errors=[{"detail": detail, "pointer": pointer}])


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
