"""Archives as input of command-line tools. They are unpacked into a temporary folder, whose files are numbered, so that no name in
an archive leads anywhere. The page does the same (frontend/src/scan/archives.ts)."""

from __future__ import annotations

import contextlib
import lzma
import shutil
import tarfile
import tempfile
import zipfile
import zlib
from pathlib import Path
from typing import IO, Iterator

from .console import CliError

#: Limits of one archive: unpacked files and bytes, and the nesting of archives.
MOST_FILES, MOST_BYTES, MOST_NESTED = 100_000, 8 << 30, 4
#: First entries of programs and documents that happen to be ZIP archives.
NO_SCANS = ("META-INF/", "[Content_Types].xml", "_rels/", "mimetype", "AndroidManifest.xml")
#: First bytes of archive formats that Python cannot read.
UNKNOWN = (b"Rar!\x1a\x07", b"7z\xbc\xaf\x27\x1c", b"\x28\xb5\x2f\xfd")

DAMAGED = (zipfile.BadZipFile, tarfile.TarError, zlib.error, lzma.LZMAError, EOFError, OSError)


@contextlib.contextmanager
def unpacked(arguments: list[str]) -> Iterator[list[str]]:
    """Replaces each argument that is an archive by the folder that it was unpacked into."""
    with contextlib.ExitStack() as folders:
        def replaced(argument: str) -> str:
            archive = Path(argument)
            if not is_archive(archive):
                return argument
            folder = folders.enter_context(tempfile.TemporaryDirectory(prefix="diaphane-unpacked-"))
            _Unpacking(archive, Path(folder)).run()
            return folder

        yield [replaced(one) for one in arguments]


def is_archive(path: Path) -> bool:
    """Recognises ZIP archives and tar archives, compressed or not, by their content. Fails on formats that cannot be unpacked."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        begin = file.read(60)
    if begin.startswith(UNKNOWN):
        raise CliError(f"{path} has a format that Diaphane cannot unpack. Unpack it first, then name the folder.")
    if begin.startswith(b"PK\3\4"):
        return not begin[30:].startswith(tuple(name.encode() for name in NO_SCANS))
    return begin.startswith(b"PK\5\6") or _is_tar(path)


def _is_tar(path: Path) -> bool:
    try:
        return tarfile.is_tarfile(path)
    except DAMAGED:
        return False


class _Unpacking:
    def __init__(self, archive: Path, folder: Path):
        self.archive, self.folder = archive, folder
        self.files, self.bytes = 0, 0

    def run(self) -> None:
        try:
            self._unpack(self.archive, 1)
        except DAMAGED as error:
            raise CliError(f"{self.archive} is damaged or incomplete. Copy or download it again.") from error

    def _unpack(self, archive: Path, depth: int) -> None:
        if depth > MOST_NESTED:
            raise CliError(f"{self.archive} contains archives within archives within archives. Unpack it first, then name the folder.")
        for content in _zipped(archive, self.archive) if zipfile.is_zipfile(archive) else _tarred(archive):
            self.files += 1
            path = self.folder / f"{self.files:06}"
            with content as source, path.open("wb") as target:
                self._copy(source, target)
            if is_archive(path):
                self._unpack(path, depth + 1)
                path.unlink()

    def _copy(self, source: IO[bytes], target: IO[bytes]) -> None:
        while part := source.read(1 << 20):
            self.bytes += len(part)
            if self.files > MOST_FILES or self.bytes > min(MOST_BYTES, self.bytes + shutil.disk_usage(self.folder).free // 2):
                raise CliError(f"{self.archive} unpacks to more than {MOST_FILES} files, {MOST_BYTES >> 30} GiB or half of the free disk."
                               " Unpack it first, then name the folder with the scan.")
            target.write(part)


def _zipped(archive: Path, named: Path) -> Iterator[IO[bytes]]:
    with zipfile.ZipFile(archive) as opened:
        for entry in opened.infolist():
            if entry.is_dir():
                continue
            if entry.flag_bits & 1:
                raise CliError(f"{named} is protected by a password. Unpack it with the password first, then name the folder.")
            try:
                yield opened.open(entry)
            except NotImplementedError as error:
                raise CliError(f"{named} is compressed in a way that Diaphane cannot unpack. Unpack it first, then name the folder.") from error


class _Entry(tarfile.TarInfo):
    """Reports a damaged header, which the library would take for the end of the archive."""

    @classmethod
    def fromtarfile(cls, archive: tarfile.TarFile) -> tarfile.TarInfo:
        try:
            return super().fromtarfile(archive)
        except (tarfile.InvalidHeaderError, tarfile.TruncatedHeaderError) as error:
            raise tarfile.ReadError(str(error)) from error


def _tarred(archive: Path) -> Iterator[IO[bytes]]:
    with tarfile.open(archive, tarinfo=_Entry) as opened:
        for entry in opened:
            if entry.isfile() and (content := opened.extractfile(entry)):
                yield content
