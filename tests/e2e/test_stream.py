"""The stream as a browser shows it: the colours of each codec, the lossless picture, and everything over a slow network."""

from __future__ import annotations

import base64
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from harness import REPO, StackFactory, TestStack
from devtool import chromium
from person import PATIENCE_MS, Person
from picture import difference, facts, pixels, wait_for_samples
from slow_network import SlowNetwork

# Records messages of the page's socket: the hash and position of each lossless tile.
HEARING = (REPO / "tools" / "devtool" / "page_wire.js", Path(__file__).parent / "hear_stills.js")

#: By how much coding may change the mean of a channel, of 255.
MOST_CAST = 1.5


@pytest.fixture(scope="module")
def quick(all_stacks: StackFactory):
    """A stack whose pictures are finished quickly."""
    stack = all_stacks.open(extra_env={"DIAPHANE_MAX_ERROR": "0.3"})
    yield stack
    all_stacks.shut(stack)


def use_codec(page: Page, codec: str) -> None:
    page.add_init_script(f"localStorage.setItem('diaphane.codecs', '{codec}')")


def lossless(stack: TestStack, page: Page, input_seq: int = 0) -> int:
    """Waits for the lossless picture and returns its samples."""
    def marked() -> int | None:
        # values of the same moment
        samples, shown = page.locator("canvas").evaluate("(c) => [c.dataset.lossless, c.dataset.inputSeq]")
        page.wait_for_timeout(50)
        return int(samples) if samples and int(shown) >= input_seq else None

    return stack.wait_until(marked, timeout=120, what="the lossless picture")


def check_every_pixel(page: Page) -> int:
    """Compares the canvas with the hash of each tile that the worker sent. Returns the number of tiles."""
    return page.evaluate(
        """async () => {
            const canvas = document.querySelector("canvas");
            const tiles = Object.values(heardStills.tiles);
            let area = 0;
            for (const { x, y, width, height, hash } of tiles) {
                const rgba = canvas.getContext("2d").getImageData(x, y, width, height).data;
                const rgb = new Uint8Array(rgba.length / 4 * 3).map((_, n) => rgba[Math.floor(n / 3) * 4 + n % 3]);
                const own = new Uint8Array(await crypto.subtle.digest("SHA-256", rgb));
                if (own.some((byte, n) => byte !== hash[n])) throw new Error(`the tile at ${x}, ${y} is another on the canvas`);
                area += width * height;
            }
            if (area !== canvas.width * canvas.height) throw new Error(`tiles of ${area} pixels for ${canvas.width} x ${canvas.height}`);
            return tiles.length;
        }""")


@pytest.fixture(scope="module")
def anna(quick: TestStack, browser: Browser, cranium: Path):
    """A user with a scan. Pages of the module use contexts with these cookies."""
    context = browser.new_context()
    context.set_default_timeout(PATIENCE_MS)
    person = Person.arrives(quick, context.new_page(), "anna")
    scan = person.has_scan(cranium, "Head")
    yield scan, context.cookies()
    context.close()


def view(visit, stack: TestStack, anna, codec: str | None = None, **choices) -> Page:
    scan, cookies = anna
    page = visit(**choices)
    page.context.add_cookies(cookies)
    for script in HEARING:
        page.add_init_script(path=script)
    if codec:
        use_codec(page, codec)
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 1)
    return page


def turn(page: Page) -> None:
    """Rotates with a key, because the panels leave little space on such a small page."""
    page.locator("canvas").focus()
    page.keyboard.press("ArrowRight")


def heard_codecs(page: Page) -> set[int]:
    return set(page.evaluate("Object.keys(heardStills.codecs).map(Number)"))


@pytest.mark.parametrize(("codec", "number"), [("H264", 2), ("JPEG", 1), ("MPEG1", 3)])
def test_each_codec_has_the_right_colours_and_ends_lossless(quick: TestStack, visit, anna, pictures: Path, codec: str, number: int):
    page = view(visit, quick, anna, codec, small=True)
    lossless(quick, page)
    page.evaluate("heardStills.keepCoded(document.querySelector('canvas'))")
    for _ in range(5):  # on a busy machine, acknowledgements are late, and pictures become too coarse for a comparison of colours
        before = facts(page)
        turn(page)  # another picture: the mark disappears and reappears with the new tiles
        samples = lossless(quick, page, before.input_seq + 1)
        assert facts(page).epoch > before.epoch
        assert check_every_pixel(page) == 4  # 480 x 320
        coarseness = page.evaluate("heardStills.coarseness")
        coded, exact = base64.b64decode(page.evaluate("heardStills.coded()")), pixels(page)
        if coarseness <= MOST_CAST and difference(coded, exact) < MOST_CAST:
            break
    page.get_by_role("button", name="Show the quality: Finished").click()
    page.get_by_text("Details", exact=True).click()
    expect(page.get_by_text(f"Lossless, {samples:,} samples")).to_be_visible()
    page.screenshot(path=pictures / f"lossless-{codec}.png")

    # Compares the last encoded picture with the lossless one. Encoding changes little and adds no colour cast.
    assert heard_codecs(page) == {number}
    casts = [(sum(coded[channel::3]) - sum(exact[channel::3])) / (len(exact) / 3) for channel in range(3)]
    # A wrong matrix (BT.601 for BT.709) changes the mean of red or blue of skin by at least 4, and a wrong range every mean by 8.
    assert difference(coded, exact) < max(MOST_CAST, coarseness)
    assert all(abs(cast) < max(MOST_CAST, coarseness) for cast in casts), (casts, coarseness)


def test_a_damaged_tile_is_reported_and_the_streamed_picture_stays(quick: TestStack, visit, anna):
    page = view(visit, quick, anna, small=True)
    lossless(quick, page)
    page.evaluate("heardStills.spoil = true")
    before = facts(page)
    turn(page)
    expect(page.get_by_role("status")).to_contain_text("was corrupted in transit")
    assert facts(page).input_seq > before.input_seq
    assert page.locator("canvas").get_attribute("data-lossless") is None
    page.evaluate("heardStills.spoil = false")
    turn(page)
    lossless(quick, page, before.input_seq + 2)


@pytest.mark.nightly
def test_a_failing_decoder_is_replaced_by_the_next_codec(quick: TestStack, visit, anna):
    """As when a graphics driver fails: the test frame is decoded, and later frames are not."""
    scan, cookies = anna
    page = visit(small=True)
    page.context.add_cookies(cookies)
    for script in HEARING:
        page.add_init_script(path=script)
    page.add_init_script("""
        const decode = VideoDecoder.prototype.decode;
        let decoded = 0;
        VideoDecoder.prototype.decode = function (chunk) {
            if (decoded++ > 0) throw new DOMException("made to fail", "EncodingError");
            return decode.call(this, chunk);
        };""")
    page.goto(f"{quick.url}/view/{scan}")
    wait_for_samples(quick, page, 1)
    assert heard_codecs(page) == {1, 2}  # H.264 first, then JPEG
    turn(page)
    lossless(quick, page, 1)


@pytest.mark.nightly
def test_on_a_slow_network_the_picture_follows_input_and_ends_lossless(quick: TestStack, browser: Browser, anna):
    """100 ms round trip and 2 Mbit/s, as a browser sees it. For measurements: tests/integration/test_slow_network.py."""
    scan, cookies = anna
    with SlowNetwork(quick.ports["edge"], round_trip_s=0.1, bits_per_s=2e6, socks=True) as network:
        # The page sees the public address. Only this browser takes another route.
        way = [f"--proxy-server=socks5://127.0.0.1:{network.port}", "--proxy-bypass-list=<-loopback>"]
        far = browser.browser_type.launch(executable_path=chromium.for_tests(), args=[*chromium.ARGS, *way])
        context = far.new_context(viewport={"width": 480, "height": 320})
        context.set_default_timeout(PATIENCE_MS)
        context.add_cookies(cookies)
        page = context.new_page()
        for script in HEARING:
            page.add_init_script(path=script)
        page.goto(f"{quick.url}/view/{scan}")
        wait_for_samples(quick, page, 1)
        assert network.to_viewer.bytes > 100_000  # the page itself was loaded this way
        shown, turns = set(), 0
        while turns < 20 or len(shown) < 5:  # the picture follows, so intermediate ones are shown, too
            turn(page)
            turns += 1
            assert turns < 500, f"of {turns} turns only {len(shown)} were seen"
            page.wait_for_timeout(100)
            shown.add(facts(page).input_seq)
        last = facts(page).input_seq
        lossless(quick, page, max(turns, last))
        assert check_every_pixel(page) == 4
        assert heard_codecs(page) == {2}
        far.close()
