"""The places where ./diaphane mutants puts faults, and the tests that may notice them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from . import mutations
from .mutations import Mutant

#: Files that only tests and benches use.
_OF_TESTS = re.compile(r"_test\.|\.test\.|/test_|/fake|testing\.ts|_test_support|effects_in_test|simulated_cluster")


@dataclass(frozen=True)
class Area:
    folders: tuple[str, ...]
    suffixes: tuple[str, ...]
    #: Prefixes of the test programs that may notice a fault.
    programs: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    #: The integration tests per folder, for --deep. The first folder that contains a file decides.
    deep: tuple[tuple[str, tuple[str, ...]], ...] = ()


def _integration(*names: str) -> tuple[str, ...]:
    return tuple(f"tests/integration/test_{name}.py" for name in names)


def _e2e(*names: str) -> tuple[str, ...]:
    return tuple(f"tests/e2e/test_{name}.py" for name in names)


AREAS = {
    "renderer": Area(("renderd/kernel", "renderd/math", "renderd/scene", "renderd/film", "renderd/engine/cpu", "renderd/composite"),
                     mutations.COMPILED, ("render_",), deep=(("renderd", _integration("slices")),)),
    "scheduler": Area(("renderd/schedule", "renderd/session", "directory"), mutations.COMPILED, ("render_", "directory_"),
                      deep=(("directory", _integration("api_sessions", "visitor_share", "gateway_stream")),
                            ("renderd", _integration("live_sessions", "slices", "guest_slices", "gateway_stream")))),
    "access": Area(("api/sharing", "api/accounts", "api/scans", "api/shared"), mutations.COMPILED, ("api_",),
                   deep=(("api/accounts", _integration("api_accounts", "api_account_changes", "second_factor", "access_matrix")),
                         ("api/sharing", _integration("api_sharing", "live_sessions", "access_matrix")),
                         ("api/scans", _integration("api_uploads", "anonymise", "api_sharing", "access_matrix")),
                         ("api", _integration("api_accounts", "api_sharing", "api_sessions", "api_uploads", "privacy", "api_faults")))),
    "ingest": Area(("ingest/dicom", "ingest/build", "ingest/export", "ingest/pipeline", "ingest/body", "ingest/head"), mutations.COMPILED, ("ingest_",),
                   deep=(("ingest", _integration("ingest_pipeline", "ingest_cases", "hostile", "anonymise_job", "ingest_scan")),)),
    "operator": Area(("operator/plan",), mutations.COMPILED, ("operator_",)),
    "page": Area(("frontend/src",), mutations.SCRIPTS, without=("frontend/src/texts", "frontend/src/style", "frontend/src/protocol/gen"),
                 deep=(("frontend/src/views/viewer/settings", _e2e("controls", "settings")),
                       ("frontend/src/views/viewer/slices", _e2e("slices", "readouts")),
                       ("frontend/src/views/viewer/export", _e2e("take_away", "videos")),
                       ("frontend/src/views/viewer", _e2e("controls", "in_picture", "readouts", "live_session")),
                       ("frontend/src/views/cut", _e2e("anonymise")),
                       ("frontend/src/cut", _e2e("anonymise")),
                       ("frontend/src/views", _e2e("pages", "sharing", "second_factor", "upload_to_view")),
                       ("frontend/src/scan", _e2e("upload_to_view", "upload")),
                       ("frontend/src/api", _e2e("upload", "tus", "pages")),
                       ("frontend/src", _e2e("upload_to_view", "in_picture", "stream")))),
    "tools": Area(("tools/devtool",), (".py",)),
}
#: The areas that `./diaphane mutants` and the nightly lane draw from.
PRODUCT = tuple(name for name in AREAS if name != "tools")


def product_files(area: str, root: Path) -> list[str]:
    wanted = AREAS[area]
    files = (file.relative_to(root).as_posix() for folder in wanted.folders for file in sorted((root / folder).rglob("*")) if file.suffix in wanted.suffixes)
    return [file for file in files if not _OF_TESTS.search(file) and not file.startswith(wanted.without or ("?",)) and not file.endswith(".d.ts")]


def lines(areas: tuple[str, ...], root: Path) -> list[list[Mutant]]:
    return [mutants for area in areas for file in product_files(area, root)
            for mutants in mutations.of_file(area, file, (root / file).read_text(encoding="utf-8"))]


def deep_tests(mutant: Mutant) -> tuple[str, ...]:
    return next((files for folder, files in AREAS[mutant.area].deep if mutant.file.startswith(f"{folder}/")), ())
