from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from app.service.settings import settings
from app.service.store import Store
from tests.service.databases import new_database, postgres, postgres_programs
from tests.service.lab import Lab

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

POSTGRES = pytest.param(
    "postgres", marks=pytest.mark.skipif(postgres_programs() is None, reason="PostgreSQL is not installed")
)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run what asks for a database on SQLite and on PostgreSQL; marked `postgres`, on that alone."""
    if "database" in metafunc.fixturenames:
        many = metafunc.definition.get_closest_marker("postgres") is not None
        metafunc.parametrize("database", [POSTGRES] if many else ["sqlite", POSTGRES], indirect=True)


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    """Start PostgreSQL."""
    with postgres() as url:
        yield url


@pytest.fixture
def database(request: pytest.FixtureRequest) -> str:
    """Return what KNITLAB_DB says: nothing for SQLite, or the URL of a new database in PostgreSQL."""
    return new_database(request.getfixturevalue("server")) if request.param == "postgres" else ""


@pytest.fixture
def store(database: str, tmp_path: Path) -> Iterator[Store]:
    """Open a store that no worker serves."""
    with Store(settings(tmp_path, {"KNITLAB_DB": database})) as made:
        yield made


@pytest.fixture
def lab(database: str, tmp_path: Path) -> Iterator[Lab]:
    """Open a lab without workers."""
    made = Lab(tmp_path, database)
    yield made
    made.close()
