"""Use the console as a person would, in a real headless Chromium."""

from __future__ import annotations

import json
import re
import shutil
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect, sync_playwright

from tests.service.knitlab_serve import serving

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from playwright.sync_api import Browser, Page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")

PATIENCE = 120_000
expect.set_options(timeout=PATIENCE)
QUICK = """\
schema: knitlab/protocol@1
name: quick
rig: biaxial-hook
specimen: {knit: stockinette-default, loops: [2, 2], loop: 8 mm, material: RGD8530-DM, friction: 0.3}
speed_ref: pair
others: hold
log: {rate: 10 Hz, noise: on, seed: 7}
max_strain_increment: 0.05
steps:
  - zero: {channels: [force, displacement]}
  - cycle: {axes: [C, W], lower: 0, upper: 20 %, rate: 0.2 mm/s, n: 2, tag: twice}
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("console")


@pytest.fixture(scope="module")
def service(data: Path) -> Iterator[str]:
    with serving(data, "--slots", 1) as (address, _):
        yield address


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        options = ["--no-sandbox", "--use-gl=swiftshader", "--enable-unsafe-swiftshader"]
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield opened
        opened.close()


@pytest.fixture
def page(browser: Browser, service: str) -> Iterator[Page]:
    context = browser.new_context(accept_downloads=True)
    context.set_default_timeout(PATIENCE)
    opened = context.new_page()
    mistakes: list[str] = []
    opened.on("pageerror", lambda error: mistakes.append(str(error)))
    # Nothing may come from anywhere but the service.
    opened.on("request", lambda one: mistakes.append(one.url) if not one.url.startswith((service, "blob:")) else None)
    yield opened
    context.close()
    assert mistakes == []


def write(page: Page, text: str) -> None:
    """Replace what stands in the editor, by the keyboard."""
    page.locator(".cm-content").click()
    page.keyboard.press("Control+A")
    page.keyboard.insert_text(text)


def painted(page: Page) -> int:
    """Return how many different colours the picture of the knit has."""
    script = """() => {
        const source = document.querySelector(".knit canvas"), copy = document.createElement("canvas");
        [copy.width, copy.height] = [200, 150];
        const brush = copy.getContext("2d");
        brush.drawImage(source, 0, 0, 200, 150);
        const dots = brush.getImageData(0, 0, 200, 150).data, seen = new Set();
        for (let k = 0; k < dots.length; k += 4) seen.add((dots[k] << 16) | (dots[k + 1] << 8) | dots[k + 2]);
        return seen.size;
    }"""
    return int(page.evaluate(script))


def test_from_the_editor_to_the_file(page: Page, service: str, data: Path, tmp_path: Path) -> None:
    page.goto(f"{service}/#/new")
    # A mistake is shown where it is as one types, and cannot be submitted.
    write(page, QUICK.replace("biaxial-hook", "biaxial-hok"))
    expect(page.locator(".wrong")).to_contain_text("line 3, column 6: rig: found 'biaxial-hok'")
    expect(page.locator(".cm-lintRange-error")).to_have_text("biaxial-hok")
    expect(page.get_by_role("button", name="Submit")).to_be_disabled()
    write(page, QUICK)
    expect(page.get_by_text("This protocol is valid.")).to_be_visible()
    expect(page.get_by_role("button", name="Submit")).to_be_enabled()
    page.keyboard.press("Control+Enter")
    # Watch to the end.
    expect(page.locator(".state")).to_have_text("succeeded", timeout=PATIENCE)
    expect(page.get_by_text("Ended by target.")).to_be_visible()
    job = page.url.rsplit("/", 1)[1]
    # The curves hold every row, each cycle apart.
    drawn = json.loads(
        page.evaluate(
            """async () => {
                const { Chart } = await import("/vendor/chart.js");
                const sets = Object.values(Chart.instances).flatMap((chart) => chart.data.datasets);
                return JSON.stringify(sets.map((set) => [set.label, set.data.length]));
            }"""
        )
    )
    (folder,) = (data / "jobs").glob(f"*/{job}")
    rows = len((folder / "rows.jsonl").read_text().splitlines())
    assert dict(drawn[:2]) == {"course": rows, "wale": rows}
    assert {label for label, _ in drawn[2:]} == {f"{axis}, cycle {n}" for axis in ("course", "wale") for n in (1, 2)}
    # The log that is downloaded is the one on disk.
    with page.expect_download() as download:
        page.get_by_role("link", name="run/quick.csv").click()
    download.value.save_as(tmp_path / "got.csv")
    assert (tmp_path / "got.csv").read_bytes() == (folder / "run" / "quick.csv").read_bytes()


def test_the_knit_is_turned_and_scrubbed_by_the_keyboard(page: Page, service: str) -> None:
    page.goto(service)
    page.get_by_role("link", name=re.compile("quick")).first.click()
    canvas = page.locator(".knit canvas")
    expect(canvas).to_have_attribute("aria-label", re.compile("The knit at 0.0 s, Zero 1: course 0.0 %"))
    page.wait_for_function("() => document.querySelector('.knit canvas').width > 300")
    assert painted(page) > 30
    canvas.focus()
    before = page.screenshot(clip=canvas.bounding_box())
    page.keyboard.press("ArrowLeft")
    assert page.screenshot(clip=canvas.bounding_box()) != before
    page.keyboard.press("PageUp")
    expect(page.locator("output")).to_contain_text("Stretch 1")
    labels = {}
    for field in ("axial", "bending", "contact"):
        page.select_option("#field", field)
        expect(canvas).to_have_attribute("aria-label", re.compile(f"coloured by {field}"))
        labels[field] = page.locator(".legend").inner_text()
    assert len(set(labels.values())) == 3
    assert "N" in labels["contact"]


def test_jobs_are_asked_to_rest_and_to_end(page: Page, service: str) -> None:
    long = QUICK.replace("name: quick", "name: long").replace("[2, 2]", "[6, 6]").replace("0.05", "0.002")
    page.goto(f"{service}/#/new")
    write(page, long)
    page.get_by_role("button", name="Submit").click()
    expect(page.locator(".state")).to_have_text(re.compile("running"))
    page.goto(service)
    page.get_by_role("button", name="pause long").click()
    expect(page.locator("tr", has_text="long").locator(".state")).to_have_text("paused")
    page.get_by_role("button", name="resume long").click()
    expect(page.locator("tr", has_text="long").locator(".state")).to_have_text(re.compile("running|queued"))
    page.get_by_role("button", name="cancel long").click()
    expect(page.locator("tr", has_text="long").locator(".state")).to_have_text("cancelled")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_reads_in_light_and_dark(browser: Browser, service: str, scheme: str) -> None:
    context = browser.new_context(color_scheme="dark" if scheme == "dark" else "light")
    page = context.new_page()
    page.goto(service)
    script = """() => ["backgroundColor", "color"].map((name) => getComputedStyle(document.body)[name])"""
    ground, ink = (luminance(colour) for colour in page.evaluate(script))
    context.close()
    assert (ground < ink) == (scheme == "dark")
    low, high = sorted((ground, ink))
    # What WCAG asks of text at its strictest.
    assert (high + 0.05) / (low + 0.05) > 7.0


def test_the_documentation_of_rest_needs_no_internet(page: Page, service: str) -> None:
    page.goto(f"{service}/docs")
    expect(page.get_by_text("Submit a protocol", exact=True)).to_be_visible()


def luminance(colour: str) -> float:
    """Return the relative luminance of a CSS colour (WCAG 2.2)."""
    parts = [int(part) / 255 for part in re.findall(r"\d+", colour)[:3]]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
