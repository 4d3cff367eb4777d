"""List the logs by the names of their dialects; of the logs of like machines the first is their default."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from knitlab_core.registries import register_part
from rigs.logs import (
    alemnis,
    biotester,
    bluehill3,
    bluehill3_quoted,
    bluehill3_results,
    bluehill_universal,
    shear_stage,
    triaxial,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigs.logs.logged import Log

_LOGS: Final[dict[str, Log]] = {
    log.dialect.name: log
    for log in (
        biotester.LOG,
        bluehill_universal.LOG,
        bluehill3.LOG,
        bluehill3_quoted.LOG,
        bluehill3_results.LOG,
        triaxial.LOG,
        alemnis.LOG,
        alemnis.AS_TEXT,
        shear_stage.LOG,
    )
}

LOGS: Final[Mapping[str, Log]] = MappingProxyType(_LOGS)
"""All logs, with those that were registered."""


def register_log(log: Log) -> None:
    """Make a log known by the name of its dialect for as long as this process lives.

    Raises
    ------
    SpecificationError
        If the name is none, or another log has it already.
    """
    register_part("dialect", _LOGS, log.dialect.name, log)


def defaults(machines: Iterable[str]) -> list[str]:
    """Return the dialects that a test on some machines is logged in: each machine's, and a merged one's."""
    at_hand, seen, chosen = set(machines), set(), []
    for name, log in LOGS.items():
        if set(log.machines) <= at_hand and log.machines not in seen:
            seen.add(log.machines)
            chosen.append(name)
    return chosen
