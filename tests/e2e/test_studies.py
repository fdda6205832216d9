"""Studies: a researcher composes, previews, opens and exports one, and participants take part without an account, on a phone in
German and on a desktop in English."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from test_every_page import faults, zoomed_faults
from touch import Fingers

#: A scene that the made-up server can draw.
SCENE = {
    "transferFunction": {"extinctionPerMm": 1, "channels": [
        {"name": "bone", "diffuse": {"r": 0.9, "g": 0.85, "b": 0.7}, "opacity": [{"value": 0}, {"value": 300, "opacity": 1}]}]},
    "lights": [{"name": "sky", "environment": {"radiance": {"r": 1, "g": 1, "b": 1}}}],
    "camera": {"eye": {"y": -520}, "target": {}, "up": {"z": 1}, "verticalFovDegrees": 30},
}
REGION = {"name": {"en": "Nose", "de": "Nase"}, "centre": [0, -90, 0], "radius": 20}
VIEW = {"data_set_id": "0123abcd-0000-4000-8000-000000000000", "scene": SCENE, "preset": "Bone", "may_change": ["camera"],
        "start": "random", "region": REGION}
CREATE = """async ([definition, pictures]) => {
    const send = (method, path, body) => fetch(path, { method, body: JSON.stringify(body) });
    const { id } = await (await send("POST", "/v1/studies", { definition })).json();
    await send("POST", `/v1/studies/${id}/state`, { state: "open" });
    for (const [number, picture] of pictures.entries()) {
        const sheet = new OffscreenCanvas(200, 200), context = sheet.getContext("2d");
        context.fillStyle = `hsl(${number * 70} 60% 50%)`;
        context.fillRect(0, 0, 200, 200);
        await fetch(`/v1/studies/${id}/pictures/${picture}`, { method: "PUT", body: await sheet.convertToBlob({ type: "image/jpeg" }) });
    }
    return (await (await send("POST", `/v1/studies/${id}/link`, {})).json()).path;
}"""


def step(kind: str, name: str, **more) -> dict:
    return {"id": name, "kind": kind, "group": "", "text": {"en": f"Text of {name}", "de": f"Text von {name}"}, **more}


def made_up_study(page: Page, url: str, *steps: dict, pictures: tuple[str, ...] = ()) -> str:
    """Returns the link to an open study of the made-up server."""
    definition = {"version": 1, "template": "own", "title": {"en": "A study", "de": "Eine Studie"}, "places": 9, "record": False,
                  "ends_at": "2030-01-01T00:00:00Z", "steps": [step("consent", "consent"), *steps]}
    page.goto(url)
    return url + page.evaluate(CREATE, [definition, list(pictures)])


def sent_answers(page: Page) -> list[dict]:
    """Collects the answers that the server acknowledges from now on."""
    answers: list[dict] = []
    page.on("response", lambda response: answers.append(json.loads(response.request.post_data))
            if response.url.endswith("/v1/study/answers") and response.ok else None)
    return answers


def agree(page: Page) -> None:
    page.get_by_role("button", name=re.compile("^(I agree|Ich bin einverstanden)")).click()


def live(page: Page) -> None:
    expect(page.locator(".study-picture:not([data-covered]) canvas[data-samples]")).to_be_visible()


# The page alone

def test_answers_survive_an_outage_and_a_reload(fake, visit):
    page = visit()
    link = made_up_study(page, fake.url, step("words", "a"), step("text", "b"), step("words", "c"))
    answers = sent_answers(page)
    page.goto(link)
    agree(page)
    page.route("**/v1/study/answers", lambda route: route.abort())
    page.get_by_label("Your answer").fill("first words")
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_text("We can’t reach the server at the moment. Your answers are kept")).to_be_visible()
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_text("Step 3 of 3")).to_be_visible()
    page.reload()
    expect(page.get_by_text("Step 3 of 3")).to_be_visible()
    page.unroute("**/v1/study/answers")
    page.get_by_label("Your answer").fill("last words")
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_role("heading", name="Thank you for taking part")).to_be_visible()
    assert [(one["step"], one["value"]) for one in answers] == [("a", {"words": "first words"}), ("b", {}), ("c", {"words": "last words"})]
    assert [one["sequence"] for one in answers] == [1, 2, 3]
    page.reload()
    expect(page.get_by_role("heading", name="Thank you for taking part")).to_be_visible()


def test_stopping_deletes_the_answers_on_request(fake, visit):
    page = visit(phone=True, locale="de-DE")
    page.goto(made_up_study(page, fake.url, step("words", "a"), step("text", "b")))
    expect(page.get_by_role("heading", name="Eine Studie")).to_be_visible()
    agree(page)
    page.get_by_role("button", name="Aufhören").click()
    dialog = page.get_by_role("dialog", name="Möchten Sie aufhören?")
    dialog.get_by_role("button", name="Weitermachen").click()
    page.get_by_role("button", name="Aufhören").click()
    with page.expect_request("**/v1/study/withdrawal"):
        dialog.get_by_role("button", name="Aufhören und Antworten löschen").click()
    expect(page.get_by_role("heading", name="Ihre Antworten sind gelöscht")).to_be_visible()
    expect(page.get_by_text("Link zum Löschen")).to_have_count(0)
    page.get_by_label("Sprache").select_option("en")
    expect(page.get_by_role("heading", name="Your answers are deleted")).to_be_visible()


PICTURES = ("p1", "p2", "p3")


def order_study(page: Page, url: str) -> str:
    return made_up_study(page, url, step("order", "order", pictures=[{"id": one, "comfort": n - 1} for n, one in enumerate(PICTURES)]),
                         pictures=PICTURES)


def numbers(page: Page) -> list[str]:
    return page.locator(".study-order li").evaluate_all("(items) => items.map((item) => item.dataset.picture)")


def centre(page: Page, number: str) -> tuple[float, float]:
    box = page.locator(f".study-order li[data-picture='{number}'] .study-order-picture").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_pictures_are_put_in_order_by_keys_buttons_and_mouse(fake, visit, pictures: Path):
    page = visit(reduced_motion="reduce")
    page.goto(order_study(page, fake.url))
    answers = sent_answers(page)
    agree(page)
    expect(page.locator(".study-order img")).to_have_count(3)
    assert numbers(page) == ["1", "2", "3"]
    first = page.get_by_role("group", name="Picture 1, position 1 of 3")
    first.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowDown")  # the picture keeps the focus
    assert numbers(page) == ["2", "3", "1"]
    expect(page.get_by_text("Picture 1 is now at position 3.")).to_be_attached()
    page.get_by_role("button", name="Move picture 3 towards least comfortable").click()
    assert numbers(page) == ["3", "2", "1"]
    page.mouse.move(*centre(page, "3"))
    page.mouse.down()
    page.mouse.move(*centre(page, "1"), steps=8)
    page.mouse.up()
    assert numbers(page) == ["2", "1", "3"]
    page.screenshot(path=pictures / "study-order.png")
    assert faults(page) + zoomed_faults(page) == []
    page.get_by_role("button", name="This is my order").click()
    expect(page.get_by_role("heading", name="Thank you for taking part")).to_be_visible()
    shown = answers[0]["value"]["shown"]
    assert sorted(shown) == sorted(PICTURES)
    assert answers[0]["value"]["order"] == [shown[1], shown[0], shown[2]]


def test_pictures_are_put_in_order_by_touch(fake, visit):
    page = visit(phone=True)
    page.goto(order_study(page, fake.url))
    agree(page)
    expect(page.locator(".study-order img")).to_have_count(3)
    grip = page.locator(".study-order li[data-picture='1'] .study-grip").bounding_box()
    begin = (grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2)
    Fingers(page).drag([(begin, centre(page, "2"))])
    assert numbers(page) == ["2", "1", "3"]


def test_a_viewpoint_begins_at_random_and_offers_nothing_but_the_view(fake, visit, pictures: Path):
    starts = []
    for phone in (True, False):
        page = visit(phone=phone)
        link = made_up_study(page, fake.url, step("viewpoint", "view", view=VIEW))
        answers = sent_answers(page)
        page.goto(link)
        agree(page)
        live(page)
        assert page.locator(".menu, .presets, .viewer-tools, .quality").count() == 0
        page.screenshot(path=pictures / f"study-viewpoint-{'phone' if phone else 'desktop'}.png")
        assert faults(page) == []
        page.keyboard.press("ArrowRight")
        page.get_by_role("button", name="This is my view").click()
        expect(page.get_by_role("heading", name="Thank you for taking part")).to_be_visible()
        value = answers[0]["value"]
        starts.append(value["start"]["eye"])
        # Five degrees about the head-foot axis, at the distance of the look.
        assert math.dist(value["camera"]["eye"], value["camera"]["target"]) == pytest.approx(520)
        (x, y, z), (to_x, to_y, to_z) = value["start"]["eye"], value["camera"]["eye"]
        assert to_z == pytest.approx(z)
        assert abs(math.remainder(math.atan2(to_y, to_x) - math.atan2(y, x), 2 * math.pi)) == pytest.approx(math.radians(5))
    # Both have the same seed, and windows of different shapes.
    assert starts[0] == pytest.approx(starts[1]) and math.dist(starts[0], (0, -520, 0)) > 1


def test_colours_change_in_the_picture_and_are_sent_with_the_first_ones(fake, visit):
    page = visit()
    view = {**VIEW, "start": "preset", "may_change": []}
    link = made_up_study(page, fake.url, step("colours", "c", view=view, materials=[{"channel": "bone", "name": {"en": "Bone"}}]))
    answers = sent_answers(page)
    page.goto(link)
    agree(page)
    live(page)
    before = page.locator("canvas").get_attribute("data-input-seq")
    page.get_by_label("Bone").fill("#ff8800")
    expect(page.locator("canvas")).not_to_have_attribute("data-input-seq", before)
    page.get_by_role("button", name="These are my colours").click()
    expect(page.get_by_role("heading", name="Thank you for taking part")).to_be_visible()
    (colour,) = answers[0]["value"]["colours"]
    assert colour == {"channel": "bone", "from": "#f3edda", "to": "#ff8800"}


def test_a_latency_task_measures_each_delay_once(fake, visit):
    page = visit()
    link = made_up_study(page, fake.url, step("latency", "l", view=VIEW, delays_ms=[0, 100, 250]))
    answers = sent_answers(page)
    page.goto(link)
    agree(page)
    for trial in (1, 2, 3):
        expect(page.get_by_text(f"Task {trial} of 3")).to_be_visible()
        page.get_by_role("button", name="Start").click()
        live(page)
        page.keyboard.press("ArrowLeft")
        page.get_by_role("button", name="It faces me").click()
        if trial == 2:
            page.reload()  # a trial that is not rated starts again
            page.get_by_role("button", name="Start").click()
            live(page)
            page.get_by_role("button", name="It faces me").click()
        page.get_by_label("No", exact=True).check()
        page.get_by_label("7", exact=True).check()
        page.get_by_role("button", name="Continue").click()
    expect(page.get_by_role("heading", name="Thank you for taking part")).to_be_visible()
    trials = answers[0]["value"]["trials"]
    assert sorted(one["delay_ms"] for one in trials) == [0, 100, 250]
    assert all(0 <= one["error_degrees"] <= 180 and one["time_ms"] > 0 for one in trials)
    assert len({round(one["error_degrees"], 3) for one in trials}) == 3
    assert [(one["acceptable"], one["rating"]) for one in trials] == [(False, 7)] * 3


# With the real programs

EXPORT = "async (path) => { const answer = await fetch(path); return answer.ok ? answer.json() : answer.status; }"


def composed(page: Page, url: str, pictures: Path, look: str = "bone", also: str | None = None) -> str:
    """Composes the comfort study and returns its address. Participants recolour bone, and another material if one is given."""
    page.goto(url + "/studies")
    expect(page.get_by_role("heading", name="Start a new study")).to_be_visible()
    assert faults(page) + zoomed_faults(page) == []
    page.get_by_role("link", name="Comfort", exact=False).first.click()
    expect(page.get_by_role("button", name="Save study")).to_be_disabled()
    page.get_by_role("button", name="Choose picture").click()
    live(page)
    page.get_by_label("Look").select_option(look)
    page.screenshot(path=pictures / "study-editor.png", full_page=True)
    assert faults(page) == []
    page.get_by_role("button", name="Use this picture").click()
    page.get_by_role("button", name="Edit Step 3: Colours").click()
    page.get_by_role("button", name="Use the picture of another step").click()
    if also:
        page.get_by_role("checkbox", name=f"Offer {also}").check()
    page.get_by_role("button", name="Use the colours of the published study").click()
    page.get_by_role("button", name="Save study").click()
    expect(page.get_by_text("The study is saved.")).to_be_visible()
    page.screenshot(path=pictures / "study-composer.png", full_page=True)
    assert faults(page) + zoomed_faults(page) == []
    return page.url


def takes_part(page: Page, link: str, german: bool, pictures: Path) -> None:
    """Goes through the comfort study."""
    name = "phone" if german else "desktop"
    page.goto(link)
    expect(page.get_by_role("heading", name="Wie angenehm ist das Bild?" if german else "How comfortable is the picture?")).to_be_visible()
    assert faults(page) == []
    agree(page)
    live(page)
    page.screenshot(path=pictures / f"study-rating-{name}.png")
    assert faults(page) == []
    page.get_by_label("2", exact=True).check()
    page.get_by_role("button", name="Weiter" if german else "Continue").click()
    live(page)
    page.get_by_label("Knochen" if german else "Bone", exact=True).fill("#caa06a")
    page.screenshot(path=pictures / f"study-colours-{name}.png")
    page.get_by_role("button", name="Das sind meine Farben" if german else "These are my colours").click()


def test_a_study_from_composing_to_a_withdrawal(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True, reduced_motion="reduce")
    person = Person.arrives(stack, page, "researcher")
    person.has_scan(cranium, "Head")
    page.goto(stack.url + "/studies")
    expect(page.get_by_text("Studies are for researchers.")).to_be_visible()
    stack.psql("UPDATE users SET is_researcher = true WHERE email = %s", person.email)
    address = composed(page, stack.url, pictures)
    study = address.rsplit("/", 1)[1]

    page.get_by_role("button", name="Preview").click()
    expect(page.get_by_text("Preview: your answers are not counted.")).to_be_visible()
    live(page)
    page.get_by_role("button", name="Back to the study").click()

    page.get_by_role("button", name="Open study").click()
    expect(page.get_by_text("The study is open.")).to_be_visible()
    page.get_by_role("button", name="Create link").click()
    link = page.get_by_label("Link for participants").input_value()

    phone = visit(phone=True, locale="de-DE")
    takes_part(phone, link, True, pictures)
    phone.get_by_label("Ihre Antwort").fill("Danke")
    phone.get_by_role("button", name="Weiter").click()
    expect(phone.get_by_role("heading", name="Vielen Dank für Ihre Teilnahme")).to_be_visible()
    phone.screenshot(path=pictures / "study-thanks.png")
    withdrawal = phone.get_by_label("Link zum Löschen Ihrer Antworten").last.input_value()

    desktop = visit()
    takes_part(desktop, link, False, pictures)
    desktop.get_by_role("button", name="Stop").click()
    desktop.get_by_role("button", name="Stop and keep my answers").click()
    expect(desktop.get_by_role("heading", name="You have stopped")).to_be_visible()
    assert phone.context.cookies() == [] and desktop.context.cookies() == []

    export = page.evaluate(EXPORT, f"/v1/studies/{study}/export?format=json")
    assert [(one["language"], one["state"]) for one in export["participants"]] == [("de", "finished"), ("en", "active")]
    answers = {one["step"]: one["value"] for one in export["participants"][0]["answers"]}
    assert answers["rating"] == {"rating": 2} and answers["remarks"] == {"words": "Danke"}
    assert {"channel": "bone", "from": "#e8ba94", "to": "#caa06a"} in answers["colours"]["colours"]

    phone.goto("about:blank")
    phone.goto(withdrawal)
    phone.get_by_role("button", name="Meine Antworten löschen").click()
    expect(phone.get_by_role("heading", name="Ihre Antworten sind gelöscht")).to_be_visible()
    export = page.evaluate(EXPORT, f"/v1/studies/{study}/export?format=json")
    assert [one["language"] for one in export["participants"]] == ["en"] and export["study"]["withdrawn"] == 1

    page.reload()
    page.get_by_role("button", name="Close study").click()
    page.get_by_role("dialog").get_by_role("button", name="Close study").click()
    expect(page.get_by_text("The study is closed.")).to_be_visible()
    page.screenshot(path=pictures / "study-closed.png", full_page=True)
    visitor = visit()
    visitor.goto(link)
    expect(visitor.get_by_text("This study is closed.")).to_be_visible()


def test_the_five_pictures_of_a_validation_are_rendered_and_saved(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True, reduced_motion="reduce")
    person = Person.arrives(stack, page, "researcher")
    person.has_scan(cranium, "Head")
    stack.psql("UPDATE users SET is_researcher = true WHERE email = %s", person.email)
    page.goto(stack.url + "/studies/validation")
    page.get_by_role("button", name="Save study").click()
    expect(page.get_by_text("The study is saved.")).to_be_visible()
    page.get_by_role("button", name="Edit Step 2: Order of pictures").click()
    page.get_by_role("button", name="Take the pictures").click()
    live(page)
    page.get_by_label("Look").select_option("bone")
    page.get_by_role("button", name="Use this picture").click()
    expect(page.get_by_text("All pictures are saved.")).to_be_visible(timeout=300_000)
    expect(page.get_by_text("5 of 5 pictures are there.")).to_be_visible()
    page.screenshot(path=pictures / "study-pictures.png", full_page=True)
    study = page.url.rsplit("/", 1)[1]
    files = [page.evaluate("""async (path) => [...new Uint8Array(await (await fetch(path)).arrayBuffer())]""",
                           f"/v1/studies/{study}/pictures/picture-{number}") for number in range(1, 6)]
    for file in files:
        data = bytes(file)
        assert data[:2] == b"\xff\xd8" and len(data) <= 512 * 1024
        assert b"Exif" not in data and b"http://ns.adobe.com" not in data
    assert len({bytes(file) for file in files}) == 5


def test_an_administrator_grants_and_withdraws_the_role(stack: TestStack, visit):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "administrator")
    person.becomes_administrator()
    page.goto(f"{stack.url}/admin/users")
    page.get_by_label("Part of an email address").fill(person.email)
    page.get_by_role("button", name="Search", exact=True).click()
    for action, shown in (("Make researcher", 1), ("Withdraw the researcher role", 0)):
        page.get_by_role("button", name=f"Edit {person.email}").click()
        page.get_by_role("button", name=action).click()
        expect(page.get_by_role("dialog")).to_have_count(0)
        expect(page.locator(".chip", has_text=re.compile("^researcher$"))).to_have_count(shown)
        page.reload()
        page.get_by_label("Part of an email address").fill(person.email)
        page.get_by_role("button", name="Search", exact=True).click()
        expect(page.get_by_role("link", name="Studies")).to_have_count(shown)


def blueness(page: Page) -> float:
    """Returns how much bluer than red the bluest of 32 x 32 parts of the picture is, of 255."""
    return page.locator("canvas").evaluate("""(source) => {
        const small = new OffscreenCanvas(32, 32).getContext("2d");
        small.drawImage(source, 0, 0, 32, 32);
        const { data } = small.getImageData(0, 0, 32, 32);
        let most = 0;
        for (let i = 0; i < data.length; i += 4) most = Math.max(most, data[i + 2] - data[i]);
        return most;
    }""")


def test_a_part_is_marked_in_the_picture_and_found_from_a_random_view(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "researcher")
    person.has_scan(cranium, "Head")
    stack.psql("UPDATE users SET is_researcher = true WHERE email = %s", person.email)
    page.goto(stack.url + "/studies/viewpoints")
    page.get_by_role("button", name="Choose picture").click()
    live(page)
    assert blueness(page) < 40
    page.get_by_label("Highlight a part").check()
    page.get_by_role("button", name="Mark in the picture").click()
    page.keyboard.press("Enter")  # the middle of the picture
    expect(page.locator(".picker")).to_have_count(0)
    page.get_by_label("Name of the part (English)").fill("Forehead")
    page.get_by_label("First view").select_option("random")
    stack.wait_until(lambda: blueness(page) > 60 or page.wait_for_timeout(50), what="the highlighted part")
    page.screenshot(path=pictures / "study-region.png", full_page=True)
    page.get_by_role("button", name="Use this picture").click()
    page.get_by_role("button", name="Save study").click()
    expect(page.get_by_text("The study is saved.")).to_be_visible()
    page.get_by_role("button", name="Open study").click()
    expect(page.get_by_text("The study is open.")).to_be_visible()
    page.get_by_role("button", name="Create link").click()
    visitor = visit(phone=True)
    answers = sent_answers(visitor)
    visitor.goto(page.get_by_label("Link for participants").input_value())
    agree(visitor)
    live(visitor)
    expect(visitor.get_by_text("The coloured part: Forehead")).to_be_visible()
    visitor.screenshot(path=pictures / "study-random-view.png")
    visitor.get_by_role("button", name="This is my view").click()
    expect(visitor.get_by_label("Your answer")).to_be_visible()
    stack.wait_until(lambda: answers or visitor.wait_for_timeout(50), what="the answer")
    study = page.evaluate(EXPORT, f"/v1/studies/{page.url.rsplit('/', 1)[1]}")
    view = study["definition"]["steps"][1]["view"]
    assert view["region"]["name"] == {"en": "Forehead"} and view["scene"]["highlight"]["radius"] == view["region"]["radius"]
    first = [view["scene"]["camera"]["eye"].get(axis, 0) for axis in "xyz"]
    target = [view["scene"]["camera"]["target"].get(axis, 0) for axis in "xyz"]
    start = answers[0]["value"]["start"]
    assert start["target"] == pytest.approx(target) and math.dist(start["eye"], target) == pytest.approx(math.dist(first, target))
    assert math.dist(start["eye"], first) > 1  # a start nearer than that has a probability below 1e-5
    assert answers[0]["value"]["camera"]["eye"] == pytest.approx(start["eye"])
