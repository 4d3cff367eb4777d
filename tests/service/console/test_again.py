"""Take a job up again, see what it drew, and read errors in words of the page."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

from playwright.sync_api import expect

from tests.service.console.hands import QUICK, write

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Page, Route

MINE = QUICK.replace("name: quick", "name: mine")


def test_a_job_is_edited_and_run_again_and_the_draft_is_kept(page: Page, service: str, done: str) -> None:
    text = page.locator(".cm-content").first
    page.goto(f"{service}/#/jobs/{done}")
    page.get_by_role("link", name="Edit and run again").click()
    expect(page.get_by_text("This is the protocol of done.", exact=True)).to_be_visible()
    expect(page).to_have_url(f"{service}/#/new")
    write(page, MINE)
    page.goto(f"{service}/#/jobs/{done}")
    page.get_by_role("link", name="Edit and run again").click()
    expect(text).to_contain_text("name: done")
    expect(page.get_by_text("This is the protocol of done. Your draft from before is kept.")).to_be_visible()
    # Loaded again, the page has what was written since, and the draft is there still.
    write(page, QUICK.replace("name: quick", "name: changed"))
    page.reload()
    expect(text).to_contain_text("name: changed")
    # Another one put on top of it loses neither.
    page.goto(f"{service}/#/jobs/{done}")
    page.get_by_role("link", name="Edit and run again").click()
    expect(text).to_contain_text("name: done")
    page.get_by_role("button", name="Back to my draft").click()
    expect(text).to_contain_text("name: changed")
    page.get_by_role("button", name="Back to my draft").click()
    expect(text).to_contain_text("name: mine")
    expect(page.get_by_role("button", name="Back to my draft")).to_be_hidden()
    page.keyboard.press("Control+Z")
    expect(text).to_contain_text("name: changed")


def test_what_a_job_drew_and_came_to_is_seen_on_its_page(page: Page, service: str, done: str, data: Path) -> None:
    # A picture of the page stands for those of the test, which take longer than all the rest.
    (folder,) = (data / "jobs").glob(f"*/{done}")
    page.goto(service)
    (folder / "run" / "done_knit.png").write_bytes(page.screenshot())
    page.goto(f"{service}/#/jobs/{done}")
    picture = page.get_by_role("img", name="done knit")
    expect(picture).to_be_visible()
    page.wait_for_function("(img) => img.naturalWidth > 300", arg=picture.element_handle())
    page.get_by_text("Figures of the test").click()
    (peak,) = [one for one in json.loads((folder / "figures.json").read_text()) if one["name"] == "equilibria"]
    expect(page.get_by_role("row", name="equilibria", exact=False).first).to_contain_text(f"{peak['value']:.0f}")


def test_errors_and_waits_speak_of_the_page(page: Page, service: str) -> None:
    page.goto(f"{service}/#/jobs/none")
    expect(page.get_by_text("That is not there any more; it may have been deleted. Jobs shows")).to_be_visible()
    page.goto(f"{service}/#/new")
    wave = "waveform: {axes: [C], table: wave.csv}"
    write(page, MINE.replace("cycle: {axes: [C, W], lower: 0, upper: 20 %, rate: 0.2 mm/s, n: 2, tag: twice}", wave))
    expect(page.locator(".wrong")).to_contain_text("table: no file wave.csv is here; add it under Files")
    assert "a text without a file" not in page.inner_text("body")
    write(page, MINE)
    expect(page.get_by_text("This protocol is valid.")).to_be_visible()
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    page.route("**/specimens:preview", hold)
    page.get_by_role("button", name="Draw the knit").click()
    expect(page.get_by_role("progressbar", name="Drawing the knit")).to_be_visible()
    expect(page.get_by_text(re.compile("^[12] s$"))).to_be_visible()
    busy = json.dumps({"type": "urn:knitlab:problem:busy", "status": 503, "detail": "other pictures are being drawn"})
    held[0].fulfill(status=503, body=busy, content_type="application/problem+json")
    expect(page.locator("#status")).to_have_text(
        "The service is busy: other pictures are being drawn. Try again in a moment."
    )
    expect(page.get_by_role("progressbar", name="Drawing the knit")).to_be_hidden()
