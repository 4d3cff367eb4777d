"""Write a protocol: what is said of it is said of the text that stands there, and no text is lost."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import expect

from tests.service.console.hands import QUICK, write

if TYPE_CHECKING:
    import httpx
    from playwright.sync_api import Page, Route

EXAMPLES = Path(__file__).parents[3] / "examples"
VALID = "This protocol is valid."
WRONG = QUICK.replace("biaxial-hook", "biaxial-hok")


def test_an_answer_that_was_overtaken_says_nothing(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    verdict, submit = page.locator(".right, .wrong"), page.get_by_role("button", name="Submit")
    expect(verdict).to_have_text(VALID)
    held: list[Route] = []

    def hold(route: Route) -> None:
        if "biaxial-hok" in (route.request.post_data or ""):
            route.continue_()
        else:
            held.append(route)

    page.route("**/protocols:validate", hold)
    with page.expect_request("**/protocols:validate"):
        write(page, QUICK)
    # Nothing is valid that was not said to be.
    expect(submit).to_be_disabled()
    write(page, WRONG)
    expect(verdict).to_contain_text("biaxial-hok")
    (late,) = held
    with page.expect_response("**/protocols:validate"):
        late.continue_()
    page.wait_for_timeout(200)
    expect(verdict).to_contain_text("biaxial-hok")
    expect(page.locator(".cm-lintRange-error")).to_have_text("biaxial-hok")
    expect(submit).to_be_disabled()


def test_the_plan_says_of_which_text_it_is(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    expect(page.get_by_text("Rows of the log")).to_be_visible()
    old = page.get_by_text("Of the last valid text, not of this one.")
    expect(old).to_be_hidden()
    write(page, WRONG)
    expect(old).to_be_visible()
    expect(page.locator(".stale").first).to_contain_text("Rows of the log")
    write(page, QUICK)
    expect(page.get_by_text(VALID)).to_be_visible()
    expect(old).to_be_hidden()


def test_starting_over_loses_nothing(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    text = page.locator(".cm-content").first
    for name in ("mine", "another"):
        write(page, QUICK.replace("name: quick", f"name: {name}"))
        page.get_by_role("button", name="Start over").click()
        expect(text).to_contain_text("name: first_test")
        page.keyboard.press("Control+Z")
        expect(text).to_contain_text(f"name: {name}")
    page.get_by_role("button", name="Start over").click()
    write(page, QUICK.replace("name: quick", "name: later"))
    page.reload()
    expect(text).to_contain_text("name: later")


def test_materials_go_with_the_protocol(page: Page, service: str, rest: httpx.Client) -> None:
    protocol = (EXAMPLES / "creeping_small.yaml").read_text()
    materials = (EXAMPLES / "materials" / "my-resins.yaml").read_text()
    page.goto(f"{service}/#/new")
    write(page, protocol)
    # The page says what to do in it.
    expect(page.locator(".wrong")).to_contain_text(
        "materials: no file materials/my-resins.yaml is here; open Materials"
    )
    page.get_by_text("Materials", exact=True).click()
    # What is wrong in them is marked in them.
    write(page, materials.replace("0.82 GPa", "0.82 Gxx"), ".cm-content >> nth=1")
    expect(page.locator(".wrong")).to_contain_text("young_modulus")
    expect(page.locator(".cm-editor >> nth=1").locator(".cm-lintRange-error")).to_contain_text("0.82 Gxx")
    expect(page.locator(".cm-editor >> nth=0").locator(".cm-lintRange-error")).to_have_count(0)
    write(page, materials, ".cm-content >> nth=1")
    expect(page.get_by_text(VALID)).to_be_visible()
    with page.expect_response(re.compile("/v1/jobs$")) as sent:
        page.keyboard.press("Control+Enter")
    assert json.loads(sent.value.request.post_data or "") == {"protocol": protocol, "materials": materials}
    job = sent.value.json()["id"]
    assert rest.post(f"/v1/jobs/{job}/cancel").is_success
    # They are kept, and shown, for the next one.
    expect(page.locator(".state")).to_be_visible()
    page.goto(f"{service}/#/new")
    expect(page.locator(".cm-content >> nth=1")).to_contain_text("creeping-resin")


def test_the_text_is_checked_again_when_the_service_is_back(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    expect(page.get_by_text(VALID)).to_be_visible()
    page.context.set_offline(True)
    write(page, QUICK)
    expect(page.get_by_text("Not checked, as the service cannot be reached")).to_be_visible()
    # No line of the text is to blame.
    expect(page.locator(".cm-lintRange-error, .cm-lint-marker-error")).to_have_count(0)
    expect(page.get_by_role("button", name="Submit")).to_be_disabled()
    page.context.set_offline(False)
    expect(page.get_by_text(VALID)).to_be_visible()
    expect(page.get_by_role("button", name="Submit")).to_be_enabled()
