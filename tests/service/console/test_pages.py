"""Go from page to page: by keyboard, too early, on a phone, by sweep, and while the service is away."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect

from app.service.api.build import create_app
from app.service.api.context import Context
from tests.service.console.hands import QUICK, edited, until
from tests.service.serving import served

if TYPE_CHECKING:
    from typing import Any

    import httpx
    from playwright.sync_api import Browser, Page, Route

    from app.service.store import Store

LIST = re.compile(r"/v1/jobs\?")
ONE = re.compile(r"/v1/jobs/[0-9a-f]+$")
AWAY = "The service cannot be reached; trying again."


def test_the_skip_link_leads_into_the_page(page: Page, service: str, done: str) -> None:
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.get_by_role("heading", name="done")).to_be_visible()
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Skip to the page")).to_be_focused()
    page.keyboard.press("Enter")
    assert page.evaluate("() => document.activeElement.id") == "page"
    assert page.url.endswith(f"#/jobs/{done}")
    expect(page.get_by_role("heading", name="done")).to_be_visible()


def test_a_page_that_is_left_early_leaves_nothing(page: Page, service: str, done: str) -> None:
    page.goto(service)
    expect(page.locator(f"[data-job='{done}']")).to_be_visible()
    held: list[Route] = []
    slow = True

    def hold(route: Route) -> None:
        if slow:
            held.append(route)
        else:
            route.continue_()

    page.route(re.compile(r"/v1/jobs(/[0-9a-f]+$|\?)|/starter\.yaml$"), hold)
    for address in (f"#/jobs/{done}", "#/new", "#/?state=queued", f"#/jobs/{done}", "#/new", "#/"):
        page.evaluate("(address) => { location.hash = address; }", address)
        page.wait_for_timeout(60)
    slow = False
    for route in held:
        route.continue_()
    expect(page.locator(f"[data-job='{done}']")).to_be_visible()
    assert page.locator("h1").all_inner_texts() == ["Jobs"]
    assert page.locator("canvas, .cm-editor").count() == 0
    # One list alone asks for news, every two seconds.
    asked: list[str] = []
    page.on("request", lambda one: asked.append(one.url))
    page.wait_for_timeout(2600)
    assert 1 <= len([one for one in asked if LIST.search(one)]) <= 2
    assert all("state=queued" not in one and "/events" not in one for one in asked)


def test_the_service_goes_away_and_comes_back(page: Page, service: str, done: str) -> None:
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.locator("output")).to_contain_text("0.0 s, Zero 1")
    page.context.set_offline(True)
    # What is asked for says that it does not come, and playing stops.
    page.get_by_role("button", name="Play").click()
    expect(page.locator("output")).to_contain_text("not shown, the service cannot be reached")
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    expect(page.get_by_text(AWAY)).to_be_visible()
    # A page that is opened meanwhile comes by itself; the list goes on.
    page.evaluate("() => { location.hash = '#/'; }")
    expect(page.get_by_text("This page comes as soon as the service can be reached.")).to_be_visible()
    page.context.set_offline(False)
    expect(page.locator(f"[data-job='{done}']")).to_be_visible()
    expect(page.get_by_text(AWAY)).to_be_hidden()


def test_nothing_goes_beyond_the_side_of_a_phone(page: Page, service: str, done: str) -> None:
    page.set_viewport_size({"width": 390, "height": 844})

    def rename(body: Any) -> None:  # noqa: ANN401 (a job, or a page of them)
        for job in body.get("jobs", [body]):
            job |= {"name": "n" * 64, "state": "running", "finished": None, "end": None}

    page.route(ONE, edited(rename))
    page.route(LIST, edited(rename))
    page.route("**/events", lambda route: route.fulfill(status=204))
    for address, shown in (
        (f"#/jobs/{done}", ".knit"),
        ("#/new", "dl"),
        ("#/sweeps", "h1"),
        (f"#/compare/{done}", f"[data-job='{done}']"),
        ("#/", f"[data-job='{done}']"),
    ):
        page.goto(f"{service}/{address}")
        expect(page.locator(shown)).to_be_visible()
        page.evaluate("async () => (await import('/dom.js')).tell('t'.repeat(200))")
        wide, seen = page.evaluate("() => ['scrollWidth', 'clientWidth'].map((name) => document.documentElement[name])")
        assert wide <= seen, address
    # On a desk a long name leaves the buttons in sight, and the line whole.
    page.set_viewport_size({"width": 1100, "height": 700})
    button = page.locator(f"[data-job='{done}']").get_by_role("button", name="cancel")
    box = button.bounding_box()
    assert box is not None
    assert box["x"] + box["width"] <= 1100
    assert {cell.evaluate("(td) => getComputedStyle(td).display") for cell in page.locator("td").all()} == {
        "table-cell"
    }


@pytest.mark.usefixtures("running")
def test_a_sweep_is_shown_alone_and_jobs_by_state(page: Page, service: str, rest: httpx.Client) -> None:
    text = QUICK.replace("friction: 0.3", 'friction: "${mu}"') + "params: {mu: 0.3}\n"
    sent = rest.post("/v1/sweeps", json={"protocol": text, "values": {"mu": [0.1, 0.2, 0.3]}})
    sweep = sent.raise_for_status().json()["sweep"]
    ids = {job["id"] for job in rest.get("/v1/jobs", params={"sweep": sweep}).json()["jobs"]}
    page.goto(service)
    expect(page.get_by_role("link", name=re.compile(r"^queued 3$"))).to_be_visible()
    expect(page.get_by_text(re.compile(r"^1–\d+ of \d+$"))).to_be_visible()
    page.get_by_role("link", name=f"sweep {sweep[:8]}").first.click()
    page.get_by_role("link", name="As a list of jobs").click()
    expect(page.locator("tbody tr")).to_have_count(3)
    assert set(page.locator("tbody tr").evaluate_all("(rows) => rows.map((row) => row.dataset.job)")) == ids
    expect(page.get_by_text("1–3 of 3")).to_be_visible()
    # What runs is found at once, however many came after it.
    page.get_by_role("link", name="Show all jobs").click()
    page.get_by_role("link", name=re.compile("^running 1$")).click()
    expect(page.locator("tbody tr")).to_have_count(1)
    expect(page.locator("tbody tr")).to_contain_text("long")
    for job in ids:
        rest.post(f"/v1/jobs/{job}/cancel")
        until(rest, job, {"cancelled"})


@pytest.mark.slow
def test_the_token_is_asked_for_once(browser: Browser, store: Store) -> None:
    with served(create_app(Context(store=store, token="right"))) as address:  # noqa: S106 (of a test)
        page = browser.new_page()
        asked: list[str] = []
        page.on("request", lambda one: asked.append(one.url) if "/v1/" in one.url else None)
        page.goto(address)
        question = page.get_by_label("This service asks for its token")
        expect(question).to_be_focused()
        page.wait_for_timeout(2200)
        assert len(asked) == 1
        question.fill("wrong")
        page.keyboard.press("Enter")
        expect(page.get_by_text("The last one was refused.")).to_be_visible()
        question.fill("right")
        page.keyboard.press("Enter")
        expect(page.get_by_role("link", name=re.compile("^all"))).to_be_visible()
        expect(page.get_by_role("button", name="Newer")).to_be_hidden()
        expect(question).to_be_hidden()
        page.close()
