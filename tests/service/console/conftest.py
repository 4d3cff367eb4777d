from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import httpx
import pytest
from playwright.sync_api import expect, sync_playwright

from tests.service.console.hands import LONG, PATIENCE, QUICK, submit, until
from tests.service.knitlab_serve import serving

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from playwright.sync_api import Browser, Page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
expect.set_options(timeout=PATIENCE)


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """Start a real browser."""
    if CHROMIUM is None:
        pytest.skip("no Chromium is installed")
    with sync_playwright() as playwright:
        options = ["--no-sandbox", "--use-gl=swiftshader", "--enable-unsafe-swiftshader"]
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield opened
        opened.close()


@pytest.fixture(scope="package")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("console")


@pytest.fixture(scope="package")
def service(data: Path, browser: Browser) -> Iterator[str]:  # noqa: ARG001 (no service without a browser)
    with serving(data, "--slots", 1) as (address, _):
        yield address


@pytest.fixture(scope="package")
def rest(service: str) -> Iterator[httpx.Client]:
    """Talk to the service beside the console."""
    with httpx.Client(base_url=service, timeout=30.0) as client:
        yield client


@pytest.fixture(scope="package")
def done(rest: httpx.Client) -> str:
    """Return the id of a job of two cycles that has succeeded."""
    job = submit(rest, QUICK.replace("name: quick", "name: done"))
    until(rest, job, {"succeeded"})
    return job


@pytest.fixture
def running(rest: httpx.Client) -> Iterator[str]:
    """Lend the id of a job that runs for long."""
    job = submit(rest, LONG)
    until(rest, job, {"running"})
    yield job
    rest.post(f"/v1/jobs/{job}/cancel")
    until(rest, job, {"cancelled"})


@pytest.fixture
def page(browser: Browser, service: str) -> Iterator[Page]:
    """Open a page that makes no mistake, and to which nothing comes from anywhere but the service."""
    context = browser.new_context(accept_downloads=True, viewport={"width": 1280, "height": 800})
    context.set_default_timeout(PATIENCE)
    opened = context.new_page()
    mistakes: list[str] = []
    opened.on("pageerror", lambda error: mistakes.append(str(error)))
    opened.on("request", lambda one: mistakes.append(one.url) if not one.url.startswith((service, "blob:")) else None)
    yield opened
    context.close()
    assert mistakes == []
