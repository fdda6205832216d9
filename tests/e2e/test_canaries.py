"""Checks every byte that leaves the browser while a user handles a scan full of canary words. It contains none of them."""

from __future__ import annotations

import struct
import time
import zlib
from pathlib import Path

from playwright.sync_api import Browser, expect

from canaries import Search
from harness import TestStack
from hostile.canary_scan import CanaryScan
from devtool import chromium
from person import PATIENCE_MS, Person
from picture import drag, wait_for_samples
from slow_network import SlowNetwork


def disc(scan: CanaryScan, folder: Path) -> Path:
    """Writes a disc as a scanner's viewer does: names of folders and files identify the patient, and there are other files
    besides the scan."""
    inside = folder / scan.words["names"] / scan.words["person"]
    inside.mkdir(parents=True)
    for number in range(24):
        (inside / f"{scan.words['names']}{number:04d}").write_bytes(scan.file(number))
    (inside / f"{scan.words['names']} letter.txt").write_text(f"To {scan.words['person']}")
    return folder / scan.words["names"]


def spoken(connection: bytes) -> bytes:
    """Returns the contents of a connection: WebSocket frames are unmasked and decompressed (RFC 6455, 7692)."""
    head, gap, rest = connection.partition(b"\r\n\r\n")
    if b"upgrade: websocket" not in head.lower():
        return connection
    out, at, unpack = bytearray(head + gap), 0, zlib.decompressobj(-15)
    while at + 2 <= len(rest):
        first, length = rest[at], rest[at + 1] & 127
        assert rest[at + 1] & 128, "a browser masks"
        at += 2
        if length > 125:
            size = 2 if length == 126 else 8
            length = int.from_bytes(rest[at:at + size], "big")
            at += size
        mask, body = rest[at:at + 4], rest[at + 4:at + 4 + length]
        at += 4 + length
        plain = bytes(byte ^ mask[n % 4] for n, byte in enumerate(body))
        out += unpack.decompress(plain + b"\0\0\xff\xff") if first & 0x40 else plain
    return bytes(out)


def test_recorded_socket_frames_are_decoded():
    mask = b"\1\2\3\4"
    frame = b"\x82" + bytes([128 | 126]) + struct.pack(">H", 300) + mask + bytes(b ^ mask[n % 4] for n, b in enumerate(b"word" * 75))
    assert spoken(b"GET / HTTP/1.1\r\nUpgrade: websocket\r\n\r\n" + frame).endswith(b"word" * 75)
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = (packer.compress(b"word" * 75) + packer.flush(zlib.Z_SYNC_FLUSH))[:-4]
    frame = b"\xc2" + bytes([128 | len(packed)]) + bytes(4) + packed
    assert spoken(b"GET / HTTP/1.1\r\nUpgrade: websocket\r\n\r\n" + frame).endswith(b"word" * 75)


def test_no_identifying_text_of_a_scan_leaves_the_browser(stack: TestStack, browser: Browser, tmp_path: Path):
    scan, begun = CanaryScan(), time.time()
    search = Search(scan.all_words(), begun)
    folder = disc(scan, tmp_path)
    assert len(search.below(folder)) > 24
    with SlowNetwork(stack.ports["edge"], socks=True, record=True) as network:
        way = [f"--proxy-server=socks5://127.0.0.1:{network.port}", "--proxy-bypass-list=<-loopback>"]
        recorded = browser.browser_type.launch(executable_path=chromium.for_tests(), args=[*chromium.ARGS, *way])
        page = recorded.new_context(viewport={"width": 480, "height": 320}).new_page()
        page.set_default_timeout(PATIENCE_MS)
        person = Person.signs_up_and_in(stack, page, "anna")
        person.uploads_scan(folder, "Nameless scan")
        person.open_scan("Nameless scan")
        wait_for_samples(stack, page, 2)
        drag(page, 60, 20)
        page.goto(f"{stack.url}/scans")
        expect(person.card("Nameless scan").get_by_role("img")).to_be_visible()
        recorded.close()
        sent = [spoken(bytes(connection)) for connection in network.sent]
    everything = b"\n".join(sent)
    # The recording is complete: it contains what was typed, the scan itself, and the messages of the viewer's socket.
    assert Search(["Nameless scan"]).inside(everything)
    assert b"PATCH /v1/uploads/" in everything and everything.count(b"DICM") >= 20
    assert any(b"upgrade: websocket" in one.lower() and len(one) > 2000 for one in sent)
    assert search.inside(everything) == []
    assert search.below(stack.data_dir) == []
