"""Backups with the real restic, without a database."""

from __future__ import annotations

import subprocess
from contextlib import contextmanager
from pathlib import Path

import pytest
from diaphane_backup import __main__ as command
from diaphane_backup.database import variables
from diaphane_backup.errors import BackupError
from diaphane_backup.installation import COMPLETE, Installation
from diaphane_backup.repository import Repository

KNOWN, UNKNOWN = "00000000-0000-4000-8000-000000000001", "00000000-0000-4000-8000-000000000002"


class FakeDatabase:
    """A database of one text. `while_kept` runs between the dump and the copy of the files."""

    def __init__(self, text: str = "", users: bool = False, while_kept=lambda: None):
        self.text, self.users, self.while_kept = text, users, while_kept
        self.kept, self.calls = False, []

    @contextmanager
    def files_kept(self):
        self.kept = True
        yield
        self.kept = False

    def dump(self, into: Path) -> None:
        assert self.kept, "a file could be deleted after the dump and before the copy"
        assert into.parent.stat().st_mode & 0o077 == 0
        into.write_text(self.text)
        self.while_kept()

    def restore(self, dump: Path) -> None:
        self.text = dump.read_text()
        self.calls.append("restore")

    def has_users(self) -> bool:
        return self.users

    def forget_sign_ins(self) -> None:
        self.calls.append("forget")

    def data_sets(self) -> set[str]:
        return {KNOWN}


@pytest.fixture
def key(tmp_path) -> Path:
    (tmp_path / "key").write_text("correct horse\n")
    return tmp_path / "key"


@pytest.fixture
def repository(tmp_path, key) -> Repository:
    return Repository(str(tmp_path / "repository"), key)


def filled(folder: Path) -> Path:
    for name, text in ((f"volumes/{KNOWN}/voxels", "voxels"), (f"volumes/{UNKNOWN}/voxels", "deleted"), ("volumes/thumbnails/a", "picture"),
                       ("uploads/one", "upload"), ("secrets/factor-key", "factor"), ("secrets/backup-key", "key"), ("secrets/postgres", "password"),
                       ("scratch/x", "scratch")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def files(folder: Path) -> dict[str, str]:
    return {str(path.relative_to(folder)): path.read_text() for path in sorted(folder.rglob("*")) if path.is_file()}


def empty(folder: Path) -> Path:
    for name in ("volumes", "uploads"):
        (folder / name).mkdir(parents=True)
    return folder


def test_what_was_saved_is_restored_and_encrypted(tmp_path, repository):
    source = filled(tmp_path / "source")
    before = files(source)
    Installation(source, FakeDatabase("rows")).save(repository)
    assert files(source) == before, "the dump must not stay"
    stored = b"".join(path.read_bytes() for path in (tmp_path / "repository").rglob("*") if path.is_file())
    assert not any(word in stored for word in (b"voxels", b"rows", b"picture", b"factor"))
    database = FakeDatabase()
    target = empty(tmp_path / "target")
    Installation(target, database).restore(repository)
    assert database.text == "rows" and database.calls == ["restore", "forget"]
    assert files(target) == {f"volumes/{KNOWN}/voxels": "voxels", "volumes/thumbnails/a": "picture", "uploads/one": "upload",
                             "secrets/factor-key": "factor"}, "neither keys, nor passwords, nor scans that no row names"


def test_the_second_copy_has_what_was_written_during_the_first(tmp_path, repository):
    source = filled(tmp_path / "source")
    database = FakeDatabase("rows", while_kept=lambda: (source / f"volumes/{KNOWN}/late").write_text("late"))
    Installation(source, database).save(repository)
    target = empty(tmp_path / "target")
    Installation(target, FakeDatabase()).restore(repository)
    assert files(target)[f"volumes/{KNOWN}/late"] == "late"


def test_an_older_backup_can_be_chosen(tmp_path, repository, monkeypatch):
    source = filled(tmp_path / "source")
    with monkeypatch.context() as patch:
        patch.setattr(repository, "keep", lambda *_: None)    # it would keep one per hour
        first = Installation(source, FakeDatabase("first")).save(repository)
    (source / f"volumes/{KNOWN}/voxels").write_text("changed")
    target, database = empty(tmp_path / "target"), FakeDatabase()
    with monkeypatch.context() as patch:
        patch.setattr(repository, "keep", lambda *_: None)
        Installation(source, FakeDatabase("second")).save(repository)
    assert Installation(target, database).restore(repository, first) == first
    assert database.text == "first" and files(target)[f"volumes/{KNOWN}/voxels"] == "voxels"
    with pytest.raises(BackupError, match="no backup 12345678"):
        Installation(empty(tmp_path / "other"), FakeDatabase()).restore(repository, "12345678")


def test_one_backup_per_hour_is_kept(tmp_path, repository):
    source = filled(tmp_path / "source")
    Installation(source, FakeDatabase("first")).save(repository)
    newest = Installation(source, FakeDatabase("second")).save(repository)
    assert newest in [one.name for one in repository.snapshots(COMPLETE)] and len(repository.snapshots(COMPLETE)) <= 2, "at most two hours"


@pytest.mark.parametrize("fill, users, problem", [
    ("volumes/x", False, "volumes already contain"), ("uploads/x", False, "uploads already contain"), ("", True, "already has users")])
def test_only_an_empty_installation_is_restored(tmp_path, repository, fill, users, problem):
    Installation(filled(tmp_path / "source"), FakeDatabase("rows")).save(repository)
    target = empty(tmp_path / "target")
    if fill:
        (target / fill).write_text("kept")
    database = FakeDatabase("kept", users=users)
    with pytest.raises(BackupError, match=problem):
        Installation(target, database).restore(repository)
    assert database.text == "kept" and set(files(target).values()) <= {"kept"}


def test_another_key_opens_nothing_and_destroys_nothing(tmp_path, repository):
    source = filled(tmp_path / "source")
    Installation(source, FakeDatabase("rows")).save(repository)
    (tmp_path / "other").write_text("wrong horse\n")
    other = Repository(str(tmp_path / "repository"), tmp_path / "other")
    with pytest.raises(BackupError, match="another key"):
        Installation(source, FakeDatabase("rows")).save(other)
    with pytest.raises(BackupError):
        Installation(empty(tmp_path / "target"), FakeDatabase()).restore(other)
    assert len(repository.snapshots(COMPLETE)) == 1


def test_a_damaged_repository_is_noticed(tmp_path, repository):
    Installation(filled(tmp_path / "source"), FakeDatabase("rows")).save(repository)
    repository.check(100)
    pack = max((tmp_path / "repository" / "data").rglob("*"), key=lambda path: path.stat().st_size if path.is_file() else 0)
    pack.chmod(0o600)
    data = bytearray(pack.read_bytes())
    data[len(data) // 2] ^= 1
    pack.write_bytes(data)
    with pytest.raises(BackupError, match="check"):
        repository.check(100)


@pytest.mark.parametrize("name, fails", [(f"volumes/{KNOWN}/voxels", True), (f"volumes/{KNOWN}/deleted-meanwhile", False)])
def test_a_file_that_cannot_be_read_is_an_error(tmp_path, repository, monkeypatch, name, fails):
    source = filled(tmp_path / "source")
    repository.ensure()
    call = repository._call

    def failing(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        done = call(*arguments, cwd=cwd)
        if arguments[0] == "backup":
            done.returncode, done.stderr = 3, f'{{"message_type":"error","error":{{}},"during":"archival","item":"{source / name}"}}\n'
        return done

    monkeypatch.setattr(repository, "_call", failing)
    if fails:
        with pytest.raises(BackupError, match="1 files cannot be read"):
            Installation(source, FakeDatabase("rows")).save(repository)
    else:
        Installation(source, FakeDatabase("rows")).save(repository)
    monkeypatch.undo()
    assert len(repository.snapshots(COMPLETE)) == (0 if fails else 1)


def test_a_failed_dump_leaves_no_backup_and_no_dump(tmp_path, repository):
    source = filled(tmp_path / "source")

    def fail() -> None:
        raise BackupError("pg_dump failed")

    with pytest.raises(BackupError):
        Installation(source, FakeDatabase("rows", while_kept=fail)).save(repository)
    assert repository.snapshots(COMPLETE) == [] and not (source / "database").exists()


@pytest.mark.parametrize("text, expected", [
    ("postgresql://anna:a%20b%40c@db.example:5433/scans?sslmode=verify-full&sslrootcert=/ca.crt",
     {"PGHOST": "db.example", "PGPORT": "5433", "PGUSER": "anna", "PGPASSWORD": "a b@c", "PGDATABASE": "scans", "PGSSLMODE": "verify-full", "PGSSLROOTCERT": "/ca.crt"}),
    ("postgres:///scans?host=/run/postgresql", {"PGDATABASE": "scans", "PGHOST": "/run/postgresql"}),
    ("host=db user=anna password='a b' dbname=scans", {"PGHOST": "db", "PGUSER": "anna", "PGPASSWORD": "a b", "PGDATABASE": "scans"})])
def test_connection_strings_are_understood(text, expected):
    assert variables(text) == expected


@pytest.mark.parametrize("text", ["", "scans", "postgresql://one,two/scans", "postgresql://h:port/x", "host=db frobnicate=1", "password='open"])
def test_other_connection_strings_are_refused_without_being_quoted(text):
    with pytest.raises(BackupError) as refused:
        variables(text)
    assert not text or text not in str(refused.value)


def test_missing_settings_are_named(monkeypatch, capsys, key):
    monkeypatch.delenv("DIAPHANE_BACKUP_REPOSITORY", raising=False)
    assert command.main(["list"]) == 1
    assert "DIAPHANE_BACKUP_REPOSITORY is not set" in capsys.readouterr().err
    monkeypatch.setenv("DIAPHANE_BACKUP_REPOSITORY", "/nowhere")
    monkeypatch.setenv("DIAPHANE_BACKUP_KEY", str(key.with_name("absent")))
    assert command.main(["list"]) == 1
    assert "is missing or empty" in capsys.readouterr().err
