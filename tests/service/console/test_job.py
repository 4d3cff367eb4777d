"""Look at one job: what stays as it goes on, what is drawn of it, and what is said where there is nothing to draw."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect

from tests.service.console.hands import curves, edited, seen_yarn

if TYPE_CHECKING:
    import httpx
    from playwright.sync_api import Page, Route

LOOK = "() => window.dispatchEvent(new Event('reached'))"
"""Have the page look at once at what it looks at every five seconds."""


def stream(rows: list[dict[str, object]]) -> str:
    """Return the event stream of a job whose rows come by two hundred."""
    parts = [rows[first : first + 200] for first in range(0, len(rows), 200)]
    return "".join(f"event: rows\ndata: {json.dumps({'first': 0, 'rows': part})}\nid: x\n\n" for part in parts)


def serve_rows(page: Page, rows: list[dict[str, object]]) -> None:
    """Answer the page's question for events with some rows, and then with their end."""

    def answer(route: Route) -> None:
        if "last-event-id" in route.request.headers:
            route.fulfill(status=204)
        else:
            route.fulfill(status=200, content_type="text/event-stream", body=stream(rows))

    page.route("**/events", answer)


def wave(count: int, cycles: int) -> list[dict[str, object]]:
    """Return rows of a test of some cycles, all alike."""
    per = count // cycles
    rows: list[dict[str, object]] = []
    for k in range(count):
        strain = 0.4 * (1.0 - abs(2.0 * (k % per) / per - 1.0))
        rows.append({"time": 1.0 * k, "cycle": 1 + k // per, "strain": {"C": strain}, "force": {"C": strain**2}})
    return rows


def test_each_cycle_has_a_look_of_its_own(page: Page, service: str, done: str) -> None:
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.get_by_text("course, cycles 1 to 2")).to_be_visible()
    looks = {one["label"]: one for one in curves(page, lambda drawn: len(drawn) == 6)}
    for axis in ("course", "wale"):
        first, second = looks[f"{axis}, cycle 1"], looks[f"{axis}, cycle 2"]
        # The later lies on the earlier, which is seen at both its sides.
        assert second["order"] < first["order"]
        assert second["width"] < 0.5 * first["width"]
        assert second["colour"] != first["colour"]
    page.get_by_label("Cycle").select_option("2")
    drawn = curves(page, lambda drawn: len(drawn) == 4)
    assert {one["label"] for one in drawn[2:]} == {"course, cycle 2", "wale, cycle 2"}


@pytest.mark.slow
def test_many_cycles_and_rows_are_drawn_at_once(page: Page, service: str, done: str) -> None:
    serve_rows(page, wave(24_000, 12))
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.get_by_text("course, cycles 1 to 12")).to_be_visible(timeout=5000)
    drawn = curves(page, lambda drawn: len(drawn) == 13 and drawn[0]["data"][-1]["x"] == 23_999)
    time, stress = drawn[0], drawn[1:]
    # As many dots as can be seen, with every crest among them.
    assert 1000 < len(time["data"]) < 4000
    assert sum(dot["y"] == pytest.approx(0.16) for dot in time["data"]) == 12
    assert len({one["colour"] for one in stress}) == 12
    # What tells them apart leaves the charts their room.
    assert page.locator(".entry").bounding_box()["height"] < 40  # type: ignore[index]  # it is visible


def test_the_focus_and_the_log_outlive_the_news(page: Page, service: str, running: str) -> None:
    page.goto(f"{service}/#/jobs/{running}")
    pause = page.get_by_role("button", name="pause long")
    pause.focus()
    link = page.get_by_role("link", name="job.log")
    expect(link).to_be_visible()
    link.evaluate("(node) => { node.dataset.same = 'yes'; }")
    seen: set[float] = set()
    while len(seen) < 3:
        seen.add(page.locator("progress").evaluate("(bar) => bar.value"))
        page.wait_for_timeout(50)
    expect(pause).to_be_focused()
    with page.expect_response(re.compile("/files$")):
        page.evaluate(LOOK)
    expect(pause).to_be_focused()
    expect(link).to_have_attribute("data-same", "yes")
    expect(page).to_have_title(re.compile(r"^\d+ % long – knitlab$"))
    # Strains are said once.
    assert page.get_by_text(re.compile("^Stretch 1")).inner_text().count("course") == 1


def test_a_running_test_is_followed(page: Page, service: str, done: str, rest: httpx.Client) -> None:
    frames = rest.get(f"/v1/jobs/{done}/frames").json()["frames"]
    widest = max(range(len(frames)), key=lambda k: frames[k]["strain"]["C"])
    kept = [frames[:3]]
    job = rest.get(f"/v1/jobs/{done}").json() | {"state": "running", "finished": None}
    page.route(f"**/jobs/{done}", lambda route: route.fulfill(json=job))
    page.route("**/events", lambda route: route.fulfill(status=204))
    page.route("**/frames", edited(lambda index: index.update(frames=kept[0])))
    page.goto(f"{service}/#/jobs/{done}")
    where, slider = page.locator("output"), page.locator("#frame")
    expect(where).to_contain_text(f"{frames[2]['time']:.1f} s")
    # What the test has come to since is shown, and stays on the stage.
    kept[0] = frames[: widest + 1]
    page.evaluate(LOOK)
    expect(where).to_contain_text(f"{frames[widest]['time']:.1f} s")
    expect(slider).to_have_value(str(widest))
    box = seen_yarn(page)
    assert box[0] > 0.02
    assert box[1] < 0.98
    # Who looks back is left there.
    slider.press("Home")
    expect(where).to_contain_text("0.0 s")
    kept[0] = frames
    page.evaluate(LOOK)
    expect(slider).to_have_attribute("max", str(len(frames) - 1))
    expect(slider).to_have_value("0")


def test_without_webgl_all_else_is_there(page: Page, service: str, done: str) -> None:
    page.add_init_script(
        "const get = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...more) {"
        "  return kind.startsWith('webgl') ? null : get.call(this, kind, ...more); };"
    )
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.get_by_text("this browser gives no WebGL")).to_be_visible()
    expect(page.get_by_text("course, cycles 1 to 2")).to_be_visible()
    expect(page.get_by_role("link", name="run/done.csv")).to_be_visible()
    expect(page.locator(".knit")).to_have_count(0)


def test_it_says_why_there_is_no_shape_and_no_curve(page: Page, service: str, done: str, rest: httpx.Client) -> None:
    record = {"kind": "not there"}

    def frames(route: Route) -> None:
        if record["kind"] == "not there":
            route.fulfill(status=409, content_type="application/problem+json", body='{"status": 409, "detail": "no"}')
        else:
            route.continue_()

    job = rest.get(f"/v1/jobs/{done}").json() | {"state": "running", "finished": None}
    page.route(f"**/jobs/{done}/frames", frames)
    page.route(f"**/jobs/{done}", lambda route: route.fulfill(json=job))
    page.route("**/events", lambda route: route.fulfill(status=204))
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.get_by_text("The record is being written, one moment.")).to_be_visible()
    expect(page.get_by_text("No row is recorded yet.")).to_be_visible()
    assert page.locator(".chart >> visible=true").count() == 0
    # It is looked for again sooner than all else.
    record["kind"] = "there"
    expect(page.locator(".knit")).to_be_visible(timeout=4000)
    record["kind"] = "not there"
    job |= {"state": "cancelled", "end": "cancelled", "finished": job["created"]}
    page.reload()
    expect(page.get_by_text("No shape was recorded.")).to_be_visible()
    expect(page.get_by_text("No row was recorded.")).to_be_visible()
    expect(page.get_by_text("Cancelled.", exact=True)).to_be_visible()
    # A job that was over when it was opened is no news.
    assert page.locator("#status").inner_text() == ""


def test_passing_a_limit_of_the_material_is_said_and_marked(page: Page, service: str, done: str) -> None:
    rows = [{"row": k, **row} for k, row in enumerate(wave(40, 1))]
    text = "strength of 29 MPa passed at 12 s, strain C 24.0 %: a fibre is strained by 4 %, limit 3.54 %"
    crossing = {"name": "strength", "limit": 0.0354, "row": 12, "time": 12.0, "strain": {"C": 0.24}}
    crossings = [{**crossing, "fibre_strain": 0.04, "text": text}]
    page.route(f"**/jobs/{done}", edited(lambda job: job["progress"].update(crossings=crossings)))
    serve_rows(page, rows)
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.get_by_text(f"Beyond strength: {text}.")).to_be_visible()
    marked = "beyond strength"
    drawn = curves(page, lambda found: sum(one["label"] == marked and len(one["data"]) == 1 for one in found) == 2)
    time, stress = (one["data"] for one in drawn if one["label"] == marked)
    # Row 12 of a wave that rises by 2 % a row to 40 %.
    assert time == [{"x": 12.0, "y": pytest.approx(0.24**2)}]
    assert stress[0]["x"] == pytest.approx(24.0)


def test_clasps_that_let_go_are_said(page: Page, service: str, done: str) -> None:
    text = "a clasp between layers let go at 12 s, strain P 24.0 %: 3 of 4 hold"
    loss = {"joined": "layers", "row": 12, "time": 12.0, "strain": {"P": 0.24}, "lost": 1, "held": 3, "mounted": 4}
    page.route(f"**/jobs/{done}", edited(lambda job: job["progress"].update(losses=[{**loss, "text": text}])))
    page.goto(f"{service}/#/jobs/{done}")
    expect(page.get_by_text(f"Let go: {text}.")).to_be_visible()
