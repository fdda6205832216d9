"""The pure parts of the PACS gateway: its settings, the parser of multipart bodies, and what becomes of results."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest
from diaphane_pacs import jobs, limits, multipart, results, settings
from diaphane_pacs.errors import ArchiveError
from diaphane_pacs.settings import SettingsError

EXAMPLE = Path(__file__).resolve().parents[2] / "pacs" / "archives.example.toml"
FILES = [b"first \r\n--not the boundary", b"", b"\r\n--x" * 50, bytes(range(256))]


def body(files: list[bytes], kind: str = "application/dicom", end: bytes = b"--") -> bytes:
    return b"".join(b"\r\n--edge\r\nContent-Type: " + kind.encode() + b"\r\n\r\n" + data for data in files) + b"\r\n--edge" + end + b"\r\n"


@pytest.mark.parametrize("size", [1, 2, 3, 7, 64, 10_000])
def test_parts_are_the_same_however_the_body_arrives(size):
    whole = body(FILES)
    pieces = [whole[at:at + size] for at in range(0, len(whole), size)]
    assert list(multipart.parts(pieces, b"edge")) == FILES
    assert list(multipart.parts([whole[2:]], b"edge")) == FILES, "without the first line break"


def test_a_body_that_is_cut_off_yields_only_complete_parts():
    whole = body(FILES)
    got = []
    with pytest.raises(ArchiveError, match="cut off"):
        for part in multipart.parts([whole[:-40]], b"edge"):
            got.append(part)
    assert got == FILES[:len(got)] and got


def test_parts_are_limited():
    with pytest.raises(ArchiveError, match="larger than an image"):
        list(multipart.parts([body([b"x" * 20_000])], b"edge", most=10_000))
    with pytest.raises(ArchiveError, match="larger than a series"):
        list(multipart.parts([body(FILES)], b"edge", total=100))
    with pytest.raises(ArchiveError, match="not a DICOM file"):
        list(multipart.parts([body([b"x"], "text/html")], b"edge"))
    with pytest.raises(ArchiveError, match="no valid header"):
        list(multipart.parts([b"--edge\r\nno header\r\n--edge--\r\n"], b"edge"))


@pytest.mark.parametrize("header, boundary", [
    ('multipart/related; type="application/dicom"; boundary=a-b', b"a-b"), ('Multipart/Related;boundary="a b"', b"a b")])
def test_the_boundary_is_read(header, boundary):
    assert multipart.boundary_of(header) == boundary


@pytest.mark.parametrize("header", ["", "text/html", "multipart/form-data; boundary=a", "multipart/related", "multipart/related; myboundary=a"])
def test_other_types_are_refused(header):
    with pytest.raises(ArchiveError):
        multipart.boundary_of(header)


@pytest.fixture
def secrets(tmp_path) -> Path:
    (tmp_path / "pacs-password").write_text("secret\n")
    (tmp_path / "ct1-token").write_text("diaphane_" + "0" * 64)
    return tmp_path


def parsed(text: str, folder: Path) -> settings.Settings:
    path = folder / "archives.toml"
    path.write_text(text, encoding="utf-8")
    return settings.read(path)


def test_the_example_is_valid_also_with_everything_that_is_commented_out(secrets):
    known = parsed(EXAMPLE.read_text(encoding="utf-8"), secrets)
    web, dimse = known.archives.values()
    assert isinstance(web, settings.WebArchive) and (web.user, web.secret, web.timeout) == ("diaphane", "secret", limits.IDLE_SECONDS)
    assert isinstance(dimse, settings.DimseArchive) and (dimse.host, dimse.port) == ("10.0.0.2", 104)
    assert known.receiver and list(known.receiver.callers) == ["CT1"]


@pytest.mark.parametrize("wrong, field", [
    ("[[archive]]\nname = 'a'\ntitle = 'A'", "host"),
    ("[[archive]]\nname = 'A b'\ntitle = 'A'\nurl = 'https://x'", "name"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nurl = 'ftp://x'", "url"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nurl = 'https://me:secret@x'", "url"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nurl = 'https://x'\npassword = 'secret'", "password"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nurl = 'https://x'\ntoken_file = 'missing'", "missing"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nhost = 'x'\nport = 0\nae_title = 'X'", "port"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nhost = 'x'\nport = 104\nae_title = 'MORE THAN SIXTEEN'", "ae_title"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nurl = 'https://x'\n" * 2, "same name"),
    ("[receiver]\nport = 11112", "caller"),
    ("[receiver]\nport = 11112\n[[receiver.caller]]\nae_title = 'CT1'", "caller"),
    ("[receiver]\nport = 11112\ntls = {ca_file = 'x'}\n[[receiver.caller]]\nae_title = 'CT1'\ntoken_file = 'ct1-token'", "certificate_file"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nhost = 'x'\nport = 104\nae_title = 'X'\nretrieve = 'move'", "retrieve"),
    ("[[archive]]\nname = 'a'\ntitle = 'A'\nhost = 'x'\nport = 104\nae_title = 'X'\nretrieve = 'put'", "retrieve"),
    ("archives = []", "archives"),
    ("[[archive", "cannot read"),
])
def test_a_mistake_in_the_settings_is_reported_by_its_field(secrets, wrong, field):
    with pytest.raises(SettingsError, match=field):
        parsed(wrong, secrets)


def test_an_archive_with_move_sends_to_the_receiver_which_needs_no_caller_then(secrets):
    known = parsed("[[archive]]\nname = 'a'\ntitle = 'A'\nhost = 'x'\nport = 104\nae_title = 'PACS'\nretrieve = 'move'\n"
                   "[receiver]\nport = 11112\nae_title = 'HERE'", secrets)
    assert known.archives["a"].move_to == "HERE" and known.receiver.movers == {"PACS"}


def test_a_name_is_searched_from_its_start():
    assert results.Search(patient_name="Doe").query() == {"PatientName": "Doe*"}
    assert results.Search(patient_name="Doe, Ja").query() == {"PatientName": "Doe**Ja*"}
    assert results.Search(since="2026-01-02").query() == {"StudyDate": "20260102-"}
    with pytest.raises(ArchiveError):
        results.Search.of({"patient_name": "Doe\\*"})


def series(uid: str, images: int, modality: str = "CT") -> dict:
    return {"0020000E": uid, "00201209": str(images), "00080060": modality}


def test_the_series_with_the_most_slices_is_recommended_first():
    found = results.series([series("1.1", 30), series("1.2", 900), series("1.3", 2000, "SR")], "1")["items"]
    assert [(one["series"], one["recommended"], one["suitable"]) for one in found] == [("1.2", True, True), ("1.1", False, True), ("1.3", False, False)]
    assert not results.series([series("1.1", 900)], "1")["items"][0]["recommended"], "there is no choice"
    assert not results.series([series("1.1", 3), series("1.2", 2)], "1")["items"][0]["recommended"], "both are overviews"


def test_more_studies_than_fit_are_reported():
    one = {"0020000D": "1.2", "00080061": "CT"}
    assert results.studies([one] * (limits.MOST_STUDIES + 1))["more"] is True
    assert results.studies([one] * limits.MOST_STUDIES)["more"] is False
    assert results.studies([{**one, "00080061": "US"}])["items"] == [], "nothing in it can be shown"


class Archive:
    """Loses the connection during the first requests for the whole series, after `arrived` images of two."""

    def __init__(self, lost: int, arrived: int):
        self.lost, self.arrived, self.requests = lost, arrived, []
        self.name = "archive"

    def images(self, _study: str, _series: str) -> list[str]:
        return ["1", "2"]

    def fetch(self, _study: str, _series: str, _check, image: str = ""):
        self.requests.append(image or "whole")
        if image:
            yield image
        elif self.lost > 0:
            self.lost -= 1
            yield from ["1", "2"][:self.arrived]
            raise ArchiveError("unreachable", "the connection to the archive was lost")
        else:
            yield from ["1", "2"]

    def close(self) -> None:
        pass


@pytest.mark.parametrize("lost, arrived, requests", [
    (0, 0, ["whole"]), (1, 0, ["whole", "whole"]), (2, 0, ["whole", "whole", "1", "2"]), (1, 1, ["whole", "2"])])
def test_after_a_lost_connection_only_what_is_missing_is_requested(monkeypatch, lost, arrived, requests):
    archive, images = Archive(lost, arrived), set()
    monkeypatch.setattr(jobs, "client_of", lambda one: one)
    monkeypatch.setattr(jobs, "read_image", lambda data: data)
    monkeypatch.setattr(jobs, "METRICS", SimpleNamespace(count_bytes=lambda *_: None))
    job = SimpleNamespace(order=SimpleNamespace(study="1.2", series="1.2.3"), check=lambda: None)
    jobs.fetch_series(archive, job, SimpleNamespace(images=images, add=images.add))
    assert images == {"1", "2"} and archive.requests == requests
