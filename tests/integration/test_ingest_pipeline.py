"""ingestd with a real queue: uploads become volumes or refusals, and originals are always deleted."""

from __future__ import annotations

import io
import json
import struct
import subprocess

import pytest
from ingest_helpers import (BIRTH_DATE, CANARY, bundle, cranium, enqueue, hiding_places, nothing_left, state, tool,
                         upload_path, volume_path, wait_end)

from harness import REPO  # noqa: F401  (puts tools/ on the path)
from devtool.ingest_cases import phantom

PROGRAMS = ("postgres", "redis", "api", "ingestd")


@pytest.fixture(scope="module")
def ingest(all_stacks):
    running = all_stacks.open(only=PROGRAMS)
    yield running
    all_stacks.shut(running)


@pytest.fixture(scope="module")
def head(ingest, tmp_path_factory) -> list[bytes]:
    return cranium(ingest, tmp_path_factory.mktemp("cranium"))


def refusal(stack, data: bytes) -> tuple[str, str]:
    data_set = enqueue(stack, data)
    ended, code, text = wait_end(stack, data_set)
    assert ended == "refused"
    nothing_left(stack, data_set)
    assert not volume_path(stack, data_set).exists()
    assert text.endswith(".") and len(text) > 15
    return code, text


def test_an_uploaded_series_becomes_a_volume_and_its_original_is_deleted(ingest, head):
    data_set = enqueue(ingest, bundle(head))
    assert wait_end(ingest, data_set) == ("ready", None, None)
    nothing_left(ingest, data_set)
    row = ingest.psql("SELECT modality, size_x, size_y, size_z, spacing_x, spacing_y, spacing_z, repairs, volume_bytes"
                      " FROM data_sets WHERE id = %s", data_set)[0]
    assert row[:4] == ("CT", 256, 256, 108)
    assert row[4:7] == pytest.approx((0.957031, 0.957031, 1.5))
    assert row[7:] == ([], 256 * 256 * 108 * 2)
    voxels = (volume_path(ingest, data_set) / "voxels.i16").read_bytes()
    header = json.loads((volume_path(ingest, data_set) / "volume.json").read_text())
    assert len(voxels) == row[8]
    assert header["contentHash"].startswith("blake2b:")
    # The nose points to the front (low y): at its height, the head begins nearer to y = 0 than behind it.
    values = struct.unpack_from("<256h", voxels, 2 * 256 * (256 * 35 + 40))
    assert max(values) > -300, "at y = 40 of slice 35 is the nose"
    behind = struct.unpack_from("<256h", voxels, 2 * 256 * (256 * 35 + 10))
    assert max(behind) < -300, "before the nose is air"
    ingest.wait_until(lambda: ingest.psql("SELECT count(*) FROM disposals WHERE id = %s", data_set) == [(0,)], what="the removal of the original")
    # Counted just after the row says that it is ready.
    ingest.wait_until(lambda: 'diaphane_ingest_jobs_total{result="ready"} ' in ingest.metrics("ingestd"), what="the metric")
    assert "diaphane_ingest_build_seconds_count" in ingest.metrics("ingestd")


@pytest.mark.parametrize("packed", [False, True], ids=["a file a slice", "enhanced"])
def test_a_tilted_series_is_straightened_in_the_sandbox(ingest, packed):
    """VTK's filter works although no thread may start, and the row describes its result."""
    slices = phantom.stack(20, tilt=15.0)
    if packed:
        files = [phantom.enhanced(phantom.Series(phantom.ENHANCED_CT), slices)]
    else:
        files = [phantom.dataset(phantom.Series(), one) for one in slices]
    data_set = enqueue(ingest, bundle([written(ds) for ds in files]))
    assert wait_end(ingest, data_set) == ("ready", None, None)
    nothing_left(ingest, data_set)
    row = ingest.psql("SELECT size_x, size_y, size_z, repairs FROM data_sets WHERE id = %s", data_set)[0]
    assert row == (24, 20 + 13, 20, ["gantry tilt of 15.0 degrees corrected"])
    header = json.loads((volume_path(ingest, data_set) / "volume.json").read_text())
    assert header["minimum"] > -1024, "the corners beside the slices are not values of the scan"


def written(ds) -> bytes:
    out = io.BytesIO()
    ds.save_as(out, enforce_file_format=True)
    return out.getvalue()


def test_no_patient_data_is_kept(ingest, head):
    data_set = enqueue(ingest, bundle(head))
    cut = enqueue(ingest, bundle(head[:3]))
    assert wait_end(ingest, data_set)[0] == "ready"
    assert wait_end(ingest, cut)[0] == "refused"
    assert any(CANARY.encode() in file for file in head), "the search would find nothing anyway"
    dump = subprocess.run(["/usr/lib/postgresql/15/bin/pg_dump", "--inserts", ingest.dsn], capture_output=True, check=True)
    assert len(dump.stdout) > 5000
    (ingest.data_dir / "scratch-dump").mkdir(exist_ok=True)
    (ingest.data_dir / "scratch-dump" / "dump.sql").write_bytes(dump.stdout)
    for secret in (CANARY, BIRTH_DATE, "Mustermann"):
        assert hiding_places(ingest.data_dir, secret) == []


def test_the_search_for_patient_data_finds_every_form(tmp_path):
    import base64
    for number, form in enumerate([CANARY.encode(), CANARY.encode("utf-16-le"), CANARY.encode("utf-16-be"),
                                   CANARY.encode().hex().encode(), base64.b64encode(b"x" + CANARY.encode() + b"yz"),
                                   base64.b64encode(b"xy" + CANARY.encode()), base64.b64encode(CANARY.encode())]):
        place = tmp_path / str(number)
        place.mkdir()
        (place / "file").write_bytes(b"before" + form + b"behind")
        assert hiding_places(place, CANARY), number


def test_bad_uploads_are_refused_with_a_message(ingest, head):
    assert refusal(ingest, bundle([]))[0] == "empty"
    assert refusal(ingest, bundle([b"no picture at all " * 50] * 20))[0] == "not_dicom"
    assert refusal(ingest, bundle(head[:3]))[0] == "too_few_slices"
    hole = range(50, 54)  # one more missing slice than is interpolated
    assert refusal(ingest, bundle([file for n, file in enumerate(head) if n not in hole]))[0] == "missing_slices"
    code, text = refusal(ingest, bundle([file if n not in hole else file[:5000] for n, file in enumerate(head)]))
    assert code == "missing_slices" and "damaged" in text
    assert refusal(ingest, b"this is no tar " * 1000)[0] == "damaged"
    assert refusal(ingest, bundle(head)[:200000])[0] == "damaged"


def test_a_tiny_file_that_claims_an_enormous_picture_is_refused(ingest):
    def element(group, number, kind, value):
        return struct.pack("<HH2sH", group, number, kind, len(value)) + value
    claim = (b"\0" * 128 + b"DICM" + element(2, 0x10, b"UI", b"1.2.840.10008.1.2.1\0")
             + element(8, 0x16, b"UI", b"1.2.840.10008.5.1.4.1.1.2\0")
             + element(0x28, 2, b"US", b"\1\0") + element(0x28, 4, b"CS", b"MONOCHROME2 ")
             + element(0x28, 0x10, b"US", b"\xff\xff") + element(0x28, 0x11, b"US", b"\xff\xff")
             + element(0x28, 0x100, b"US", b"\x10\0") + element(0x28, 0x101, b"US", b"\x10\0")
             + struct.pack("<HH2sHI", 0x7FE0, 0x10, b"OW", 0, 2) + b"\0\0")
    assert len(claim) < 300
    assert refusal(ingest, bundle([claim] * 20))[0] == "too_large"


def test_an_upload_with_a_missing_file_is_refused_after_a_while(ingest, head):
    data_set = enqueue(ingest, bundle([]))
    upload_path(ingest, data_set).unlink(missing_ok=True)
    # ingestd may have opened the file before.
    ingest.wait_until(lambda: state(ingest, data_set)[0] == "refused" or ingest.psql(
        "SELECT waiting_for FROM ingest_jobs WHERE data_set_id = %s", data_set) == [("service",)], what="it waits, or is refused")

    def given_up() -> bool:
        # Both workers must find other uploads in the directory before they trust it.
        for found in [enqueue(ingest, b"x") for _ in range(2)]:
            wait_end(ingest, found)
        ingest.psql("UPDATE ingest_jobs SET waits = 100, not_before = now() WHERE data_set_id = %s", data_set)
        return state(ingest, data_set)[0] == "refused"

    ingest.wait_until(given_up, what="the refusal")
    assert wait_end(ingest, data_set)[1] in ("upload_gone", "empty")


def test_a_bad_upload_does_not_affect_others(ingest, head):
    sets = [enqueue(ingest, data) for data in (bundle(head), b"\xff" * 5000, bundle(head))]
    assert [wait_end(ingest, s)[0] for s in sets] == ["ready", "refused", "ready"]


def test_deleting_a_data_set_during_its_build_leaves_nothing(ingest, head):
    data_set = enqueue(ingest, bundle(head))
    ingest.wait_until(lambda: state(ingest, data_set)[0] in ("building", "ready"))
    ingest.psql("DELETE FROM data_sets WHERE id = %s", data_set)
    ingest.psql("INSERT INTO disposals (kind, id) VALUES ('upload', %s), ('volume', %s)"
                " ON CONFLICT DO NOTHING", data_set, data_set)
    ingest.wait_until(lambda: not volume_path(ingest, data_set).exists() and not upload_path(ingest, data_set).exists())
    nothing_left(ingest, data_set)


def test_ingest_continues_after_an_outage_of_postgres(ingest, head):
    def losses() -> int:
        return ingest.log("ingestd").count("postgres_unavailable")

    before = losses()
    ingest.stop("postgres")
    ingest.wait_until(lambda: losses() >= before + 2, what="the notice of both workers")
    ingest.start("postgres")
    ingest.wait_ready("postgres")
    data_set = enqueue(ingest, bundle(head))
    assert wait_end(ingest, data_set)[0] == "ready"
    assert losses() == before + 2, "each of the two workers says it once"


def test_all_bad_settings_are_reported_together(ingest):
    done = subprocess.run([tool(ingest, "diaphane-ingestd"), "--admin-port", "0", "--upload-dir", "/nowhere"],
                          capture_output=True, text=True)
    assert done.returncode == 78
    for name in ("postgres", "upload-dir", "volume-dir", "scratch-dir", "admin-port"):
        assert f"--{name}" in done.stderr


def test_the_sample_is_processed_like_any_upload(ingest):
    url = f"http://127.0.0.1:{ingest.ports['api']}"
    command = [tool(ingest, "diaphane-sample"), "--upload", url, "--token-file", str(ingest.sample_token_file)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    data_set = done.stdout.strip()
    rows = ingest.psql("SELECT state, is_sample, visibility = 'public', owner_id, size_z FROM data_sets WHERE id = %s", data_set)
    assert rows == [("ready", True, True, None, 108)]
    wait_end(ingest, data_set)    # its original is deleted just after it is ready
    nothing_left(ingest, data_set)
    (ingest.data_dir / "secrets" / "wrong").write_text("0" * 64)
    command[-1] = str(ingest.data_dir / "secrets" / "wrong")
    wrong = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert wrong.returncode == 65 and wrong.stderr.startswith("diaphane-sample: ")
