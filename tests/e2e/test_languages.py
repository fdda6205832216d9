"""The pages in German: all texts are translated, only one catalogue is loaded, and browser and user choose the language."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import expect

from harness import TestStack
from person import PASSWORD, Person
from picture import wait_for_samples
from test_every_page import faults

#: Bytes that the edge sends to a visitor before a picture. The DICOM scanner is only loaded when files are chosen.
MOST_BYTES = 300_000
SENT = """() => [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")]
    .filter((r) => !r.name.includes("/v1/") && !r.name.startsWith("blob:")).map((r) => [new URL(r.name).pathname, r.transferSize])"""
#: Runs in the page: controls of the slices that overlap, leave the window, or cut off their text.
CROWDED = """() => {
    const name = (e) => (e.getAttribute("aria-label") ?? e.textContent).slice(0, 30);
    const all = [...document.querySelectorAll(".slice-bar :is(label > span, label:has(> input:not([type=radio], [type=checkbox])), select, button, input[type=range])")]
        .filter((e) => e.getClientRects().length > 0);
    const boxes = all.map((e) => [e, e.getBoundingClientRect()]);
    const wrong = boxes.filter(([e, box]) => box.left < 0 || box.right > innerWidth || e.scrollWidth > e.clientWidth + 1 && e.matches("span, label, button")).map(([e]) => `clipped: ${name(e)}`);
    for (const [i, [a, one]] of boxes.entries()) for (const [b, other] of boxes.slice(0, i))
        if (!a.contains(b) && !b.contains(a) && one.left < other.right - 1 && other.left < one.right - 1 && one.top < other.bottom - 1 && other.top < one.bottom - 1)
            wrong.push(`overlap: ${name(a)} / ${name(b)}`);
    const select = document.querySelector(".slice-bar select");
    if (select) {
        const pen = new OffscreenCanvas(1, 1).getContext("2d");
        const style = getComputedStyle(select);
        pen.font = style.font;
        const room = select.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
        for (const { text } of select.options) if (pen.measureText(text).width > room) wrong.push(`clipped: ${text}`);
    }
    return all.length < 12 ? [`only ${all.length} controls`] : wrong;
}"""


def test_sign_up_and_viewing_work_in_german(stack: TestStack, visit, cranium: Path, pictures: Path):
    owner = Person.arrives(stack, visit(small=True), "gerda")
    scan = owner.has_scan(cranium, "Kopf")

    page = visit(phone=True, locale="de-AT")
    page.goto(stack.url + "/sign-up")
    expect(page.get_by_role("heading", name="Konto erstellen")).to_be_visible()
    assert page.evaluate("document.documentElement.lang") == "de"
    expect(page).to_have_title("Konto erstellen · Diaphane")
    assert faults(page) == []
    page.screenshot(path=pictures / "sign-up-german.png")
    page.get_by_label("E-Mail-Adresse").fill("keine")
    page.get_by_role("button", name="Konto erstellen").click()
    expect(page.get_by_text("Geben Sie eine E-Mail-Adresse im Format name@example.com ein.")).to_be_visible()
    page.get_by_label("Ich willige ein").check()
    page.get_by_label("E-Mail-Adresse").fill(f"zweite-{owner.email}")
    page.get_by_role("button", name="Konto erstellen").click()
    expect(page.get_by_role("heading", name="Prüfen Sie Ihr Postfach")).to_be_visible()

    page.goto(stack.url + "/sign-in")
    page.get_by_label("E-Mail-Adresse").fill(owner.email)
    page.get_by_label("Passwort", exact=True).fill(PASSWORD)
    page.get_by_role("button", name="Anmelden").click()
    expect(page.get_by_role("heading", name="Meine Aufnahmen")).to_be_visible()
    assert faults(page) == []
    page.screenshot(path=pictures / "scans-german.png")

    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 1)
    expect(page.get_by_role("button", name="Haut")).to_be_visible()
    assert faults(page) == []
    page.screenshot(path=pictures / "viewer-german.png")
    sent = page.evaluate(SENT)
    catalogues = [path for path, _ in sent if re.search(r"/(en|de)-[\w-]+\.js$", path)]
    assert len(catalogues) == 1 and "/de-" in catalogues[0], sent
    page.get_by_role("button", name="Qualität anzeigen").click()
    page.screenshot(path=pictures / "viewer-german-quality.png")
    page.locator(".quality-head button").click()
    page.locator(".stage > canvas").press("v")
    page.get_by_role("checkbox", name="Farben").check()  # with the slider of their strength
    expect(page.locator(".slice-pane canvas[data-came=true]")).to_have_count(1)
    page.screenshot(path=pictures / "slices-german.png")
    assert page.evaluate(CROWDED) == []


def test_the_chosen_language_is_kept_and_only_its_texts_are_loaded(stack: TestStack, visit):
    page = visit()
    page.goto(stack.url + "/sign-in")
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    sent = page.evaluate(SENT)
    assert 20_000 < sum(size for _, size in sent) <= MOST_BYTES, sent
    assert not any("/de-" in path or "scan_worker" in path for path, _ in sent), sent

    page.get_by_label("Email address").fill("half@example.org")
    page.get_by_label("Language").select_option("de")
    expect(page.get_by_role("heading", name="Anmelden")).to_be_visible()
    assert page.evaluate("document.documentElement.lang") == "de"
    assert faults(page) == []
    page.reload()
    expect(page.get_by_role("heading", name="Anmelden")).to_be_visible()
    page.get_by_label("Sprache").select_option("en")
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()

    # A browser without storage shows the page in its own language.
    bare = visit(locale="de-DE")
    bare.add_init_script("""const { getItem } = Storage.prototype;
        Storage.prototype.getItem = function (name) { if (name === "diaphane.language") throw new DOMException("no", "SecurityError"); return getItem.call(this, name); };""")
    bare.goto(stack.url + "/sign-in")
    expect(bare.get_by_role("heading", name="Anmelden")).to_be_visible()
