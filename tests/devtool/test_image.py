"""Checks of the container image that need no build: it matches the chart, and its checks detect what they should."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "tools"))

from devtool import image, image_check  # noqa: E402

CHART = REPO / "helm" / "diaphane"


def _containerfile() -> str:
    return (REPO / "Containerfile").read_text(encoding="utf-8")


def _last_stage() -> str:
    return "FROM " + _containerfile().rpartition("\nFROM ")[2]


def test_the_image_runs_as_the_user_of_the_chart():
    helpers = (CHART / "templates" / "_helpers.tpl").read_text(encoding="utf-8")
    user, group = (re.search(rf"^{word}: (\d+)$", helpers, re.MULTILINE)[1] for word in ("runAsUser", "runAsGroup"))
    assert f"USER {user}:{group}\n" in _last_stage()
    assert int(user) == image_check.USER


def test_every_mount_point_exists_in_the_image():
    mounted = set()
    for template in ("api.yaml", "ingest.yaml", "fleet.yaml", "migrate.yaml", "operator.yaml", "studies.yaml", "pacs.yaml", "backup.yaml"):
        mounted |= set(re.findall(r"mountPath: ([^,}\s]+)", (CHART / "templates" / template).read_text(encoding="utf-8")))
    made = set(re.search(r"mkdir -p ((?:/\S+ )+)", _containerfile())[1].split())
    assert {"/data/volumes", "/run/edge", "/tmp"} <= mounted
    assert mounted - {"/tmp"} == made


def test_the_chart_starts_only_programs_of_the_image():
    assert image.chart_programs() == ["diaphane-api", "diaphane-gateway", "diaphane-ingestd", "diaphane-operator", "diaphane-renderd"]


def test_the_last_image_stage_only_copies_files():
    assert re.match(r"FROM scratch\nCOPY --from=whole / /\n", _last_stage())
    assert "RUN" not in _last_stage()


def test_the_image_has_the_modules_that_the_edge_loads():
    conf = (REPO / "api" / "edge" / "nginx.conf.in").read_text(encoding="utf-8")
    assert re.findall(r"^load_module (\S+);$", conf, re.MULTILINE) == [str(module) for module in image.NGINX_MODULES]


def test_the_image_has_the_charts_version():
    assert re.fullmatch(r"localhost/diaphane:\d+\.\d+\.\d+", image.name())


def test_a_compiler_is_known_by_its_name():
    there = ["/usr/bin/gcc-12", "/usr/bin/x86_64-linux-gnu-g++", "/usr/lib/gcc/x86_64-linux-gnu/12/cc1plus", "/usr/bin/make", "/opt/cuda/bin/nvcc",
             "/usr/bin/ld.bfd", "/usr/bin/as", "/usr/bin/cc", "/usr/bin/clang++-14", "/opt/cuda/nvvm/bin/cicc"]
    others = ["/usr/bin/cat", "/usr/bin/last", "/usr/bin/ldd", "/usr/sbin/ldconfig", "/usr/bin/make-something", "/usr/share/doc/make",
              "/opt/diaphane/lib/libnvrtc.so.13", "/usr/sbin/nginx", "/usr/bin/perl"]
    assert image_check.compilers(there + others) == sorted(there)


def test_backups_need_only_what_the_image_has():
    assert all(program.exists() and not program.read_bytes().startswith(b"#!") for program in image._BACKUP_PROGRAMS)
    done = subprocess.run([image.PYTHON, "-S", "-m", "diaphane_backup", "list"], capture_output=True, text=True, cwd="/",
                          env={"PYTHONPATH": str(REPO / "backup"), "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.stderr == "diaphane_backup: DIAPHANE_BACKUP_REPOSITORY is not set\n"


def test_the_gateway_to_archives_needs_only_what_the_image_has(tmp_path):
    """Imports every module with the libraries of the image alone. -S leaves out those of this machine."""
    image._pacs(tmp_path / "pacs")
    modules = sorted(f"diaphane_pacs.{path.stem}" for path in (tmp_path / "pacs" / "diaphane_pacs").glob("[a-z]*.py"))
    assert "diaphane_pacs.serve" in modules and "diaphane_pacs.spool" in modules
    done = subprocess.run([image.PYTHON, "-S", "-c", f"import {', '.join(modules)}, sys; print(*sys.path)"], capture_output=True, text=True, cwd="/",
                          env={"PYTHONPATH": str(tmp_path / "pacs"), "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.returncode == 0, done.stderr
    assert "dist-packages" not in done.stdout
