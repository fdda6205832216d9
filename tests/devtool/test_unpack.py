"""Archives as input of command-line tools."""

from __future__ import annotations

import io
import os
import tarfile
import zipfile
from pathlib import Path

import pytest

from devtool import unpack
from devtool.console import CliError

FILES = {"DICOM/IM1": b"first" * 1000, "DICOM/SUB/IM2": os.urandom(5000), "README": b"hello"}


def zipped(files: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as into:
        for name, content in files.items():
            into.writestr(name, content)
    return out.getvalue()


def tarred(files: dict[str, bytes], mode: str = "w") -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode=mode) as into:
        for name, content in files.items():
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            into.addfile(entry, io.BytesIO(content))
    return out.getvalue()


def contents(tmp_path: Path, archive: bytes) -> list[bytes]:
    path = tmp_path / "archive"
    path.write_bytes(archive)
    with unpack.unpacked(["--json", str(path)]) as (option, folder):
        assert option == "--json"
        found = sorted(file.read_bytes() for file in Path(folder).iterdir())
    assert not Path(folder).exists()
    return found


@pytest.mark.parametrize("archive", [
    zipped(FILES), zipped(FILES, zipfile.ZIP_STORED), tarred(FILES), tarred(FILES, "w:gz"), tarred(FILES, "w:xz"),
    tarred({"inner.zip": zipped({"again.zip": zipped(FILES)})}),
], ids=["zip", "stored", "tar", "tar.gz", "tar.xz", "nested"])
def test_an_archive_gives_its_files(tmp_path, archive):
    assert contents(tmp_path, archive) == sorted(FILES.values())


def test_names_lead_nowhere(tmp_path):
    files = {"../../outside": b"1", "/etc/absolute": b"2", "a" * 200 + "/" + "b" * 200: b"3"}
    for archive in (zipped(files), tarred(files)):
        assert contents(tmp_path, archive) == [b"1", b"2", b"3"]
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as into:
        link = tarfile.TarInfo("link")
        link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
        into.addfile(link)
    assert contents(tmp_path, out.getvalue()) == []


def test_folders_and_other_files_stay_as_they_are(tmp_path):
    (tmp_path / "image.nii.gz").write_bytes(b"\x1f\x8b\x08\0rest")
    (tmp_path / "program.jar").write_bytes(zipped({"META-INF/MANIFEST.MF": b"x"}))
    given = [str(tmp_path), str(tmp_path / "image.nii.gz"), str(tmp_path / "program.jar"), "--build", str(tmp_path / "nowhere")]
    with unpack.unpacked(given) as got:
        assert got == given


def refusal(tmp_path: Path, archive: bytes) -> str:
    with pytest.raises(CliError) as refused:
        contents(tmp_path, archive)
    return str(refused.value)


def test_what_cannot_be_unpacked_is_explained(tmp_path, monkeypatch):
    good = zipped(FILES)
    locked = bytearray(good)
    for signature, flags in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        locked[locked.index(signature) + flags] |= 1
    assert "password" in refusal(tmp_path, bytes(locked))
    unknown = bytearray(good)
    for signature, method in ((b"PK\3\4", 8), (b"PK\1\2", 10)):
        unknown[unknown.index(signature) + method] = 9    # Deflate64
    assert "cannot unpack" in refusal(tmp_path, bytes(unknown))
    assert "cannot unpack" in refusal(tmp_path, b"Rar!\x1a\x07\1\0" + bytes(100))
    for damaged in (good[:len(good) // 2], tarred(FILES, "w:gz")[:4000], tarred(FILES)[:6000]):
        assert "damaged" in refusal(tmp_path, damaged)
    changed = bytearray(good)
    changed[60] ^= 0x10
    assert "damaged" in refusal(tmp_path, bytes(changed))
    deep = good
    for _ in range(unpack.MOST_NESTED):
        deep = zipped({"inner.zip": deep})
    assert "archives within archives" in refusal(tmp_path, deep)
    monkeypatch.setattr(unpack, "MOST_BYTES", 5000)
    assert "more than" in refusal(tmp_path, zipped({"zeros": bytes(5001)}))
    monkeypatch.setattr(unpack, "MOST_FILES", 2)
    assert "more than" in refusal(tmp_path, good)
