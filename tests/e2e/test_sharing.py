"""A user shares a scan publicly and by a link. Another user finds it in the gallery and saves a preset."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import expect

from harness import TestStack
from person import Person
from picture import facts


def look_through_reports(stack: TestStack, page, pictures: Path) -> Person:
    """Reviews reports as an administrator, who finds no violation. Returns the administrator."""
    boss = Person.arrives(stack, page, "boss")
    page.goto(stack.url + "/reports")
    expect(page.get_by_text("Only administrators can do this.")).to_be_visible()
    boss.becomes_administrator()
    page.goto(stack.url + "/admin")
    page.screenshot(path=pictures / "admin-open-reports.png")
    page.get_by_role("link", name="Reports (1 open report)", exact=True).click()
    expect(page.get_by_text("I only try this.")).to_be_visible()
    page.screenshot(path=pictures / "reports.png")
    page.get_by_role("button", name="Dismiss the report about A head to share").click()
    expect(page.get_by_text("No open reports.")).to_be_visible()
    expect(page.get_by_role("link", name="Reports", exact=True)).to_be_visible()
    return boss


def preset_is_reported_and_taken_down(author: Person, reader: Person, boss: Person, scan: str, name: str, pictures: Path) -> None:
    """A reader reports a preset, an administrator takes it down with a reason, its author is notified, and nobody else sees it
    again."""
    reader.page.goto(f"{reader.stack.url}/view/{scan}")
    reader.page.get_by_role("button", name="Saved presets").click()
    reader.page.get_by_role("button", name=f"Report {name}").click()
    dialog = reader.page.get_by_role("dialog", name=f"What is wrong with {name}?")
    dialog.get_by_label("More details").fill("Its name is a person's.")
    dialog.get_by_role("button", name="Send report").click()
    expect(reader.page.get_by_role("dialog", name="Report sent").get_by_text("An administrator will review your report.")).to_be_visible()
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
    expect(author.page.get_by_text("Reason: No names of people.")).to_be_visible()
    author.page.screenshot(path=pictures / "preset-taken-down.png")
    reader.page.reload()
    reader.page.get_by_role("button", name="Saved presets").click()
    expect(reader.page.get_by_text("There are no presets yet")).to_be_visible()

    # The administrator changes their mind, and readers see the preset again.
    hidden = boss.page.get_by_role("list", name="Taken down").get_by_role("listitem").filter(has_text=name)
    expect(hidden).to_contain_text("No names of people.")
    hidden.get_by_role("button", name=f"Restore {name}").click()
    boss.page.screenshot(path=pictures / "restore-preset.png")
    boss.page.get_by_role("dialog").get_by_role("button", name="Restore", exact=True).click()
    expect(boss.page.get_by_text("Nothing is taken down.")).to_be_visible()
    reader.page.reload()
    reader.page.get_by_role("button", name="Saved presets").click()
    expect(reader.page.get_by_text(name)).to_be_visible()
    reader.page.close()


def test_a_published_scan_is_found_and_viewed_with_a_saved_preset(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna = Person.arrives(stack, visit(small=True), "anna")
    scan = anna.has_scan(cranium, "A head to share")
    anna.open_scan("A head to share")

    # Not before it is anonymised (tests/integration/test_anonymise_job.py).
    anna.page.get_by_role("button", name="Share this scan").click()
    dialog = anna.page.get_by_role("dialog")
    expect(dialog.get_by_text("First cut away")).to_be_visible()
    anna.page.keyboard.press("Escape")
    stack.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", scan)
    anna.page.reload()

    anna.page.get_by_role("button", name="Share this scan").click()
    # Each choice says what else others see.
    for section, sees in (("Share with specific people", "the title and the description of the scan, the names of its presets, and the marks that you share"),
                          ("Share by link", "its title and the marks that you share"), ("Share with everyone", "its title, its description, the names of its presets, and the marks that you share")):
        expect(dialog.get_by_role("region", name=section).get_by_text(f"They also see {sees}.")).to_be_visible()
    dialog.get_by_label("Description").fill("Seen from all sides.")
    dialog.get_by_label("Body part").select_option("head")
    dialog.get_by_role("button", name="Save", exact=True).click()
    expect(dialog.get_by_text("Saved.")).to_be_visible()
    dialog.get_by_label("Your public name").fill("Anna of the hills")
    dialog.get_by_role("button", name="Add to the gallery").click()
    expect(dialog.get_by_text("The scan is now in the gallery.")).to_be_visible()
    dialog.get_by_role("button", name="Create link").click()
    link = dialog.get_by_label("Your new link").input_value()
    assert link.startswith(f"{stack.url}/shared#")
    dialog.get_by_label("Email address").fill("friend@example.org")
    dialog.get_by_role("button", name="Share", exact=True).click()
    expect(dialog.get_by_text("Shared with friend@example.org.")).to_be_visible()
    anna.page.screenshot(path=pictures / "share.png")
    dialog.get_by_role("button", name="Close").click()

    # A visitor without an account opens the link.
    guest = visit(small=True)
    guest.goto(link)
    expect(guest.get_by_role("heading", name="A head to share")).to_be_visible()
    guest.screenshot(path=pictures / "shared-link.png")
    guest.get_by_role("button", name="View the scan").click()
    expect(guest.locator("canvas[data-samples]")).to_be_visible()
    expect(guest.locator(".preset-picture img")).to_have_count(guest.locator(".preset").count(), timeout=60_000)
    guest.screenshot(path=pictures / "shared-link-looks.png")
    expect(guest.get_by_role("button", name="Show the slices (V)")).to_have_count(0)

    # Another user finds it and saves a look.
    bert = Person.arrives(stack, visit(small=True), "bert")
    bert.page.get_by_role("link", name="Gallery").click()
    bert.page.get_by_label("Words in the title").fill("head sha")
    bert.page.get_by_label("Body part").select_option("head")
    card = bert.page.locator(f"article[data-id='{scan}']")
    expect(card.get_by_text("by Anna of the hills")).to_be_visible()
    assert anna.email not in bert.page.content()
    bert.page.screenshot(path=pictures / "gallery.png")
    bert.page.get_by_role("button", name="Report A head to share").click()
    bert.page.get_by_label("More details").fill("I only try this.")
    bert.page.get_by_role("dialog").get_by_role("button", name="Report").click()
    expect(bert.page.get_by_text("An administrator will review your report.")).to_be_visible()
    bert.page.keyboard.press("Escape")
    boss = look_through_reports(stack, visit(small=True), pictures)
    bert.page.get_by_role("link", name="View A head to share").click()
    expect(bert.page.locator("canvas[data-samples]")).to_be_visible()
    expect(bert.page.get_by_role("link", name="Gallery")).to_have_attribute("href", "/gallery")
    bert.page.locator("[data-preset=muscle]").click()
    bert.page.get_by_role("button", name="Saved presets").click()
    dialog = bert.page.get_by_role("dialog")
    expect(dialog.get_by_text("There are no presets yet")).to_be_visible()
    expect(dialog.get_by_label("Name of the new preset")).to_have_accessible_description(re.compile("can read this name"))
    dialog.get_by_label("Name of the new preset").fill("Best of it")
    dialog.get_by_role("button", name="Save the current view").click()
    expect(dialog.get_by_role("button", name="Show Best of it")).to_be_visible()
    with bert.page.expect_download() as download:
        dialog.get_by_role("link", name="Download Best of it as a file").click()
    xml = Path(download.value.path())
    assert b'<preset xmlns="urn:diaphane:preset" version="1" name="Best of it">' in xml.read_bytes()
    dialog.get_by_label("Upload a preset file").set_input_files({"name": "x.xml", "mimeType": "application/xml", "buffer": xml.read_bytes().replace(b"Best of it", b"From a file")})
    expect(dialog.get_by_role("button", name="Show From a file")).to_be_visible()
    dialog.get_by_role("button", name="Delete From a file").click()
    dialog.get_by_role("button", name="Delete", exact=True).click()
    expect(dialog.get_by_role("button", name="Show From a file")).not_to_be_visible()
    bert.page.screenshot(path=pictures / "presets.png")

    # The owner makes it the default.
    anna.page.get_by_role("button", name="Saved presets").click()
    dialog = anna.page.get_by_role("dialog")
    dialog.get_by_role("button", name="Vote for Best of it", exact=True).click()
    expect(dialog.get_by_text("1 vote")).to_be_visible()
    before = facts(anna.page)
    dialog.get_by_role("button", name="Show Best of it").click()
    expect(anna.page.locator(f"canvas[data-input-seq='{before.input_seq + 1}']")).to_be_visible()
    dialog.get_by_role("button", name="Use Best of it as default").click()
    expect(dialog.get_by_text("Default", exact=True)).to_be_visible()
    dialog.get_by_role("button", name="Close").click()

    # Now it is shown to everyone who opens the scan.
    again = bert.page.context.new_page()
    again.goto(f"{stack.url}/view/{scan}")
    expect(again.locator("[data-preset=muscle][aria-pressed=true]")).to_be_visible()
    again.close()
    late = visit(small=True, samples=None)    # the choice of a number would be an input
    late.goto(link)
    late.get_by_role("button", name="View the scan").click()
    expect(late.locator("canvas[data-input-seq='0']")).to_be_visible()
    expect(late.locator("[data-preset=muscle][aria-pressed=true]")).to_be_visible()
    late.close()

    # Each preset has a picture: in the list, and in the gallery, from which it opens.
    anna.page.get_by_role("button", name="Saved presets").click()
    shown = "The scan shown with Best of it"
    expect(anna.page.get_by_role("dialog").get_by_role("img", name=shown)).to_be_visible(timeout=180_000)
    anna.page.screenshot(path=pictures / "presets-pictured.png")
    anna.page.get_by_role("dialog").get_by_role("button", name="Close").click()
    again = bert.page.context.new_page()
    again.goto(f"{stack.url}/gallery")
    crowd = again.locator(f"article[data-id='{scan}']").get_by_role("list", name="Presets for this scan")
    crowd.scroll_into_view_if_needed()  # pictures are loaded when they become visible
    expect(crowd.locator(f"img[alt='{shown}']")).to_be_visible()
    again.screenshot(path=pictures / "gallery-crowd.png")
    crowd.get_by_role("link", name="Show Best of it").click()
    expect(again.locator("[data-preset=muscle][aria-pressed=true]")).to_be_visible()
    again.close()

    preset_is_reported_and_taken_down(bert, Person.arrives(stack, visit(small=True), "cara"), boss, scan, "Best of it", pictures)
    expect(bert.page.locator("canvas[data-samples]")).to_be_visible()

    # When sharing ends, everyone else is disconnected at once.
    anna.page.get_by_role("button", name="Share this scan").click()
    dialog = anna.page.get_by_role("dialog")
    dialog.get_by_role("button", name="Remove from the gallery").click()
    expect(dialog.get_by_text("The scan is no longer in the gallery.")).to_be_visible()
    dialog.get_by_role("button", name="Disable the link").first.click()
    expect(dialog.get_by_text("Link disabled. Everyone using it has been disconnected.")).to_be_visible()
    expect(bert.page.get_by_role("status").get_by_text("This scan doesn’t exist, or you don’t have access to it.")).to_be_visible()
    expect(guest.get_by_role("status").get_by_text("the link has expired or was disabled")).to_be_visible()
    expect(guest.get_by_role("link", name="Create account")).to_be_visible()
    guest.get_by_role("link", name="Go to the start page").click()
    expect(guest.get_by_role("heading", name="See your own scan in 3D")).to_be_visible()
    expect(anna.page.locator("canvas[data-samples]")).to_be_visible()

    # A sample can be viewed without an account.
    stack.psql("UPDATE data_sets SET is_sample = true, visibility = 'public', published_at = now() WHERE id = %s", scan)
    nobody = visit(small=True)
    nobody.goto(stack.url)
    nobody.get_by_role("link", name="Gallery").click()
    nobody.get_by_role("link", name="View A head to share").click()
    expect(nobody.locator("canvas[data-samples]")).to_be_visible()
    expect(nobody.get_by_role("heading", name="A head to share")).to_be_visible()
    expect(nobody.get_by_text("Not for diagnosis")).to_be_visible()
    expect(nobody.locator(".preset svg, .preset img")).to_have_count(6)  # a colour until the picture has been made
    expect(nobody.get_by_role("button", name="Show the slices (V)")).to_be_visible()  # everyone may use the slices of a sample
    # Their time ends, and they may begin again.
    stack.psql("UPDATE visits SET expires_at = now() WHERE data_set_id = %s", scan)
    expect(nobody.get_by_role("heading", name="Your visit has ended")).to_be_visible()
    expect(nobody.get_by_role("status").get_by_text("20 minutes at a time")).to_be_visible()
    expect(nobody.locator(".stage > canvas")).to_be_hidden()
    nobody.screenshot(path=pictures / "sample-time-over.png")
    nobody.get_by_role("button", name="View it again").click()
    expect(nobody.locator("canvas[data-samples]")).to_be_visible()
    stack.psql("DELETE FROM data_sets WHERE id = %s", scan)  # keeps later tests unaffected


def test_the_owner_chooses_who_may_see_slices_and_save_videos(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna, bert = Person.arrives(stack, visit(small=True), "anna"), Person.arrives(stack, visit(small=True), "bert")
    scan = anna.has_scan(cranium, "A head for Bert")

    def may(page, slices: bool, downloads: bool) -> None:
        """Expects that the viewer of a page may do this, and nothing else."""
        expect(page.locator("canvas[data-samples]")).to_be_visible()
        expect(page.get_by_role("button", name="Show the slices (V)")).to_have_count(int(slices))
        page.get_by_role("button", name="Save or share", exact=True).click()
        dialog = page.get_by_role("dialog", name="Save or share")
        expect(dialog.get_by_label("File type")).to_have_count(int(downloads))
        expect(dialog.get_by_label("Size", exact=True)).to_have_count(int(downloads))
        expect(dialog.get_by_text("You can’t save videos or larger pictures of this scan.")).to_have_count(int(not downloads))
        expect(dialog.get_by_role("button", name="Save the picture")).to_be_enabled()  # of the screen
        page.screenshot(path=pictures / f"export-{'with' if downloads else 'without'}-downloads.png")
        page.keyboard.press("Escape")

    anna.page.goto(f"{stack.url}/view/{scan}")
    may(anna.page, slices=True, downloads=True)
    anna.page.get_by_role("button", name="Share this scan").click()
    dialog = anna.page.get_by_role("dialog")
    new = dialog.get_by_role("group", name="Permissions of the new person")
    for name in ("Can also see the slices", "Can also save videos and large pictures"):
        expect(new.get_by_role("checkbox", name=name)).to_be_checked()
        new.get_by_role("checkbox", name=name).uncheck()
    dialog.get_by_label("Email address").fill(bert.email)
    dialog.get_by_role("button", name="Share", exact=True).click()
    expect(dialog.get_by_text(f"Shared with {bert.email}.")).to_be_visible()
    rights = dialog.get_by_role("group", name=f"Permissions of {bert.email}")
    slices, downloads = (rights.get_by_role("checkbox", name=name) for name in ("Can also see the slices", "Can also save videos and large pictures"))
    expect(slices).not_to_be_checked()
    expect(downloads).not_to_be_checked()
    bert.page.goto(f"{stack.url}/scans")
    above, below = (bert.page.get_by_role("heading", name=name).bounding_box() for name in ("Shared with me", "No scans yet"))
    assert above["y"] < below["y"], "an invited person finds the scan of the invitation first"
    bert.page.goto(f"{stack.url}/view/{scan}")
    may(bert.page, slices=False, downloads=False)
    downloads.click()
    expect(dialog.get_by_text(f"Permissions of {bert.email} changed.")).to_be_visible()
    expect(downloads).to_be_checked()
    bert.page.reload()
    may(bert.page, slices=False, downloads=True)
    slices.click()
    expect(slices).to_be_checked()
    bert.page.reload()
    may(bert.page, slices=True, downloads=True)
    # A removed permission is gone at once, without a reload by Bert.
    slices.click()
    expect(slices).not_to_be_checked()
    expect(bert.page.get_by_role("button", name="Show the slices (V)")).to_have_count(0)
    bert.page.screenshot(path=pictures / "permission-withdrawn.png")
    bert.page.goto("about:blank")

    links = dialog.get_by_role("region", name="Share by link")
    links.get_by_role("checkbox", name="Also let viewers save videos and large pictures").check()
    links.get_by_role("button", name="Create link").click()
    expect(links.get_by_text("with videos and large pictures", exact=True)).to_be_visible()
    link = links.get_by_label("Your new link").input_value()
    visitor = visit(small=True)
    visitor.goto(link)
    visitor.get_by_role("button", name="View the scan").click()
    may(visitor, slices=False, downloads=True)
    for width, height in ((1280, 720), (390, 844)):
        anna.page.set_viewport_size({"width": width, "height": height})
        for section, element in (("people", rights), ("links", links), ("everybody", dialog.get_by_role("region", name="Share with everyone"))):
            element.scroll_into_view_if_needed()
            anna.page.screenshot(path=pictures / f"permissions-{section}-{width}.png")
