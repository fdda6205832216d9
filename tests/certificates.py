"""A certificate authority and its certificates."""

from __future__ import annotations

import subprocess
from pathlib import Path

#: Those of the programs that have certificates.
ROLES = ("api", "gateway", "renderd", "operator")
_KEY = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")


def with_roles(*roles: str, names: str = "IP:127.0.0.1") -> str:
    """Returns names with the URIs of the roles."""
    return ",".join([names, *(f"URI:spiffe://diaphane/{role}" for role in roles)])


def issue(folder: Path, ca: str = "ca.pem", certificate: str = "own.pem", key: str = "own.key", names: str = with_roles(*ROLES)) -> None:
    """Writes files of these names, valid for two days, and replaces existing ones. By default, the certificate has every role, so
    that all programs of a test can share it."""
    def openssl(*words: str) -> None:
        subprocess.run(["openssl", *words], check=True, capture_output=True, cwd=folder)

    openssl("req", "-x509", *_KEY, "-keyout", "ca.key", "-days", "2", "-subj", "/CN=test-ca", "-out", ca)
    openssl("req", "-new", *_KEY, "-keyout", key, "-subj", "/CN=diaphane-test", "-out", "own.csr")
    (folder / "own.ext").write_text(f"subjectAltName={names}")
    openssl("x509", "-req", "-in", "own.csr", "-CA", ca, "-CAkey", "ca.key", "-days", "2", "-extfile", "own.ext", "-out", certificate)


def issue_another(folder: Path, name: str, names: str = "IP:127.0.0.1", days: int = 2, usage: str = "", signed: bool = True) -> tuple[str, str]:
    """Writes another certificate of the authority that issue() created in `folder`, and its key, as NAME.pem and NAME.key. A
    negative `days` makes an expired one. `usage` is its only extended key usage. If not `signed`, it is self-signed."""
    def openssl(*words: str) -> None:
        subprocess.run(["openssl", *words], check=True, capture_output=True, cwd=folder)

    by = ("-CA", "ca.pem", "-CAkey", "ca.key") if signed else ("-signkey", f"{name}.key")
    openssl("req", "-new", *_KEY, "-keyout", f"{name}.key", "-subj", f"/CN={name}", "-out", f"{name}.csr")
    (folder / f"{name}.ext").write_text(f"subjectAltName={names}\n" + (f"extendedKeyUsage={usage}\n" if usage else ""))
    openssl("x509", "-req", "-in", f"{name}.csr", *by, "-days", str(days), "-extfile", f"{name}.ext", "-out", f"{name}.pem")
    return str(folder / f"{name}.pem"), str(folder / f"{name}.key")
