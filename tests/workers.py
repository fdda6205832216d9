"""Which tests each process of a parallel run gets: each worker of pytest-xdist, or each of several runs of pytest."""

from __future__ import annotations

import zlib
from pathlib import Path

from xdist.scheduler.loadscope import LoadScopeScheduling

#: Files that take longest, which start first, so that the last worker does not end long after the others.
LONGEST = ("test_access_matrix.py", "test_canaries.py", "test_ingest_faults.py", "test_edge_attacks.py", "test_api_contract.py", "test_full_disk.py",
           "test_api_presets.py", "test_api_account_changes.py", "test_anonymise_job.py", "test_api_accounts.py", "test_gateway_stream.py",
           "test_api_migrations.py", "test_python_client.py", "test_inner_tls_attacks.py", "test_attacks_by_role.py", "test_faults.py",
           "test_up.py", "test_every_page.py", "test_anonymise.py", "test_videos.py", "test_upload.py", "test_pages.py", "test_take_away.py", "test_live_session.py",
           "test_upload_to_view.py", "test_controls.py", "test_stream.py", "test_in_picture.py", "test_sharing.py")
#: Into how many parts a file is divided that one worker should not get as a whole. Each part starts programs of its own.
PARTS = {"test_access_matrix.py": 4, "test_canaries.py": 2, "test_ingest_faults.py": 2}


def unit_of(nodeid: str) -> str:
    """Returns what one worker gets as a whole: a file, the tests of which share programs, or a part of it."""
    file = nodeid.partition("::")[0]
    return f"{file} {zlib.crc32(nodeid.encode()) % PARTS.get(file.rpartition('/')[2], 1)}"


def rank_of(name: str) -> int:
    """Returns the place of a file in the order in which they start."""
    return LONGEST.index(name) if name in LONGEST else len(LONGEST)


class ByFile(LoadScopeScheduling):
    """Gives a worker the next file or part when it has nearly finished the last one."""

    def _split_scope(self, nodeid: str) -> str:
        return unit_of(nodeid)


class Claims:
    """Shares the files out among several runs of pytest, of which each may start and end at any time: the first that claims a file
    runs it. Files are not divided here: after tests of a file that are passed over, pytest refuses to set up those of the next."""

    def __init__(self, folder: Path) -> None:
        self.folder_ = folder
        self.own_: dict[str, bool] = {}

    def ours(self, nodeid: str) -> bool:
        file = nodeid.partition("::")[0]
        if file not in self.own_:
            self.own_[file] = self._claim(file)
        return self.own_[file]

    def _claim(self, file: str) -> bool:
        try:
            (self.folder_ / file.replace("/", " ")).mkdir(parents=True)
        except FileExistsError:
            return False
        return True
