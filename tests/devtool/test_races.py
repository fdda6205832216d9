"""./diaphane races."""

from __future__ import annotations

import re

import pytest

from devtool import paths, races
from devtool.console import CliError

FOLDERS = ("api", "common", "directory", "operator", "renderd")


def test_race_programs_are_built_tests():
    built = {name for folder in FOLDERS for file in (paths.REPO / folder).rglob("CMakeLists.txt")
             for name in re.findall(r"diaphane_test\((\w+)", file.read_text(encoding="utf-8"))}
    threaded = set(races.programs_in("DIAPHANE_MULTI_THREADED"))
    assert len(threaded) > 10 and threaded <= built
    assert set(races.programs_in("DIAPHANE_WITH_GRPC")) < threaded


def test_excluded_tests_are_in_existing_files():
    [suppressions] = re.findall(r"suppressions=\$\{CMAKE_SOURCE_DIR\}/(\S+)\)", races.SETTINGS.read_text(encoding="utf-8"))
    assert "race:libgrpc" in (paths.REPO / suppressions).read_text(encoding="utf-8")


def test_an_unknown_program_is_refused():
    with pytest.raises(CliError, match="render_scene_test"):
        races.run(["render_scene_test"])
