"""What users read when something goes wrong."""

from __future__ import annotations

import pickle

import pytest

from knitlab_core.errors import (
    ConvergenceError,
    FormatError,
    GeometryError,
    KnitlabError,
    SolverError,
    SpecificationError,
    UnitError,
)

EXAMPLES = [
    SpecificationError("specimen.rows", 0, "a whole number from 1"),
    UnitError("rate", "0.2 kg", "a speed such as 0.2 mm/s"),
    GeometryError("specimen", "strands 0.02 mm deep in each other", "a clearance above 0"),
    ConvergenceError("no equilibrium at strain 0.31: node 412"),
    FormatError("log.csv", 3, "ten columns"),
]


@pytest.mark.parametrize("error", EXAMPLES, ids=lambda error: type(error).__name__)
def test_message_is_one_line_and_survives_a_process_boundary(error: KnitlabError) -> None:
    copy = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own bytes
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert "\n" not in str(error)


def test_tree() -> None:
    assert issubclass(UnitError, SpecificationError)
    assert issubclass(GeometryError, SpecificationError)
    assert issubclass(ConvergenceError, SolverError)
    for family in (SpecificationError, SolverError, FormatError):
        assert issubclass(family, KnitlabError)


def test_specification_error_names_field_found_and_allowed() -> None:
    error = SpecificationError("specimen.radius", "-1\nmm", "a length\nabove 0")
    assert str(error) == r"specimen.radius: found '-1\nmm', allowed a length above 0"
    assert (error.field, error.found) == ("specimen.radius", "-1\nmm")


def test_format_error_names_path_and_line() -> None:
    assert str(FormatError("log.csv", 3, "ten columns")) == "log.csv:3: expected ten columns"


def test_convergence_error_carries_its_report() -> None:
    report = object()
    assert ConvergenceError(report).report is report
