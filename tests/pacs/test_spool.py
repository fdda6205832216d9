"""The spool of received series: what a sender was told is stored outlives the gateway, a full disk and an unavailable server."""

from __future__ import annotations

import errno
import os
import shutil
import time
from pathlib import Path

import phantom
import pydicom
import pytest
from diaphane.errors import ConnectionLost, NotFoundError
from diaphane_pacs import intake, limits, metrics, series_file, uploads
from diaphane_pacs.errors import ArchiveError
from diaphane_pacs.intake import Intake
from diaphane_pacs.spool import Sender, Spool, SpoolError
from harness import wait_until

SENDER = Sender("stow", "stow", "a-token")
QUIET = 0.05
#: A restart looks like one to a series only if nothing else holds the spool.
KEY = "k" * 64


@pytest.fixture(scope="module")
def images(tmp_path_factory) -> list[pydicom.Dataset]:
    return [pydicom.dcmread(path) for path in sorted(phantom.write(tmp_path_factory.mktemp("phantom")).glob("*.dcm"))[:5]]


@pytest.fixture
def server(monkeypatch) -> Server:
    return Server(monkeypatch)


class Server:
    """Stands for api."""

    def __init__(self, monkeypatch):
        self.problem: Exception | None = None
        self.delivered: list[bytes] = []
        self.keys: list[str] = []
        monkeypatch.setattr(uploads, "deliver", self._deliver)
        monkeypatch.setattr(Intake, "_call", lambda *_, **__: {"free_bytes": 1 << 30})

    def _deliver(self, _url, _token, _title, file, key) -> None:
        self.keys.append(key)
        if self.problem:
            raise self.problem
        with file.finish() as data:
            self.delivered.append(data[:])


@pytest.fixture
def started():
    """Starts gateways, of which only the newest holds the spool."""
    running: list[Intake] = []

    def start(folder: Path, quiet: float = QUIET, most: int = 1 << 30, callers: dict[str, str] | None = None) -> Intake:
        stop()
        running.append(Intake("http://127.0.0.1:1", quiet, Spool(folder, most, KEY), callers))
        return running[-1]

    def stop() -> None:
        while running:
            one = running.pop()
            one.stop()
            one.spool.close()

    yield start
    stop()


def send(gateway: Intake, images: list[pydicom.Dataset], sender: Sender = SENDER) -> None:
    """Sends images in one association, so that the series is not complete before all are there."""
    with gateway.connected(sender):
        for image in images:
            gateway.add(sender, image)


def complete(images: list[pydicom.Dataset]) -> bytes:
    """Returns the upload of the images."""
    file = series_file.SeriesFile()
    for image in images:
        file.add(image)
    with file.finish() as data:
        return data[:]


def test_a_series_outlives_a_gateway_that_ends_before_the_upload(tmp_path, images, server, started):
    before = started(tmp_path, quiet=1000)
    send(before, images)
    started(tmp_path)
    wait_until(lambda: server.delivered, 30, "the upload")
    assert server.delivered == [complete(images)]
    wait_until(lambda: os.listdir(tmp_path) == ["lock"], 10, "an empty spool")


def test_a_sender_completes_a_series_after_a_restart(tmp_path, images, server, started, monkeypatch):
    before = started(tmp_path, quiet=1000)
    send(before, images[:3])
    monkeypatch.setattr(limits, "RESEND_FACTOR", 1e9)
    after = started(tmp_path)
    send(after, images)
    assert not server.delivered
    monkeypatch.setattr(limits, "RESEND_FACTOR", 1)
    wait_until(lambda: server.delivered, 30, "the upload")
    assert server.delivered == [complete(images)], "one series, with each image once"


def test_a_failed_upload_is_repeated_with_the_same_key_also_after_a_restart(tmp_path, images, server, started, capfd):
    server.problem = ConnectionLost("away")
    before = started(tmp_path)
    send(before, images)
    wait_until(lambda: len(server.keys) >= 2, 30, "a second attempt")
    started(tmp_path)
    server.problem = None
    wait_until(lambda: server.delivered, 30, "the upload")
    assert server.delivered == [complete(images)] and len(set(server.keys)) == 1
    said = capfd.readouterr().err
    assert "a received series was not uploaded: unavailable" in said and "Phantasia" not in said


def test_a_series_that_cannot_be_uploaded_in_time_is_given_up(tmp_path, images, server, started, monkeypatch, capfd):
    server.problem = ConnectionLost("away")
    monkeypatch.setattr(limits, "SPOOL_SECONDS", 0)
    gateway = started(tmp_path)
    lost = metrics.METRICS.text().count(b'diaphane_pacs_lost_series_total{archive="stow"} 1.0')
    send(gateway, images)
    wait_until(lambda: os.listdir(tmp_path) == ["lock"], 30, "an empty spool")
    assert gateway.spool.used == 0 and not lost
    assert b'diaphane_pacs_lost_series_total{archive="stow"} 1.0' in metrics.METRICS.text()
    assert "could not be uploaded in time" in capfd.readouterr().err


def test_an_upload_that_the_server_forgot_begins_again(tmp_path, images, server, started):
    server.problem = NotFoundError(404, "not-found", "")
    gateway = started(tmp_path)
    send(gateway, images)
    wait_until(lambda: server.keys, 30, "an attempt")
    server.problem = None
    wait_until(lambda: server.delivered, 30, "the upload")
    assert server.delivered == [complete(images)]
    assert server.keys[-1] not in server.keys[:-1]


def test_the_disk_keeps_a_reserve(tmp_path, images, server, started, monkeypatch):
    gateway = started(tmp_path, quiet=1000)
    usage = type(shutil.disk_usage(tmp_path))
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(1 << 40, 1 << 39, limits.DISK_RESERVE_BYTES + 100))
    with pytest.raises(ArchiveError) as refused:
        gateway.add(SENDER, images[0])
    assert refused.value.kind == "no-room"


def test_a_full_spool_refuses_images_and_keeps_those_before(tmp_path, images, server, started):
    fits = len(complete(images[:4]))
    gateway = started(tmp_path, most=fits)
    with pytest.raises(ArchiveError) as refused:
        send(gateway, images)
    assert refused.value.kind == "no-room"
    assert 0 < gateway.spool.used <= fits
    wait_until(lambda: server.delivered, 30 + QUIET * limits.RESEND_FACTOR, "the upload")
    assert server.delivered == [complete(images[:4])]
    wait_until(lambda: gateway.spool.used == 0, 10, "an empty spool")
    gateway.add(SENDER, images[4])


def test_a_disk_that_fills_up_in_an_image_damages_no_other(tmp_path, images, server, started, monkeypatch):
    gateway, real = started(tmp_path, quiet=1000), os.pwrite
    gateway.add(SENDER, images[0])

    def full(file: int, data: memoryview, at: int) -> int:
        if len(data) > 1000:
            real(file, data[:1000], at)
            raise OSError(errno.ENOSPC, "no space")
        return real(file, data, at)

    monkeypatch.setattr(os, "pwrite", full)
    with pytest.raises(ArchiveError) as refused:
        gateway.add(SENDER, images[1])
    assert refused.value.kind == "no-room"
    monkeypatch.setattr(os, "pwrite", real)
    send(gateway, images[1:])
    started(tmp_path)
    wait_until(lambda: server.delivered, 30, "the upload")
    assert server.delivered == [complete(images)]


def test_what_a_kill_cut_off_is_left_out(tmp_path, images, server, started):
    gateway = started(tmp_path, quiet=1000)
    send(gateway, images[:4])
    [lines] = tmp_path.glob("*/series.jsonl")
    [tar] = tmp_path.glob("*/series.tar")
    lines.write_bytes(lines.read_bytes()[:-5])
    tar.write_bytes(tar.read_bytes() + b"half an image")
    started(tmp_path)
    wait_until(lambda: server.delivered, 30, "the upload")
    assert server.delivered == [complete(images[:3])]


def test_the_token_of_a_device_is_not_in_the_spool(tmp_path, images, server, started, monkeypatch):
    device, seen = Sender("dimse", "CT1", "the-old-token"), []
    gateway = started(tmp_path, quiet=1000)
    send(gateway, images, device)
    assert not any(b"the-old-token" in path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())
    monkeypatch.setattr(uploads, "deliver", lambda _url, token, *_: seen.append(token))
    started(tmp_path, callers={"CT1": "the-new-token"})
    wait_until(lambda: seen, 30, "the upload")
    assert seen == ["the-new-token"]


def test_the_spool_is_private_and_holds_no_patient_data(tmp_path, images, server, started):
    gateway = started(tmp_path / "spool", quiet=1000)
    send(gateway, images)
    names = [str(images[0].PatientName).split("^")[0], str(images[0].StudyInstanceUID), str(images[0].SeriesInstanceUID)]
    assert (tmp_path / "spool").stat().st_mode & 0o777 == 0o700
    for path in (tmp_path / "spool").rglob("*"):
        assert path.stat().st_mode & 0o077 == 0 or path.name == "lock", path
        if path.name == "series.jsonl":
            assert not [name for name in names if f'"{name}' in path.read_text()]
        elif path.is_file():
            assert not [name for name in names if len(name) > 4 and name.encode() in path.read_bytes()]


def test_only_one_gateway_uses_a_spool(tmp_path):
    first = Spool(tmp_path, 1, KEY)
    with pytest.raises(SpoolError, match="another gateway"):
        Spool(tmp_path, 1, KEY)
    first.close()
    Spool(tmp_path, 1, KEY).close()


def test_the_age_of_the_oldest_series_is_a_metric(tmp_path, images, server, started, monkeypatch):
    gateway = started(tmp_path, quiet=1000)
    assert b"diaphane_pacs_spool_oldest_seconds 0.0" in metrics.METRICS.text()
    gateway.add(SENDER, images[0])
    now = time.time()
    monkeypatch.setattr(intake.time, "time", lambda: now + 5000)
    [age] = [line.split()[1] for line in metrics.METRICS.text().decode().splitlines() if line.startswith("diaphane_pacs_spool_oldest_seconds ")]
    assert 5000 <= float(age) < 5000 + 3600
