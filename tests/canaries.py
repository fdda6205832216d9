"""Words planted in a scan that must not be found afterwards: searched in everything that a server stores, in every form in which
a program may store them. tests/hostile/canary_scan.py writes a scan full of them."""

from __future__ import annotations

import base64
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Iterable

# Words that ingest/dicom/series_writer.h puts into every text of the sample, and parts of its folder and file names.
WORDS = ["Canary7f3a", "Mustermann", "IM000001"]

PIECE, LONGEST = 16 << 20, 400   # bytes per read; longer than any form of a word


def forms(word: str) -> dict[str, bytes]:
    """Returns the word in base64 at the three possible alignments, without the ends that depend on neighbouring bytes."""
    plain = word.encode()
    found = {"UTF-8": plain, "UTF-16LE": word.encode("utf-16-le"), "UTF-16BE": word.encode("utf-16-be"),
             "hex": plain.hex().encode(), "HEX": plain.hex().upper().encode()}
    for shift in range(3):
        coded = base64.b64encode(b"\0" * shift + plain)
        found[f"base64+{shift}"] = coded[-(-shift * 8 // 6):].rstrip(b"=")[:-1]
    return found


class Search:
    """Searches for several words. `begun` is the time at which they were created (time.time()). Older files cannot contain them.
    """

    def __init__(self, words: Iterable[str] = WORDS, begun: float = 0.0):
        self.needles = {f"{word} in {name}": needle for word in words for name, needle in forms(word).items()}
        self.begun = begun

    def inside(self, data: bytes) -> list[str]:
        return [name for name, needle in self.needles.items() if needle in data]

    def below(self, folder: Path, leave_out: Iterable[Path] = ()) -> list[str]:
        """Searches contents and names of all files. Ignores files that are deleted meanwhile."""
        found, left_out = [], set(leave_out)
        for place, folders, files in os.walk(folder):
            folders[:] = [name for name in sorted(folders) if Path(place, name) not in left_out]
            for path in (Path(place, name) for name in (*folders, *sorted(files))):
                if path in left_out:
                    continue
                found += [f"{name}: the name of {path}" for name in self.inside(path.name.encode(errors="surrogateescape"))]
                try:
                    if path.is_file() and not path.is_symlink() and path.stat().st_mtime >= self.begun - 2:
                        found += [f"{name}: {path}" for name in self._of_file(path)]
                except (FileNotFoundError, PermissionError):
                    pass
        return found

    def _of_file(self, path: Path) -> list[str]:
        found: dict[str, None] = {}
        with path.open("rb") as file:
            end = b""    # end of the previous piece, because a word may cross the border
            while piece := file.read(PIECE):
                found.update(dict.fromkeys(self.inside(end + piece)))
                end = piece[-LONGEST:]
        return list(found)

    def in_stack(self, stack, leave_out: Iterable[Path] = ()) -> list[str]:
        """Searches the data directory (uploads, volumes, scratch, caches, logs, mails, core files), and dumps of the database and
        of Redis."""
        stack.redis.config_set("rdbcompression", "no")
        stack.redis.save()
        dump = subprocess.run(["pg_dump", "--inserts", stack.dsn], capture_output=True, check=True).stdout
        assert len(dump) > 5000, "not a dump"
        return self.below(stack.data_dir, leave_out) + [f"{name}: the dump of the database" for name in self.inside(dump)]

    def in_temporary_files(self, leave_out: Iterable[Path] = ()) -> list[str]:
        """Searches temporary files except those of other tests, which may run in parallel."""
        others = {path for name in ("diaphane-test-*", "pytest-of-*", "diaphane-bench-*") for base in ("/tmp", "/var/tmp")
                  for path in Path(base).glob(name)}
        leave_out = {*leave_out, *others}
        places = {Path(tempfile.gettempdir()), Path("/tmp"), Path("/var/tmp"), Path("/dev/shm")}
        return [hit for place in sorted(places) if place.is_dir() for hit in self.below(place, leave_out)]


_SAMPLE = Search()


def canaries_in(data: bytes) -> list[str]:
    """Finds the words of the sample."""
    return _SAMPLE.inside(data)


def canaries_below(folder: Path) -> list[str]:
    return _SAMPLE.below(folder)
