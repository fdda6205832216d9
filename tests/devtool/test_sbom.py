"""The list of components: correct by kind, valid by CycloneDX's own schema, and complete for the built programs."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from devtool import paths, sbom  # noqa: E402
from devtool.sbom import Part, Program  # noqa: E402

WHEN = "2026-11-22T10:00:00+00:00"


def faults(made: dict) -> str:
    return str(JsonStrictValidator(SchemaVersion.V1_6).validate_str(json.dumps(made)) or "")


def by_name(made: dict) -> dict[str, dict]:
    return {f"{one['group']}/{one['name']}" if "group" in one else one["name"]: one for one in made["components"]}


@pytest.mark.parametrize(("part", "url"), [
    (Part("deb", "libgrpc++1.51", "1.51.1-3+b1", arch="amd64"), "pkg:deb/debian/libgrpc%2B%2B1.51@1.51.1-3%2Bb1?arch=amd64"),
    (Part("deb", "redis-server", "5:7.0.15-1~deb12u10", arch="amd64"), "pkg:deb/debian/redis-server@5%3A7.0.15-1~deb12u10?arch=amd64"),
    (Part("npm", "@bufbuild/protobuf", "2.12.1"), "pkg:npm/%40bufbuild/protobuf@2.12.1"),
    (Part("pypi", "PyYAML", "6.0.3"), "pkg:pypi/pyyaml@6.0.3"),
    (Part("golang", "k8s.io/client-go", "v0.34.1"), "pkg:golang/k8s.io/client-go@v0.34.1"),
])
def test_package_urls_follow_the_specification(part, url):
    assert part.url == url


def test_npm_lock_gives_runtime_packages_and_hashes():
    digest = "z4PhNX7vuL3xVChQ1m2AB9Yg5AULVxXcg/SpIdNs6c5H0NE8XYXysP+DGNKHfuwvY7kxvUdBeoGlODJ6+SfaPg=="   # hash of an empty input
    lock = {"packages": {"": {"name": "page", "version": "1"}, "node_modules/a": {"version": "1.0.0", "license": "MIT", "integrity": f"sha512-{digest}"},
                         "node_modules/a/node_modules/@x/b": {"version": "2.0.0", "dev": True}, "node_modules/c": {"link": True}}}
    a, b = sbom.npm_parts(lock)
    assert (a.name, a.needed, a.licence, a.sha512[:8]) == ("a", True, "MIT", "cf83e135")
    assert (b.name, b.version, b.needed) == ("@x/b", "2.0.0", False)


def test_requirements_and_go_modules_are_read():
    found = sbom.python_parts("# why\npytest==9.0.2\npsycopg[binary]==3.2.13   # a word\n\n")
    assert [(one.name, one.version, one.needed) for one in found] == [("pytest", "9.0.2", False), ("psycopg", "3.2.13", False)]
    module = ("module x\n\ngo 1.24\n\nrequire github.com/a/b v1.2.3\n\nrequire (\n\tk8s.io/api v0.34.1\n\tgo.uber.org/zap v1.27.0 // indirect\n)\n\n"
              "replace k8s.io/api => example.org/api v0.35.0\nreplace go.uber.org/zap => ../zap\n")
    assert {(one.name, one.version) for one in sbom.go_parts(module)} == {
        ("github.com/a/b", "v1.2.3"), ("example.org/api", "v0.35.0"), ("go.uber.org/zap", "v1.27.0")}


def test_the_sbom_is_valid_and_reproducible_and_prefers_the_runtime_scope():
    lib = Part("deb", "libssl3", "3.0", arch="amd64")
    parts = [Part("deb", "libssl3", "3.0", needed=False, arch="amd64"), lib, Part("npm", "@x/y", "1.0.0", licence="MIT", sha512="ab" * 64),
             Part("pypi", "pytest", "9.0.2", needed=False)]
    programs = [Program("diaphane-api", (lib.url,))]
    made = sbom.document("1", WHEN, programs, parts)
    assert faults(made) == ""
    assert made == sbom.document("1", WHEN, programs, list(reversed(parts)))
    assert by_name(made)["libssl3"]["scope"] == "required" and by_name(made)["pytest"]["scope"] == "excluded"
    assert {"ref": "diaphane-api", "dependsOn": [lib.url]} in made["dependencies"]
    assert faults({**made, "components": [{"name": "x"}]}) != "", "the validator sees what is wrong"


def test_the_sbom_lists_linked_libraries_and_page_packages():
    folder = paths.build_dir() / "bin"
    if not (folder / "diaphane-api").exists():
        pytest.fail(f"{folder} has no programs: they are built before the tests")
    programs, parts = sbom.here(folder)
    made = sbom.document("1", WHEN, programs, parts)
    assert faults(made) == ""
    listed = by_name(made)
    # Uses readelf instead of ldd to find the libraries that the program itself requests, by name.
    asked = subprocess.run(["readelf", "-d", str(folder / "diaphane-api")], capture_output=True, text=True).stdout
    names = re.findall(r"NEEDED.*\[(lib\w+)[-.\w+]*\.so", asked)
    assert len(names) > 10
    uses = next(one for one in programs if one.name == "diaphane-api").uses
    for library, package in {"libhiredis": "libhiredis", "libpqxx": "libpqxx", "libcpprest": "libcpprest", "libargon2": "libargon2"}.items():
        assert library in names
        assert any(f"debian/{package}" in url for url in uses), package
    lock = json.loads((paths.FRONTEND / "package-lock.json").read_text(encoding="utf-8"))
    for name, version in lock["packages"][""]["dependencies"].items():
        assert (listed[name]["version"], listed[name]["scope"]) == (version, "required")
    for name in ("nginx-light", "libnginx-mod-http-lua", "postgresql", "redis-server", "nlohmann-json3-dev"):
        assert listed[name]["scope"] == "required"
    assert listed["pytest"]["scope"] == "excluded"


def test_the_sbom_command_writes_the_file(tmp_path):
    done = subprocess.run([sys.executable, str(paths.TOOLS / "devtool"), "sbom", str(tmp_path / "bom.json")], capture_output=True, text=True,
                          env={**os.environ, "DIAPHANE_BUILD": str(paths.build_dir())})
    assert done.returncode == 0, done.stderr
    made = json.loads((tmp_path / "bom.json").read_text(encoding="utf-8"))
    assert faults(made) == "" and made["metadata"]["component"]["name"] == "diaphane"
