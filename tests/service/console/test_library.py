"""Begin with an example, with the files that it names; see its knit before the test and in it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import expect

from tests.service.console.hands import QUICK, painted, write

if TYPE_CHECKING:
    import httpx
    from playwright.sync_api import Page

EXAMPLES = Path(__file__).parents[3] / "examples"
VALID = "This protocol is valid."


def choose(page: Page, words: str, name: str) -> None:
    """Choose an example by the keyboard."""
    page.get_by_role("button", name="Examples").press("Enter")
    expect(page.get_by_label("Filter the examples")).to_be_focused()
    page.keyboard.type(words)
    entry = page.locator(".examples li button:visible")
    expect(entry).to_have_count(1)
    expect(entry).to_contain_text(name)
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")


def test_an_example_comes_with_its_materials_and_goes_by_undo(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    text = page.locator(".cm-content").first
    write(page, QUICK.replace("name: quick", "name: mine"))
    choose(page, "creeps 20", "creeping small")
    expect(text).to_contain_text("name: creeping_small")
    expect(page.locator(".cm-content").nth(1)).to_contain_text("creeping-resin")
    expect(page.get_by_text(VALID)).to_be_visible()
    expect(text).to_be_focused()
    page.keyboard.press("Control+Z")
    expect(text).to_contain_text("name: mine")
    # Escape chooses none.
    page.get_by_role("button", name="Examples").click()
    page.keyboard.type("no such words")
    expect(page.get_by_text("No example has these words.")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    expect(text).to_contain_text("name: mine")


def test_a_centreline_of_ones_own_is_drawn_and_tested(page: Page, service: str, rest: httpx.Client) -> None:
    page.route(re.compile("/v1/jobs$"), lambda route: route.continue_(url=f"{route.request.url}?pictures=false"))
    page.goto(f"{service}/#/new")
    choose(page, "serpentine", "serpentine small")
    expect(page.get_by_text(VALID)).to_be_visible()
    expect(page.locator(".cm-content").first).to_contain_text("name: serpentine_small")
    write(page, (EXAMPLES / "serpentine_small.yaml").read_text(encoding="utf-8").replace("upper: 20 %", "upper: 2 %"))
    area = page.get_by_label("Text of the file")
    points = area.input_value()
    assert points == (EXAMPLES / "serpentine.csv").read_text(encoding="utf-8")
    # What is wrong in the file is said of the file, with its line, and of no line of the protocol.
    area.fill(points.replace("course-", "curse-"))
    expect(page.locator(".beside .wrong")).to_contain_text("line 2, column 1: site: found 'curse-'")
    expect(page.locator(".cm-lintRange-error")).to_have_count(0)
    area.fill(points)
    expect(page.get_by_text(VALID)).to_be_visible()
    page.get_by_role("button", name="Draw the knit").click()
    picture = page.locator("img.specimen")
    expect(picture).to_be_visible()
    assert picture.evaluate("(image) => image.decode().then(() => image.naturalWidth)") > 200
    page.get_by_role("button", name="Submit").click()
    expect(page.locator(".state")).to_have_text("succeeded")
    job = page.url.rsplit("/", 1)[1]
    # The points are in the protocol of the job, which needs no file.
    assert "x [l],y [l],z [l],site" in rest.get(f"/v1/jobs/{job}/files/protocol.yaml").text
    expect(page.locator(".knit canvas")).to_be_visible()
    # The knit is fetched and drawn some time after the job has ended; it is shaded yarn, not an empty stage.
    for _ in range(100):
        if len(painted(page)) > 20:
            break
        page.wait_for_timeout(100)
    assert len(painted(page)) > 20


def test_files_are_added_from_a_disk_and_kept(page: Page, service: str, tmp_path: Path) -> None:
    (tmp_path / "my-knit.csv").write_text((EXAMPLES / "serpentine.csv").read_text(encoding="utf-8"), encoding="utf-8")
    protocol = (EXAMPLES / "serpentine_small.yaml").read_text(encoding="utf-8").replace("serpentine.csv", "my-knit.csv")
    page.goto(f"{service}/#/new")
    write(page, protocol)
    expect(page.locator(".wrong").first).to_contain_text("my-knit.csv")
    page.locator("summary", has_text="Files").click()
    page.locator("input[type=file]").set_input_files(
        [tmp_path / "my-knit.csv", EXAMPLES / "materials" / "my-resins.yaml"]
    )
    expect(page.get_by_text(VALID)).to_be_visible()
    expect(page.locator(".cm-content").nth(1)).to_contain_text("creeping-resin")
    page.reload()
    expect(page.get_by_label("Name of the file")).to_have_value("my-knit.csv")
    # A name that leads elsewhere is refused by the service.
    page.get_by_label("Name of the file").fill("../my-knit.csv")
    expect(page.locator("p.wrong[role=status]")).to_contain_text("files: found '../my-knit.csv'")
    page.get_by_role("button", name="Remove").click()
    expect(page.locator("summary", has_text="Files")).to_be_focused()


def test_a_knit_of_another_stitch_is_drawn(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    write(page, QUICK.replace("stockinette-default", "rib-1x1"))
    expect(page.get_by_text(VALID)).to_be_visible()
    with page.expect_response("**/specimens:preview") as answer:
        page.get_by_role("button", name="Draw the knit").click()
    assert answer.value.headers["content-type"] == "image/png"
    expect(page.locator("img.specimen")).to_be_visible()
