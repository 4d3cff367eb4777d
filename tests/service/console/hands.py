"""Do at the console what a person does, and see what a person sees."""

from __future__ import annotations

import json
import re
import time
from typing import TYPE_CHECKING, Any, Final

from tests.service.knitlab_serve import QUICK as FEW_ROWS

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    import httpx
    from playwright.sync_api import Page, Route

PATIENCE: Final = 120_000
"""Longest wait for anything [ms]."""

#: Two cycles with curves to look at.
QUICK: Final = FEW_ROWS.replace("upper: 5 %", "upper: 20 %").replace("n: 1", "n: 2, tag: twice")
LONG: Final = QUICK.replace("name: quick", "name: long").replace("[2, 2]", "[4, 4]").replace("0.05", "0.0005")


def submit(rest: httpx.Client, protocol: str) -> str:
    """Return the id of a new job."""
    kind = {"Content-Type": "application/yaml"}
    answer = rest.post("/v1/jobs", params={"pictures": False}, content=protocol, headers=kind)
    return str(answer.raise_for_status().json()["id"])


def until(rest: httpx.Client, job: str, states: Collection[str]) -> None:
    """Wait for a job to come into one of some states."""
    for _ in range(PATIENCE // 100):
        if rest.get(f"/v1/jobs/{job}").json()["state"] in states:
            return
        time.sleep(0.1)
    raise TimeoutError(f"job {job} is not {states}")


def write(page: Page, text: str, editor: str = ".cm-content >> nth=0") -> None:
    """Replace what stands in an editor, by the keyboard."""
    page.locator(editor).click()
    page.keyboard.press("Control+A")
    page.keyboard.insert_text(text)


def edited(change: Callable[[Any], None]) -> Callable[[Route], None]:
    """Return what lets an answer of the service through with its JSON changed."""

    def pass_on(route: Route) -> None:
        answer = route.fetch()
        body = answer.json()
        change(body)
        route.fulfill(response=answer, json=body)

    return pass_on


def painted(page: Page) -> list[tuple[int, int, int]]:
    """Return the different colours of the picture of the knit, those of most dots first."""
    script = """() => {
        const source = document.querySelector(".knit canvas"), copy = document.createElement("canvas");
        [copy.width, copy.height] = [source.width, source.height];
        const brush = copy.getContext("2d");
        brush.drawImage(source, 0, 0);
        const dots = brush.getImageData(0, 0, copy.width, copy.height).data, seen = new Map();
        for (let k = 0; k < dots.length; k += 4) {
            const colour = `${dots[k]},${dots[k + 1]},${dots[k + 2]}`;
            seen.set(colour, (seen.get(colour) ?? 0) + 1);
        }
        return [...seen].sort((a, b) => b[1] - a[1]).map(([colour]) => colour);
    }"""
    return [colour_of(text) for text in page.evaluate(script)]


def seen_yarn(page: Page) -> tuple[float, float]:
    """Return between which shares of the height of the stage the yarn is seen."""
    script = """() => {
        const source = document.querySelector(".knit canvas"), copy = document.createElement("canvas");
        const { width, height } = Object.assign(copy, { width: source.width, height: source.height });
        const brush = copy.getContext("2d");
        brush.drawImage(source, 0, 0);
        const dots = new Uint32Array(brush.getImageData(0, 0, width, height).data.buffer);
        const rows = Array.from({ length: height }, (_, row) => row).filter((row) =>
            dots.subarray(row * width, (row + 1) * width).some((dot) => dot !== dots[0]));
        return [rows[0] / height, rows.at(-1) / height];
    }"""
    low, high = page.evaluate(script)
    return float(low), float(high)


def curves(page: Page, ready: Callable[[list[dict[str, Any]]], bool]) -> list[dict[str, Any]]:
    """Return the curves of both charts that are drawn, once they are ready: label, dots and look of each."""
    script = """async () => {
        const { Chart } = await import("/vendor/chart.js");
        const sets = Object.values(Chart.instances).flatMap((chart) => chart.data.datasets);
        return JSON.stringify(sets.filter((set) => set.borderColor && !set.hidden).map((set) => ({
            label: set.label, data: set.data, colour: set.borderColor, width: set.borderWidth, order: set.order,
        })));
    }"""
    for _ in range(PATIENCE // 1000):
        found: list[dict[str, Any]] = json.loads(page.evaluate(script))
        if ready(found):
            return found
        page.wait_for_timeout(100)
    raise TimeoutError(str([one["label"] for one in found]))


def colour_of(text: str) -> tuple[int, int, int]:
    """Return the parts of a CSS colour, 0 to 255."""
    red, green, blue = (int(part) for part in re.findall(r"\d+", text)[:3])
    return red, green, blue


def luminance(text: str) -> float:
    """Return the relative luminance of a CSS colour (WCAG 2.2)."""
    parts = [part / 255 for part in colour_of(text)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    """Return the contrast of two CSS colours (WCAG 2.2)."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def rgb(colour: str) -> str:
    """Return a CSS colour as its three numbers, 0 to 255."""
    code = colour.lstrip("#")
    return ", ".join(str(int(code[k : k + 2], 16)) for k in (0, 2, 4))
