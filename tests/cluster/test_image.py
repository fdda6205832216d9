"""Builds the container image and runs it like a pod (takes minutes; needs root, and the packages of debootstrap and buildah)."""

from __future__ import annotations

import os
import subprocess

import pytest
from devtool import paths

pytestmark = pytest.mark.nightly


@pytest.mark.skipif(os.geteuid() != 0, reason="an image is built by root")
@pytest.mark.timeout(1800)
def test_the_image_is_small_has_no_compiler_and_works_on_a_read_only_root():
    done = subprocess.run([str(paths.REPO / "diaphane"), "image", "--check"], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          env={**os.environ, "DIAPHANE_BUILD": str(paths.build_dir())})
    assert done.returncode == 0, (done.stdout + done.stderr)[-6000:]
    assert "FAILED" not in done.stdout
    assert done.stdout.count("ok    ") >= 14
