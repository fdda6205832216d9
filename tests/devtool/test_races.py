"""./diaphane races."""

from __future__ import annotations

import re

import pytest

from devtool import paths, races
from devtool.console import CliError


def test_race_programs_are_built_tests():
    built = {name for folder in ("api", "common", "directory", "operator", "renderd") for file in (paths.REPO / folder).rglob("CMakeLists.txt")
             for name in re.findall(r"diaphane_test\((\w+)", file.read_text(encoding="utf-8"))}
    assert set(races.PROGRAMS) <= built


def test_excluded_tests_are_in_existing_files():
    suppressions = re.search(r"suppressions=(\S+?)(:|$)", races.sanitizer_options()).group(1)
    assert suppressions.startswith(str(paths.REPO))
    with open(suppressions, encoding="utf-8") as file:
        assert "race:libgrpc" in file.read()


def test_only_grpc_programs_ignore_uninstrumented_modules():
    for name in races.PROGRAMS:
        assert ("ignore_noninstrumented_modules" in races.sanitizer_options(name)) == (name in races.WITH_GRPC)


def test_an_unknown_program_is_refused():
    with pytest.raises(CliError, match="render_scene_test"):
        races.run(["render_scene_test"])
