"""One person shares a scan: with everybody, and by a link. Another finds it in the gallery and saves a preset."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import expect

from harness import TestStack
from person import Person
from picture import facts


def look_through_reports(stack: TestStack, page, pictures: Path) -> Person:
    """As an administrator, who finds nothing wrong; gives him."""
    boss = Person.arrives(stack, page, "boss")
    page.goto(stack.url + "/reports")
    expect(page.get_by_text("Only an administrator may do this.")).to_be_visible()
    boss.becomes_administrator()
    page.reload()
    expect(page.get_by_text("I only try this.")).to_be_visible()
    page.screenshot(path=pictures / "reports.png")
    page.get_by_role("button", name="Nothing is wrong with A head to share").click()
    expect(page.get_by_text("Nothing to do.")).to_be_visible()
    return boss


def preset_is_reported_and_taken_down(author: Person, reader: Person, boss: Person, scan: str, name: str, pictures: Path) -> None:
    """Who reads it says what is wrong, an administrator looks and says why it goes, its author is told; nobody else sees it again."""
    reader.page.goto(f"{reader.stack.url}/view/{scan}")
    reader.page.get_by_role("button", name="Saved presets").click()
    reader.page.get_by_role("button", name=f"Report {name}").click()
    dialog = reader.page.get_by_role("dialog", name=f"What is wrong with {name}?")
    dialog.get_by_label("In your own words").fill("Its name is a person's.")
    dialog.get_by_role("button", name="Report", exact=True).click()
    expect(dialog.get_by_text("An administrator will look at it.")).to_be_visible()
    reader.page.keyboard.press("Escape")

    boss.page.goto(f"{boss.stack.url}/reports")
    expect(boss.page.get_by_text("Its name is a person's.")).to_be_visible()
    expect(boss.page.get_by_text(name)).to_be_visible()
    boss.page.get_by_role("button", name=f"Take down {name}").click()
    dialog = boss.page.get_by_role("dialog")
    dialog.get_by_label("Reason").fill("No names of people.")
    boss.page.screenshot(path=pictures / "take-down-preset.png")
    dialog.get_by_role("button", name="Take down", exact=True).click()
    expect(boss.page.get_by_role("button", name=f"Take down {name}")).not_to_be_visible()

    author.page.goto(f"{author.stack.url}/view/{scan}")
    author.page.get_by_role("button", name="Saved presets").click()
    expect(author.page.get_by_text("The reason: No names of people.")).to_be_visible()
    author.page.screenshot(path=pictures / "preset-taken-down.png")
    reader.page.reload()
    reader.page.get_by_role("button", name="Saved presets").click()
    expect(reader.page.get_by_text("No presets yet")).to_be_visible()
    reader.page.close()


def test_a_scan_is_published_found_and_looked_at_with_a_preset_of_ones_own(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna = Person.arrives(stack, visit(small=True), "anna")
    scan = anna.has_scan(cranium, "A head to share")
    anna.open_scan("A head to share")

    # Not before it was made anonymous (tests/integration/test_anonymise_job.py).
    anna.page.get_by_role("button", name="Share this scan").click()
    dialog = anna.page.get_by_role("dialog")
    expect(dialog.get_by_text("First cut away")).to_be_visible()
    anna.page.keyboard.press("Escape")
    stack.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", scan)
    anna.page.reload()

    anna.page.get_by_role("button", name="Share this scan").click()
    dialog.get_by_label("Description").fill("Seen from all sides.")
    dialog.get_by_label("Part of the body").select_option("head")
    dialog.get_by_role("button", name="Save", exact=True).click()
    expect(dialog.get_by_text("Saved.")).to_be_visible()
    dialog.get_by_label("Your public name").fill("Anna of the hills")
    dialog.get_by_role("button", name="Put it into the gallery").click()
    expect(dialog.get_by_text("It is in the gallery.")).to_be_visible()
    dialog.get_by_role("button", name="Make a link").click()
    link = dialog.get_by_label("The new link").input_value()
    assert link.startswith(f"{stack.url}/shared#")
    dialog.get_by_label("E-mail address").fill("friend@example.org")
    dialog.get_by_role("button", name="Share", exact=True).click()
    expect(dialog.get_by_text("Shared with friend@example.org.")).to_be_visible()
    anna.page.screenshot(path=pictures / "share.png")
    dialog.get_by_role("button", name="Close").click()

    # Somebody without an account looks by the link.
    guest = visit(small=True)
    guest.goto(link)
    expect(guest.get_by_role("heading", name="A head to share")).to_be_visible()
    guest.screenshot(path=pictures / "shared-link.png")
    guest.get_by_role("button", name="Look at it").click()
    expect(guest.locator("canvas[data-samples]")).to_be_visible()
    expect(guest.get_by_role("button", name="Show the slices (V)")).to_have_count(0)

    # Somebody else finds it, and keeps how it looked best.
    bert = Person.arrives(stack, visit(small=True), "bert")
    bert.page.get_by_role("link", name="Gallery").click()
    bert.page.get_by_label("Words of the title").fill("head sha")
    bert.page.get_by_label("Part of the body").select_option("head")
    card = bert.page.locator(f"article[data-id='{scan}']")
    expect(card.get_by_text("by Anna of the hills")).to_be_visible()
    assert anna.email not in bert.page.content()
    bert.page.screenshot(path=pictures / "gallery.png")
    bert.page.get_by_role("button", name="Report A head to share").click()
    bert.page.get_by_label("In your own words").fill("I only try this.")
    bert.page.get_by_role("dialog").get_by_role("button", name="Report").click()
    expect(bert.page.get_by_text("An administrator will look at it.")).to_be_visible()
    bert.page.keyboard.press("Escape")
    boss = look_through_reports(stack, visit(small=True), pictures)
    bert.page.get_by_role("link", name="Look at A head to share").click()
    expect(bert.page.locator("canvas[data-samples]")).to_be_visible()
    bert.page.locator("[data-preset=muscle]").click()
    bert.page.get_by_role("button", name="Saved presets").click()
    dialog = bert.page.get_by_role("dialog")
    expect(dialog.get_by_text("No presets yet")).to_be_visible()
    dialog.get_by_label("Name of the new preset").fill("Best of it")
    dialog.get_by_role("button", name="Save the picture as it is now").click()
    expect(dialog.get_by_role("button", name="Show Best of it")).to_be_visible()
    with bert.page.expect_download() as download:
        dialog.get_by_role("link", name="Download Best of it as a file").click()
    xml = Path(download.value.path())
    assert b'<preset xmlns="urn:diaphane:preset" version="1" name="Best of it">' in xml.read_bytes()
    dialog.get_by_label("Open a preset file").set_input_files({"name": "x.xml", "mimeType": "application/xml", "buffer": xml.read_bytes().replace(b"Best of it", b"From a file")})
    expect(dialog.get_by_role("button", name="Show From a file")).to_be_visible()
    dialog.get_by_role("button", name="Delete From a file").click()
    dialog.get_by_role("button", name="Delete", exact=True).click()
    expect(dialog.get_by_role("button", name="Show From a file")).not_to_be_visible()
    bert.page.screenshot(path=pictures / "presets.png")

    # Its owner sees it, finds it good, and opens the scan with it from now on.
    anna.page.get_by_role("button", name="Saved presets").click()
    dialog = anna.page.get_by_role("dialog")
    dialog.get_by_role("button", name="Best of it is good", exact=True).click()
    expect(dialog.get_by_text("1 vote")).to_be_visible()
    before = facts(anna.page)
    dialog.get_by_role("button", name="Show Best of it").click()
    expect(anna.page.locator(f"canvas[data-input-seq='{before.input_seq + 1}']")).to_be_visible()
    dialog.get_by_role("button", name="Open with this: Best of it").click()
    expect(dialog.get_by_text("Opens with this")).to_be_visible()
    dialog.get_by_role("button", name="Close").click()

    # Whoever opens it now sees it so.
    again = bert.page.context.new_page()
    again.goto(f"{stack.url}/view/{scan}")
    expect(again.locator("[data-preset=muscle][aria-pressed=true]")).to_be_visible()
    again.close()
    late = visit(small=True)
    late.goto(link)
    late.get_by_role("button", name="Look at it").click()
    expect(late.locator("canvas[data-input-seq='0']")).to_be_visible(timeout=60_000)
    expect(late.locator("[data-preset=muscle][aria-pressed=true]")).to_be_visible()
    late.close()

    # Each preset has its picture: in the list, and for everybody in the gallery, from where it opens.
    anna.page.get_by_role("button", name="Saved presets").click()
    shown = "The scan as Best of it shows it"
    expect(anna.page.get_by_role("dialog").get_by_role("img", name=shown)).to_be_visible(timeout=180_000)
    anna.page.screenshot(path=pictures / "presets-pictured.png")
    anna.page.get_by_role("dialog").get_by_role("button", name="Close").click()
    again = bert.page.context.new_page()
    again.goto(f"{stack.url}/gallery")
    crowd = again.locator(f"article[data-id='{scan}']").get_by_role("list", name="How people look at it")
    crowd.scroll_into_view_if_needed(timeout=60_000)  # a picture is asked for once it is in sight
    expect(crowd.locator(f"img[alt='{shown}']")).to_be_visible(timeout=60_000)
    again.screenshot(path=pictures / "gallery-crowd.png")
    crowd.get_by_role("link", name="Show Best of it").click()
    expect(again.locator("[data-preset=muscle][aria-pressed=true]")).to_be_visible(timeout=60_000)
    again.close()

    preset_is_reported_and_taken_down(bert, Person.arrives(stack, visit(small=True), "cara"), boss, scan, "Best of it", pictures)
    expect(bert.page.locator("canvas[data-samples]")).to_be_visible()

    # Taken back, everybody else is sent away at once.
    anna.page.get_by_role("button", name="Share this scan").click()
    dialog = anna.page.get_by_role("dialog")
    dialog.get_by_role("button", name="Take it out of the gallery").click()
    expect(dialog.get_by_text("It is not in the gallery.")).to_be_visible()
    dialog.get_by_role("button", name="End the link").first.click()
    expect(dialog.get_by_text("Ended. Who came by it has left.")).to_be_visible()
    expect(bert.page.get_by_text("There is no such scan, or it belongs to somebody else.")).to_be_visible()
    expect(guest.get_by_text("This link was ended")).to_be_visible()
    expect(anna.page.locator("canvas[data-samples]")).to_be_visible()

    # A sample is looked at before one has an account.
    stack.psql("UPDATE data_sets SET is_sample = true, visibility = 'public', published_at = now() WHERE id = %s", scan)
    nobody = visit(small=True)
    nobody.goto(stack.url)
    nobody.get_by_role("link", name="Gallery").click()
    nobody.get_by_role("link", name="Look at A head to share").click()
    nobody.get_by_role("button", name="Look at it").click()
    expect(nobody.locator("canvas[data-samples]")).to_be_visible()
    expect(nobody.get_by_role("button", name="Show the slices (V)")).to_be_visible()  # a sample is everybody's
    stack.psql("DELETE FROM data_sets WHERE id = %s", scan)  # not for the tests that come after
