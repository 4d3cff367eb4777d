from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest

from app.service.api.build import create_app
from app.service.api.context import Context
from app.service.jobs import Job, JobSpec
from app.service.settings import settings
from app.service.store import Store
from tests.service.serving import served

if TYPE_CHECKING:
    from collections.abc import Iterator

SMALL = Path(__file__).parents[2] / "examples" / "biaxial_small.yaml"


@pytest.fixture(scope="package")
def store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    """Open a store that no worker serves: its jobs stay as the tests put them."""
    with Store(settings(tmp_path_factory.mktemp("service"), {})) as opened:
        yield opened


@pytest.fixture(scope="package")
def address(store: Store) -> Iterator[str]:
    """Serve the store."""
    with served(create_app(Context(store=store))) as at:
        yield at


@pytest.fixture
def http(address: str) -> Iterator[httpx.Client]:
    """Talk to the service."""
    with httpx.Client(base_url=address, timeout=30.0) as client:
        yield client


@pytest.fixture(scope="session")
def protocol() -> str:
    """Return the YAML of a small test."""
    return SMALL.read_text(encoding="utf-8")


@pytest.fixture
def job(store: Store, protocol: str) -> Job:
    """Accept a job."""
    return store.submit(JobSpec(name="biaxial_small", protocol=protocol))
