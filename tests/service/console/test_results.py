"""Take a job's report, and lay a measured file over its test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect

from tests.service.console.hands import contrast, curves, rgb

if TYPE_CHECKING:
    import httpx
    from playwright.sync_api import Page


@pytest.fixture(scope="module")
def log(rest: httpx.Client, done: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Take the log of a job as the file that an instrument wrote."""
    path = tmp_path_factory.mktemp("measured") / "fabric <b>.csv"
    path.write_bytes(rest.get(f"/v1/jobs/{done}/log?dialect=biotester").raise_for_status().content)
    return path


def test_a_measured_file_lies_over_the_test_in_both_themes(page: Page, service: str, done: str, log: Path) -> None:
    page.goto(f"{service}/#/jobs/{done}")
    section = page.locator("section", has=page.get_by_role("heading", name="Compare with a measured file"))
    section.get_by_label("File").set_input_files(log)
    section.get_by_label("Axis").select_option("course")
    section.get_by_role("button", name="Compare").click()
    expect(section.get_by_role("row", name="NRMSE")).to_be_visible()
    # Its own log is within the noise of the stage; names of files are text.
    score = section.get_by_role("row", name="NRMSE").get_by_role("cell").last.inner_text()
    assert 0.0 <= float(score.removesuffix(" %")) < 20.0
    expect(section.get_by_role("columnheader", name="fabric <b>.csv")).to_be_visible()
    expect(section.get_by_role("row", name="Loop area")).to_be_visible()

    def looks() -> dict[str, str]:
        drawn = curves(page, lambda found: any("fabric <b>.csv" in one["label"] for one in found))
        return {one["label"]: one["colour"] for one in drawn if ", " in one["label"] and "cycle" not in one["label"]}

    seen = {}
    for theme in ("light", "dark"):
        page.get_by_label("Theme").select_option(theme)
        page.wait_for_timeout(100)
        seen[theme] = looks()
        paper = page.evaluate("getComputedStyle(document.querySelector('section')).backgroundColor")
        assert set(seen[theme]) == {
            f"{name}, {part}" for name in ("fabric <b>.csv", "done") for part in ("loading", "unloading")
        }
        for colour in seen[theme].values():
            assert contrast(rgb(colour), paper) > 3.0
    assert seen["light"] != seen["dark"]
    # A second file takes the place of the first, one that is no table that of both, with its line.
    section.get_by_label("Gauge length").fill("nothing")
    section.get_by_role("button", name="Compare").click()
    expect(section.get_by_role("alert")).to_contain_text("Gauge length: found nothing")
    section.get_by_label("Gauge length").fill("")
    section.get_by_label("File").set_input_files(Path(__file__))
    section.get_by_role("button", name="Compare").click()
    expect(section.get_by_role("alert")).to_contain_text("test_results.py, line")
    expect(section.get_by_role("row", name="NRMSE")).to_have_count(0)
    # What it lacks is said as the page can give it: there are no options of a command here.
    section.get_by_label("Axis").select_option("all")
    rows = "0,0,0\n1,1,1\n2,2,2\n"
    lacking = {
        f"Time [s],Load,Extension [mm]\n{rows}": "line 1: column 2 (Load) has no unit; write it into the heading",
        "0,0\n1,1\n2,2\n": "line 1: no headings are known; give the file a first line such as Time [s]",
        f"Time [s],Load [N],Extension [mm]\n{rows}": "Axis: found none, allowed that of f.csv: one of course, wale",
    }
    for content, words in lacking.items():
        section.get_by_label("File").set_input_files(
            {"name": "f.csv", "mimeType": "text/csv", "buffer": content.encode()}
        )
        section.get_by_role("button", name="Compare").click()
        expect(section.get_by_role("alert")).to_contain_text(words)
        assert "--" not in section.get_by_role("alert").inner_text()


@pytest.mark.slow
def test_the_report_of_a_job_is_saved(page: Page, service: str, done: str) -> None:
    page.goto(f"{service}/#/jobs/{done}")
    with page.expect_download() as saved:
        page.get_by_role("button", name="Report", exact=True).click()
    assert saved.value.suggested_filename == "done_report.html"
    text = Path(saved.value.path()).read_text(encoding="utf-8")
    assert "carried out to its end" in text
    assert "<h2>Protocol, as written</h2>" in text
    # It can be read in the page too, where it may do nothing.
    page.get_by_role("button", name="Read the report here").click()
    expect(page.get_by_role("progressbar", name="Making the report")).to_be_visible()
    expect(page.frame_locator("iframe").get_by_role("heading", name="Protocol, as written")).to_be_visible()
    assert page.locator("iframe").get_attribute("sandbox") == ""
    page.get_by_role("button", name="Close the report").click()
    expect(page.locator("iframe")).to_have_count(0)
