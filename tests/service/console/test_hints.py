"""The editor completes and explains: what it offers and says comes from the schema that the service publishes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from playwright.sync_api import expect

from tests.service.console.hands import contrast, write

if TYPE_CHECKING:
    from playwright.sync_api import Page

HEAD = "schema: knitlab/protocol@1\nrig: biaxial-hook\n"
OPTIONS = ".cm-tooltip-autocomplete [role=option]"
#: Texts with the cursor at |, and what is offered there: all of it, or (after ...) some of it.
PLACES: list[tuple[str, list[str]]] = [
    ("rig: |", ["...", "biaxial-hook", "uniaxial-frame", "triaxial", "sem-microgripper"]),
    ("specimen:\n  knit: seed\n  |\nsteps: []", ["...", "loops", "loop", "material"]),
    ("specimen: {knit: |", ["...", "rib-1x1", "garter", "seed"]),
    ("specimen: {knit: {centreline: a.csv, |}}", ["unit", "fibre_radius"]),
    ("steps:\n  - |", ["...", "zero", "ramp", "cycle", "repeat"]),
    ("steps:\n  - ramp: {axes: [C, |]}", ["...", "C", "W", "P"]),
    ("steps:\n  - ramp:\n      axes:\n        - |", ["...", "C", "W", "P"]),
    ("steps:\n  - repeat: {n: 2, steps: [ramp: {to: {|}}]}", ["strain", "displacement", "force"]),
    ("specimen: {rupture: go |", ["off", "stop", "go on"]),
    ("log: {noise: |}", ["on", "off"]),
    ("log: {rate: 10 |}", ["Hz", "kHz"]),
    ("# rig: |", []),
    ('name: "|"', []),
    ("log: {rate: 10 Hz}|", []),
    ("specimen:\n  knit:\n    centreline: |\n      x [mm], |\n", []),
]


def offered(page: Page, text: str) -> list[str]:
    """Return what the modules of the console offer at the last | of a text."""
    script = """async ({ text, pos }) => {
        const { placeAt } = await import("/place.js");
        const { fieldsAt, schemasAt, unitsOf, valuesOf } = await import("/schema.js");
        const root = window.root ??= await (await fetch("/v1/schemas/protocol")).json();
        const place = placeAt(text, pos);
        if (!place) return [];
        const schemas = schemasAt(root, place.levels);
        const fields = place.kind === "key" ? fieldsAt(root, place.levels, place.siblings).map(({ name }) => name) : [];
        if (/^\\d+ /.test(text.slice(place.from))) return unitsOf(schemas, root);
        return place.kind === "value" || place.alone ? [...fields, ...valuesOf(schemas, root)] : fields;
    }"""
    before, _, after = text.rpartition("|")
    found: Any = page.evaluate(script, {"text": before + after, "pos": len(before)})
    return [str(one) for one in found]


def test_what_may_stand_at_a_place_is_what_the_schema_allows_there(page: Page, service: str) -> None:
    page.goto(service)
    for text, wanted in PLACES:
        found = offered(page, text)
        assert (set(wanted[1:]) <= set(found)) if wanted[:1] == ["..."] else found == wanted, text


def test_keys_and_values_are_completed_by_the_keyboard(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    expect(page.locator(".right")).to_be_visible()
    write(page, f"{HEAD}specimen:\n  ")
    page.keyboard.type("kn")
    expect(page.locator(OPTIONS).first).to_contain_text("knit")
    expect(page.locator(".cm-completionInfo")).to_contain_text("rib-1x1")
    page.wait_for_timeout(100)  # a list that has just opened takes no Enter
    page.keyboard.press("Enter")
    # A key that has words is followed by them.
    expect(page.locator(OPTIONS).first).to_have_text("stockinette-default")
    page.keyboard.type("seed")
    expect(page.locator(OPTIONS).first).to_have_text("seed")
    page.wait_for_timeout(100)
    page.keyboard.press("Enter")
    expect(page.locator(".cm-line").nth(3)).to_have_text("  knit: seed")
    # Tab is not caught: the list closes, and the focus moves on.
    page.keyboard.press("Enter")
    page.keyboard.press("Control+Space")
    expect(page.locator(OPTIONS).first).to_be_visible()
    page.keyboard.press("Tab")
    expect(page.locator(OPTIONS)).to_have_count(0)
    assert page.evaluate("() => !document.activeElement.closest('.cm-content')")


def test_a_key_is_explained_to_pointer_and_keyboard(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    write(page, f"{HEAD}log: {{rate: 10 Hz}}")
    help_box = page.locator(".explained")
    page.locator(".cm-line").nth(2).get_by_text("log", exact=True).hover()
    expect(help_box).to_contain_text("log: how the instruments sample")
    page.mouse.move(0, 0)
    expect(help_box).to_have_count(0)
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("F1")
    for words in ("rate: rate of the step, or of the samples", "such as 10 Hz", "Hz, kHz", "Default"):
        expect(help_box).to_contain_text(words)
    page.keyboard.press("Escape")
    expect(help_box).to_have_count(0)
    page.keyboard.type(", ")
    expect(page.locator(OPTIONS).first).to_have_text("events")
    expect(page.locator(".cm-completionInfo")).to_be_visible()
    script = """(theme) => {
        document.documentElement.dataset.theme = theme;
        return [".cm-tooltip-autocomplete li[aria-selected]", ".cm-completionInfo"].map((name) => {
            const { color, backgroundColor } = getComputedStyle(document.querySelector(name));
            return [color, backgroundColor];
        });
    }"""
    for theme in ("light", "dark"):
        assert min(contrast(*pair) for pair in page.evaluate(script, theme)) >= 4.5, theme


def test_words_of_ones_own_materials_are_offered(page: Page, service: str) -> None:
    page.goto(f"{service}/#/new")
    page.get_by_text("Materials", exact=True).click()
    write(page, "schema: knitlab/materials@1\nmaterials:\n  my-resin:\n    ", ".cm-content >> nth=1")
    page.keyboard.type("yo")
    expect(page.locator(OPTIONS).first).to_contain_text("young_modulus")
    page.keyboard.press("Escape")
    write(page, f"{HEAD}specimen: {{material: my")
    page.keyboard.type("-")
    expect(page.locator(OPTIONS).first).to_have_text("my-resin")
