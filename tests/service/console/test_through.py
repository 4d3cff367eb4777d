"""Use the console as a person would, in a real headless Chromium: from the editor to the file."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect

from tests.service.console.hands import QUICK, colour_of, contrast, curves, luminance, painted, submit, until, write

if TYPE_CHECKING:
    from pathlib import Path

    import httpx
    from playwright.sync_api import Browser, Page


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
    # The pictures that a job ends with take longer than all the rest.
    page.route("**/v1/jobs", lambda route: route.continue_(url=f"{route.request.url}?pictures=false"))
    page.keyboard.press("Control+Enter")
    # Watch to the end.
    expect(page.locator(".state")).to_have_text("succeeded")
    expect(page.get_by_text("Carried out to its end.")).to_be_visible()
    expect(page).to_have_title("quick succeeded – knitlab")
    job = page.url.rsplit("/", 1)[1]
    # The curves hold every row.
    (folder,) = (data / "jobs").glob(f"*/{job}")
    rows = len((folder / "rows.jsonl").read_text().splitlines())
    assert {one["label"]: len(one["data"]) for one in curves(page, lambda drawn: len(drawn) == 6)[:2]} == {
        "course": rows,
        "wale": rows,
    }
    # The log that is downloaded is the one on disk.
    with page.expect_download() as download:
        page.get_by_role("link", name="run/quick.csv").click()
    download.value.save_as(tmp_path / "got.csv")
    assert (tmp_path / "got.csv").read_bytes() == (folder / "run" / "quick.csv").read_bytes()


def test_the_knit_is_turned_and_scrubbed_by_the_keyboard(page: Page, service: str, done: str) -> None:
    page.goto(f"{service}/#/jobs/{done}")
    canvas = page.locator(".knit canvas")
    expect(canvas).to_have_attribute("aria-label", re.compile("The knit at 0.0 s, Zero 1: course 0.0 %"))
    page.wait_for_function("() => document.querySelector('.knit canvas').width > 300")
    assert len(painted(page)) > 30
    canvas.focus()
    before = page.screenshot(clip=canvas.bounding_box())
    page.keyboard.press("ArrowLeft")
    assert page.screenshot(clip=canvas.bounding_box()) != before
    page.keyboard.press("PageUp")
    expect(page.locator("output")).to_contain_text("Stretch 1")
    titles = {"axial": "axial strain [%]", "bending": "bending strain [%]", "contact": "contact force"}
    for field, title in titles.items():
        page.select_option("#field", field)
        expect(canvas).to_have_attribute("aria-label", re.compile(f"coloured by {field}"))
        expect(page.locator(".legend")).to_contain_text(title)
        # Zero stands on every scale, among three to six numbers.
        ticks = page.locator(".ticks span").all_inner_texts()
        assert 3 <= len(ticks) <= 6
        assert any(float(tick.replace("−", "-")) == 0.0 for tick in ticks)


def test_the_yarn_has_the_colours_of_the_scale(page: Page, service: str, done: str) -> None:
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.locator("output")).to_contain_text("0.0 s")
    page.wait_for_function("() => document.querySelector('.knit canvas').width > 300")
    page.select_option("#field", "contact")
    expect(page.locator(".legend")).to_contain_text("contact force")
    strip = page.locator(".strip").evaluate("(strip) => getComputedStyle(strip).backgroundImage")
    low = colour_of(strip.split("rgb", 2)[1])
    # Most of a knit at rest touches nothing: what lies before the eye is of the colour of zero.
    ground, *yarn = painted(page)
    assert ground == colour_of(page.locator(".knit").evaluate("(box) => getComputedStyle(box).backgroundColor"))
    assert max(abs(a - b) for a, b in zip(yarn[0], low, strict=True)) < 16
    # What is but the noise of rounding is of that colour too.
    script = """async () => {
        const [{ Scale }, { Color }] = await Promise.all([import("/scale.js"), import("/vendor/three.js")]);
        const scale = new Scale();
        scale.set("axial", [-1e-9, 1e-9]);
        return scale.colour(1e-9, new Color()).getStyle();
    }"""
    assert colour_of(page.evaluate(script)) == low


@pytest.mark.usefixtures("running")
def test_jobs_are_asked_to_rest_and_to_end(page: Page, service: str) -> None:
    page.goto(f"{service}/#/?state=running")
    page.get_by_role("button", name="pause long").focus()
    page.keyboard.press("Enter")
    page.goto(service)
    line = page.locator("tr", has_text="long").first
    expect(line.locator(".state")).to_have_text("paused")
    page.get_by_role("button", name="resume long").click()
    expect(line.locator(".state")).to_have_text(re.compile("running|queued"))
    # The button that was pressed is gone; the focus went to the next.
    expect(page.get_by_role("button", name=re.compile("(pause|cancel) long"))).to_have_count(2)
    assert page.evaluate("() => document.activeElement.tagName") == "BUTTON"
    page.get_by_role("button", name="cancel long").click()
    expect(line.locator(".state")).to_have_text("cancelled")


def test_what_has_ended_is_deleted_once_that_is_confirmed(page: Page, service: str, rest: httpx.Client) -> None:
    ids = [submit(rest, QUICK.replace("name: quick", f"name: gone-{k}")) for k in (1, 2)]
    for job in ids:
        rest.post(f"/v1/jobs/{job}/cancel")
        until(rest, job, {"cancelled"})
    page.goto(service)
    button = page.get_by_role("button", name="delete gone-1")
    button.focus()
    page.keyboard.press("Enter")
    question = page.get_by_role("dialog", name=f"Delete gone-1 ({ids[0][:8]})?")
    count = len(rest.get(f"/v1/jobs/{ids[0]}/files").json()["files"])
    expect(question).to_contain_text(f"Lost for good: {f'{count} file' if count else 'No files yet'}")
    expect(question).to_contain_text("This cannot be taken back")
    expect(question.get_by_role("button", name="Keep")).to_be_focused()
    page.keyboard.press("Escape")
    expect(question).to_have_count(0)
    expect(button).to_be_focused()
    assert rest.get(f"/v1/jobs/{ids[0]}").status_code == 200
    page.keyboard.press("Enter")
    expect(question.get_by_role("button", name="Keep")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.locator("tr", has_text="gone-1")).to_have_count(0)
    assert page.evaluate("() => document.activeElement.id") == "page"
    # From its own page one comes back to the list.
    page.goto(f"{service}/#/jobs/{ids[1]}")
    page.get_by_role("button", name="delete gone-2").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(page.get_by_role("heading", name="Jobs")).to_be_visible()
    expect(page.locator("tr", has_text="gone-2")).to_have_count(0)
    assert [rest.get(f"/v1/jobs/{job}").status_code for job in ids] == [404, 404]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_reads_in_light_and_dark(browser: Browser, service: str, scheme: str) -> None:
    context = browser.new_context(color_scheme="dark" if scheme == "dark" else "light")
    page = context.new_page()
    page.goto(f"{service}/#/new")
    ground, ink = page.evaluate(
        "() => ['backgroundColor', 'color'].map((name) => getComputedStyle(document.body)[name])"
    )
    assert (luminance(ground) < luminance(ink)) == (scheme == "dark")
    # What WCAG asks of text at its strictest; and in the editor what it asks of all, selected or not.
    assert contrast(ground, ink) > 7.0
    expect(page.get_by_text("This protocol is valid.")).to_be_visible()
    assert page.locator(".cm-editor").first.evaluate("(node) => getComputedStyle(node).outlineWidth") == "3px"
    page.keyboard.press("Control+A")
    back = page.locator(".cm-selectionBackground").first.evaluate("(node) => getComputedStyle(node).backgroundColor")
    paper = page.locator(".cm-editor").first.evaluate("(node) => getComputedStyle(node).backgroundColor")
    inks = (
        page.locator(".cm-line >> nth=-2")
        .locator("xpath=..")
        .evaluate("(text) => [text, ...text.querySelectorAll('span')].map((node) => getComputedStyle(node).color)")
    )
    context.close()
    assert len(set(inks)) >= 3
    assert back != paper
    assert min(contrast(one, under) for one in inks for under in (back, paper)) > 4.5


def test_the_documentation_of_rest_needs_no_internet(page: Page, service: str) -> None:
    page.goto(f"{service}/docs")
    expect(page.get_by_text("Submit a protocol", exact=True)).to_be_visible()
