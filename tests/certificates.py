"""A certificate authority, and one certificate of it."""

from __future__ import annotations

import subprocess
from pathlib import Path

_KEY = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")


def issue(folder: Path, ca: str = "ca.pem", certificate: str = "own.pem", key: str = "own.key", names: str = "IP:127.0.0.1") -> None:
    """Files of these names, for two days; what was there is replaced."""
    def openssl(*words: str) -> None:
        subprocess.run(["openssl", *words], check=True, capture_output=True, cwd=folder)

    openssl("req", "-x509", *_KEY, "-keyout", "ca.key", "-days", "2", "-subj", "/CN=test-ca", "-out", ca)
    openssl("req", "-new", *_KEY, "-keyout", key, "-subj", "/CN=diaphane-test", "-out", "own.csr")
    (folder / "own.ext").write_text(f"subjectAltName={names}")
    openssl("x509", "-req", "-in", "own.csr", "-CA", ca, "-CAkey", "ca.key", "-days", "2", "-extfile", "own.ext", "-out", certificate)
