"""What others send: C-STORE from a device, and STOW-RS with an API token. Each series becomes a scan of the account."""

from __future__ import annotations

import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx
import phantom
import pydicom
import pytest
from api_client import person
from archives import CALLER, open_stack, phantom_folder
from canaries import Search
from orthanc import Orthanc
from pacs_helpers import audit, give_token, radiologist, wait_ready

BOUNDARY = "a-boundary"
MULTIPART = f'multipart/related; type="application/dicom"; boundary={BOUNDARY}'


@pytest.fixture(scope="module")
def stack(all_stacks):
    running = open_stack(all_stacks, [])
    yield running
    all_stacks.shut(running)


@pytest.fixture(scope="module")
def folder(all_stacks) -> Path:
    return phantom_folder(all_stacks)


@pytest.fixture(scope="module")
def device(stack):
    """The user to whose account the device SCANNER1 sends."""
    who = radiologist(stack)
    give_token(stack, who, "write archive", stack.caller_token)
    return who


def storescu(stack, folder: Path, caller: str = CALLER, called: str = "DIAPHANE", *more: str) -> subprocess.CompletedProcess:
    return subprocess.run(["storescu", "-aet", caller, "-aec", called, *more, "127.0.0.1", str(stack.receiver_port), "+sd", str(folder)],
                          capture_output=True, text=True, timeout=120)


@contextmanager
def association(stack, folder: Path):
    """Keeps an association of the device open, so that none of its series is complete."""
    said = folder / "echo.txt"
    with said.open("w") as out, subprocess.Popen(["echoscu", "-v", "--repeat", "10000000", "-aet", CALLER, "-aec", "DIAPHANE", "127.0.0.1",
                                                  str(stack.receiver_port)], stdout=out, stderr=out) as held:
        stack.wait_until(lambda: "Association Accepted" in said.read_text(), what="the association")
        yield
        held.kill()


def scans(who) -> list[dict]:
    return [one for one in who.http.get("/v1/data-sets").json()["items"] if one["role"] == "owner"]


def changed(folder: Path, into: Path, change, only: int = 0) -> Path:
    """Writes changed copies of the slices."""
    into.mkdir(exist_ok=True)
    for path in sorted(folder.glob("*.dcm"))[:only or None]:
        image = pydicom.dcmread(path)
        change(image)
        pydicom.dcmwrite(into / path.name, image, enforce_file_format=False)
    return into


def stow(stack, token: str, files: list[bytes], content_type: str = MULTIPART, kind: str = "application/dicom", chunked: bool = False,
         slowly: Callable[[Iterator[bytes]], Iterator[bytes]] | None = None) -> httpx.Response:
    body = b"".join(f"\r\n--{BOUNDARY}\r\nContent-Type: {kind}\r\n\r\n".encode() + data for data in files) + f"\r\n--{BOUNDARY}--\r\n".encode()
    pieces = (body[at:at + 50_000] for at in range(0, len(body), 50_000))
    if slowly:
        pieces, chunked = slowly(pieces), True
    return httpx.post(f"{stack.url}/dicom-web/studies", content=pieces if chunked else body, trust_env=False, timeout=120,
                      headers={"Authorization": f"Bearer {token}", "Content-Type": content_type})


def test_a_series_that_a_device_stores_becomes_a_scan_without_patient_data(stack, device, folder):
    begun, before = time.time(), len(scans(device))
    assert subprocess.run(["echoscu", "-aet", CALLER, "-aec", "DIAPHANE", "127.0.0.1", str(stack.receiver_port)], timeout=60).returncode == 0
    done = storescu(stack, folder)
    assert done.returncode == 0, done.stderr
    stack.wait_until(lambda: len(scans(device)) > before, what="the scan")
    [scan] = scans(device)[:1]
    wait_ready(stack, scan["id"])
    assert scans(device)[0]["state"] == "ready"
    assert audit(stack, "archive.received")[-1]["via"] == "dimse"
    assert Search(["Phantasia", "Canary"], begun).in_stack(stack) == []


def test_two_series_in_two_associations_become_two_scans(stack, device, folder, tmp_path):
    before = len(scans(device))
    first = changed(folder, tmp_path / "a", lambda image: setattr(image, "SeriesInstanceUID", "1.2.3.4"))
    halves = [tmp_path / "b", tmp_path / "c"]
    second = changed(folder, tmp_path / "whole", lambda image: setattr(image, "SeriesInstanceUID", "1.2.3.5"))
    for at, half in enumerate(halves):
        half.mkdir()
        for path in sorted(second.glob("*.dcm"))[20 * at:20 * at + 20]:
            shutil.copy(path, half)
    with association(stack, tmp_path):
        for one in (first, *halves):
            assert storescu(stack, one).returncode == 0
    stack.wait_until(lambda: len(scans(device)) == before + 2, what="both scans")
    sizes = []
    for scan in scans(device)[:2]:
        wait_ready(stack, scan["id"])
        sizes.append(device.http.get(f"/v1/data-sets/{scan['id']}").json()["volume"]["size"][2])
    assert sizes == [phantom.SLICES, phantom.SLICES], "the halves belong together"


def test_unknown_devices_are_rejected(stack, device, folder):
    before = len(scans(device))
    assert "Rejected" in storescu(stack, folder, "STRANGER").stderr
    assert "Rejected" in storescu(stack, folder, CALLER, "OTHER").stderr
    assert len(scans(device)) == before and "an association was rejected" in stack.log("pacs")


def test_what_cannot_become_a_volume_is_refused_with_a_status(stack, device, folder, tmp_path):
    before = len(scans(device))

    def without_pixels(image) -> None:
        image.SeriesInstanceUID = "1.2.3.6"
        del image.PixelData

    refused = storescu(stack, changed(folder, tmp_path / "pixels", without_pixels, only=1), CALLER, "DIAPHANE", "-v")
    assert "DataSetDoesNotMatchSOPClass" in refused.stderr, refused.stderr
    few = changed(folder, tmp_path / "few", lambda image: setattr(image, "SeriesInstanceUID", "1.2.3.7"), only=2)
    assert storescu(stack, few).returncode == 0
    stack.wait_until(lambda: "a received series of 2 images is not a volume" in stack.log("pacs"), what="the log line")
    assert len(scans(device)) == before


def test_a_device_whose_account_lost_the_access_is_told(stack, device, folder):
    before = len(scans(device))
    stack.psql("UPDATE users SET archive_access = false WHERE email = %s", device.email)
    try:
        assert "0x124" in storescu(stack, folder, CALLER, "DIAPHANE", "-v").stderr
    finally:
        stack.psql("UPDATE users SET archive_access = true WHERE email = %s", device.email)
    assert len(scans(device)) == before
    assert 'diaphane_pacs_failures_total{archive="SCANNER1",operation="dimse",reason="unauthorised"}' in \
        httpx.get(f"http://127.0.0.1:{stack.ports['pacs']}/metrics", trust_env=False).text


def test_a_device_whose_account_is_full_is_told(stack, device, folder, tmp_path):
    before = len(scans(device))
    quota = stack.psql("SELECT quota_bytes FROM users WHERE email = %s", device.email)[0][0]
    used = device.http.get("/v1/me").json()["quota"]["used_bytes"]
    stack.psql("UPDATE users SET quota_bytes = %s WHERE email = %s", used + 100_000, device.email)
    try:
        other = changed(folder, tmp_path / "other", lambda image: setattr(image, "SeriesInstanceUID", "1.2.3.9"))
        assert "OutOfResources" in storescu(stack, other, CALLER, "DIAPHANE", "-v").stderr.replace(" ", "")
    finally:
        stack.psql("UPDATE users SET quota_bytes = %s WHERE email = %s", quota, device.email)
    assert len(scans(device)) == before


def test_stow_makes_a_scan_per_series_and_names_what_failed(stack, folder, tmp_path):
    who, begun = radiologist(stack), time.time()
    token = give_token(stack, who, "write archive")
    files = [path.read_bytes() for path in sorted(folder.glob("*.dcm"))]
    answer = stow(stack, token, files)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/dicom+json"
    assert len(answer.json()["00081199"]["Value"]) == phantom.SLICES and "00081198" not in answer.json()
    stack.wait_until(lambda: scans(who), what="the scan")
    [scan] = scans(who)
    wait_ready(stack, scan["id"])
    assert scans(who)[0]["state"] == "ready"

    def ultrasound(image) -> None:
        image.SeriesInstanceUID, image.Modality = "1.2.3.8", "US"

    others = [path.read_bytes() for path in sorted(changed(folder, tmp_path / "us", ultrasound, only=2).glob("*.dcm"))]
    mixed = stow(stack, token, [*files, *others])
    assert mixed.status_code == 202 and len(mixed.json()["00081198"]["Value"]) == 2
    assert mixed.json()["00081198"]["Value"][0]["00081197"]["Value"] == [0xA900]
    assert stow(stack, token, others).status_code == 409
    stack.wait_until(lambda: len(scans(who)) == 2, what="the second scan")
    assert [one["via"] for one in audit(stack, "archive.received")].count("stow") == 2
    assert Search(["Phantasia", "Canary"], begun).in_stack(stack) == []


def test_a_series_in_several_stow_requests_becomes_one_scan(stack, folder):
    who = radiologist(stack)
    token = give_token(stack, who, "write archive")
    files = [path.read_bytes() for path in sorted(folder.glob("*.dcm"))]
    last, begun = threading.Event(), threading.Event()

    def slowly(pieces):
        yield next(pieces)
        begun.set()
        last.wait(60)
        yield from pieces

    # A request that lasts longer than all others, so that the series cannot be complete before them.
    with ThreadPoolExecutor(1) as pool:
        held = pool.submit(stow, stack, token, files[:10], slowly=slowly)
        begun.wait(60)
        stack.wait_until(lambda: list((stack.data_dir / "spool").glob("*/series.tar")), what="the first images")
        for at in range(10, len(files), 10):
            assert stow(stack, token, files[at:at + 10]).status_code == 200
        last.set()
        assert held.result().status_code == 200
    stack.wait_until(lambda: scans(who), what="the scan")
    [scan] = scans(who)
    wait_ready(stack, scan["id"])
    assert who.http.get(f"/v1/data-sets/{scan['id']}").json()["volume"]["size"][2] == phantom.SLICES


def test_a_chunked_body_is_stored(stack, folder):
    who = radiologist(stack)
    answer = stow(stack, give_token(stack, who, "write archive"), [path.read_bytes() for path in sorted(folder.glob("*.dcm"))], chunked=True)
    assert answer.status_code == 200 and len(answer.json()["00081199"]["Value"]) == phantom.SLICES, answer.text
    stack.wait_until(lambda: scans(who), what="the scan")


def test_stow_needs_a_token_with_both_scopes_of_a_user_with_access(stack, folder):
    who = radiologist(stack)
    files = [path.read_bytes() for path in sorted(folder.glob("*.dcm"))]
    assert stow(stack, "diaphane_" + "0" * 64, files).status_code == 403
    assert stow(stack, give_token(stack, who, "write"), files).status_code == 403
    assert stow(stack, give_token(stack, person(stack), "write archive"), files).status_code == 403
    assert stow(stack, give_token(stack, who, "archive"), files).status_code == 403
    assert scans(who) == []


def test_malformed_stow_requests_are_refused(stack, folder):
    token = give_token(stack, radiologist(stack), "write archive")
    data = sorted(folder.glob("*.dcm"))[0].read_bytes()
    assert stow(stack, token, [data], content_type="application/dicom").status_code == 400
    assert stow(stack, token, [b"no DICOM"]).status_code == 400
    assert stow(stack, token, [data], kind="image/jpeg").status_code == 400
    url = f"{stack.url}/dicom-web/studies"
    headers = {"Authorization": f"Bearer {token}", "Content-Type": MULTIPART}
    assert httpx.post(url, content=iter([b"chunked"]), headers=headers, trust_env=False).status_code == 400
    assert httpx.get(url, headers=headers, trust_env=False).status_code == 405


def test_a_full_quota_refuses_what_is_stowed(stack, folder):
    who = radiologist(stack)
    stack.psql("UPDATE users SET quota_bytes = 1000 WHERE email = %s", who.email)
    answer = stow(stack, give_token(stack, who, "write archive"), [path.read_bytes() for path in sorted(folder.glob("*.dcm"))])
    assert answer.status_code == 409
    assert answer.json()["00081198"]["Value"][0]["00081197"]["Value"] == [0xA700]


def test_orthanc_sends_by_dimse_and_by_stow(all_stacks, stack, device, folder):
    who = radiologist(stack)
    token = give_token(stack, who, "write archive")
    with Orthanc(all_stacks, {"diaphane": ["DIAPHANE", "127.0.0.1", stack.receiver_port]}, ae_title=CALLER,
                 servers={"diaphane": {"Url": f"{stack.url}/dicom-web/", "HttpHeaders": {"Authorization": f"Bearer {token}"}}}) as orthanc:
        orthanc.store(folder)
        [study] = orthanc.http.get("/studies").json()
        before = len(scans(device))
        orthanc.http.post("/modalities/diaphane/store", content=study).raise_for_status()
        stack.wait_until(lambda: len(scans(device)) == before + 1, what="the scan of the device")
        answer = orthanc.http.post("/dicom-web/servers/diaphane/stow", json={"Resources": [study], "Synchronous": True})
        assert answer.is_success, (answer.text, (orthanc.folder / "orthanc.log").read_text(errors="replace")[-1500:])
        stack.wait_until(lambda: len(scans(who)) == 1, what="the scan of the token's user")
