"""Submit a sweep, watch it, read its table and plot, and lay its tests over each other."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect

from tests.service.console.hands import QUICK, contrast, curves, rgb, until, write

if TYPE_CHECKING:
    import httpx
    from playwright.sync_api import Page

SWEPT = (
    QUICK.replace("name: quick", "name: swept")
    .replace("loop: 8 mm", "loop: 8 mm, nodes_per_loop: 16")
    .replace("upper: 20 %", 'upper: "${peak}"')
    .replace("friction: 0.3", 'friction: "${mu}"')
    .replace("max_strain_increment: 0.05", "max_strain_increment: 0.05\nparams: {mu: 0.3, peak: 5 %}")
    .replace("steps:", "sweep: {mu: [0.1, 0.3], peak: [4 %, 5 %]}\nsteps:")
)
SECANT = "secant modulus to peak, C, cycle 1"


@pytest.fixture(scope="module")
def swept(rest: httpx.Client) -> str:
    """Return the id of a sweep of four tests that have ended."""
    sent = rest.post("/v1/sweeps?pictures=false", json={"protocol": SWEPT}).raise_for_status().json()
    for job in sent["jobs"]:
        until(rest, job["id"], {"succeeded"})
    return str(sent["sweep"])


def test_a_sweep_is_checked_as_one_types_and_submitted(page: Page, service: str, rest: httpx.Client) -> None:
    page.goto(f"{service}/#/new")
    # What is wrong with it is marked in its line.
    write(page, SWEPT.replace("sweep: {mu: [0.1, 0.3]", "sweep: {nu: [0.1, 0.3]"))
    expect(page.locator(".wrong")).to_contain_text("sweep.nu: found 'nu', allowed a name under params: mu, peak")
    write(page, SWEPT.replace("4 %", "4 kg"))
    expect(page.locator(".wrong")).to_contain_text("mu = 0.1, peak = '4 kg': line ")
    expect(page.locator(".cm-lintRange-error")).to_have_count(1)
    write(page, SWEPT)
    expect(page.get_by_text("This sweep is valid: 4 tests.")).to_be_visible()
    expect(page.locator("dt", has_text="Tests").locator("+ dd")).to_have_text("4")
    expect(page.locator("dt", has_text="Take on the rig").locator("+ dd")).to_have_text(re.compile(r"^\d+ s in all$"))
    expect(page.locator("dt", has_text="Files of the logs").locator("+ dd")).to_have_text(re.compile("[kM]B at most$"))
    expect(page.get_by_role("row", name="swept-4")).to_contain_text("5 %")
    page.get_by_label("Plots and pictures of every test").uncheck()
    page.get_by_role("button", name="Submit 4 tests").click()
    expect(page.get_by_role("heading", name="swept")).to_be_visible()
    sweep = page.url.rsplit("/", 1)[1]
    expect(page.get_by_text(re.compile(r"left.*; 4 in all"))).to_be_visible()
    page.get_by_role("button", name="Cancel what is left").click()
    expect(page.get_by_text(re.compile("cancelled; 4 in all"))).to_be_visible()
    expect(page.get_by_role("button", name="Delete the sweep")).to_be_visible()
    # The list says the same, and nothing of it is left once it is deleted.
    page.get_by_role("link", name="Sweeps").click()
    expect(page.locator(f"[data-sweep='{sweep}'] [role=img]")).to_have_attribute("aria-label", re.compile("4 in all"))
    page.locator(f"[data-sweep='{sweep}'] a").click()
    page.get_by_role("button", name="Delete the sweep").click()
    page.get_by_role("dialog", name="Delete 4 jobs?").get_by_role("button", name="Delete").click()
    expect(page.get_by_role("heading", name="Sweeps")).to_be_visible()
    expect(page.locator(f"[data-sweep='{sweep}']")).to_have_count(0)
    assert rest.get(f"/v1/sweeps/{sweep}").status_code == 404


def test_the_page_of_a_sweep_has_its_outcomes_and_a_plot(
    page: Page, service: str, rest: httpx.Client, swept: str
) -> None:
    table = rest.get(f"/v1/sweeps/{swept}").json()
    at = [one["name"] for one in table["figures"]].index(SECANT)
    page.goto(f"{service}/#/sweeps/{swept}")
    expect(page.get_by_text("4 done; 4 in all")).to_be_visible()
    expect(page.locator("tbody tr[data-job]")).to_have_count(4)
    expect(page.get_by_role("combobox", name="Figure")).to_have_value(SECANT)
    drawn = curves(page, lambda found: len(found) == 2)
    assert {one["label"] for one in drawn} == {"peak = 4 %", "peak = 5 %"}
    for one in drawn:
        peak = one["label"].removeprefix("peak = ")
        wanted = [(p["values"]["mu"], p["figures"][at]) for p in table["points"] if p["values"]["peak"] == peak]
        assert [dot["x"] for dot in one["data"]] == [mu for mu, _ in wanted]
        ratios = [dot["y"] / value for dot, (_, value) in zip(one["data"], wanted, strict=True)]
        assert ratios == pytest.approx([ratios[0]] * 2)
    page.get_by_role("combobox", name="Over").select_option("peak")
    curves(page, lambda found: {one["label"] for one in found} == {"mu = 0.1", "mu = 0.3"})
    # Another figure is a column once it is wanted; the file has all of them.
    page.get_by_text("Figures in the table").click()
    page.get_by_label("equilibria", exact=True).check()
    expect(page.get_by_role("columnheader", name="equilibria", exact=True)).to_be_visible()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save as CSV").click()
    head, *rows = saved.value.path().read_text().splitlines()
    assert len(rows) == 4
    assert "mu,peak,state,end," in head
    page.get_by_role("link", name="files and plots of swept-1").click()
    expect(page.get_by_role("heading", name="Files")).to_be_in_viewport()


def test_jobs_are_chosen_by_the_keyboard_and_laid_over_each_other(
    page: Page, service: str, rest: httpx.Client, swept: str
) -> None:
    jobs = [one["job"] for one in rest.get(f"/v1/sweeps/{swept}").json()["points"]][1::2]
    page.goto(f"{service}/#/?sweep={swept}")
    for job in jobs:
        page.get_by_label(f"choose {job['name']}").focus()
        page.keyboard.press("Space")
    expect(page.get_by_text("2 chosen")).to_be_visible()
    page.get_by_role("link", name="Compare").focus()
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile("#/compare/" + ",".join(job["id"] for job in jobs)))
    page.get_by_label("Axis").select_option("wale")
    page.get_by_label("Cycle").select_option("2")
    expect(page).to_have_url(re.compile(r"\?axis=W&cycle=2$"))
    # It says the same when the bookmark is opened, in either theme.
    page.reload()
    expect(page.get_by_label("Axis")).to_have_value("W")
    for theme in ("light", "dark"):
        page.get_by_label("Theme").select_option(theme)
        page.wait_for_timeout(100)
        drawn = curves(page, lambda found: len(found) == 2 and all(one["data"] for one in found))
        assert [one["label"] for one in drawn] == [job["name"] for job in jobs]
        for job, one in zip(jobs, drawn, strict=True):
            columns = rest.get(f"/v1/jobs/{job['id']}/curves").json()
            second = [k for k, cycle in enumerate(columns["cycle"]) if cycle == 2]
            assert [dot["x"] for dot in one["data"]][1:] == pytest.approx(
                [100 * columns["strain"]["W"][k] for k in second]
            )
        # None needs its colour to be told from the others, and each is seen on the paper.
        looks = page.evaluate(
            """async () => {
                const { Chart } = await import("/vendor/chart.js");
                const [{ data }] = Object.values(Chart.instances);
                return JSON.stringify(data.datasets.map((set) => [set.borderDash, set.pointStyle]));
            }"""
        )
        first, other = json.loads(looks)
        assert first[0] != other[0]
        assert first[1] != other[1]
        paper = page.evaluate("getComputedStyle(document.querySelector('section')).backgroundColor")
        assert min(contrast(rgb(one["colour"]), paper) for one in drawn) > 3.0
    # One that is not there leaves the other.
    page.goto(f"{service}/#/compare/{jobs[0]['id']},none")
    expect(page.get_by_role("row", name="none")).to_contain_text("it may have been deleted")
    curves(page, lambda found: any(one["data"] for one in found))
    page.get_by_role("button", name="take out none").click()
    expect(page.get_by_role("heading", name="Compare 1 job")).to_be_visible()
    expect(page.get_by_role("button", name=f"take out {jobs[0]['name']}")).to_be_focused()
