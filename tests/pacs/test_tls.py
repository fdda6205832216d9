"""Connections with TLS: to an archive with DICOMweb, and from a device by C-STORE."""

from __future__ import annotations

import ssl
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from certificates import issue
from diaphane_pacs.errors import ArchiveError
from diaphane_pacs.intake import Intake
from diaphane_pacs.receiver import StoreReceiver
from diaphane_pacs.results import Search
from diaphane_pacs.settings import Receiver, Tls, WebArchive
from diaphane_pacs.spool import Spool
from diaphane_pacs.web import WebClient
from harness import free_port
from pynetdicom import AE


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> tuple[Path, Path, Path, Path]:
    """Returns the CA, a certificate for localhost with its key, and another CA."""
    ours, other = tmp_path_factory.mktemp("ours"), tmp_path_factory.mktemp("other")
    for folder in (ours, other):
        issue(folder, names="DNS:localhost")
    return ours / "ca.pem", ours / "own.pem", ours / "own.key", other / "ca.pem"


def test_an_archive_must_have_a_certificate_of_a_trusted_authority(files):
    ca, certificate, key, other = files

    class Archive(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "application/dicom+json")
            self.end_headers()
            self.wfile.write(b"[]")

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Archive)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate, key)
    server.socket = context.wrap_socket(server.socket, server_side=True)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    url = f"https://localhost:{server.server_port}"
    try:
        assert WebClient(WebArchive("a", "A", url, tls=Tls(ca))).studies(Search(patient_name="P")) == []
        for wrong in (Tls(other), Tls()):
            with pytest.raises(ArchiveError) as refused:
                WebClient(WebArchive("a", "A", url, tls=wrong)).studies(Search(patient_name="P"))
            assert refused.value.kind == "unreachable"
    finally:
        server.shutdown()


def test_a_device_needs_a_certificate_where_the_settings_name_an_authority(files, tmp_path):
    ca, certificate, key, _ = files
    port = free_port()
    intake = Intake("http://127.0.0.1:1", 5, Spool(tmp_path, 1 << 20, "key"))
    receiver = StoreReceiver(Receiver(port, "DIAPHANE", {"CT1": "token"}, tls=Tls(ca, certificate, key)), intake)
    receiver.start()

    def connects(*own: Path) -> bool:
        context = ssl.create_default_context(cafile=ca)
        if own:
            context.load_cert_chain(*own)
        ae = AE("CT1")
        ae.add_requested_context("1.2.840.10008.1.1")
        ae.acse_timeout = ae.dimse_timeout = ae.network_timeout = 10
        association = ae.associate("127.0.0.1", port, ae_title="DIAPHANE", tls_args=(context, "localhost"))
        established = association.is_established and association.send_c_echo().get("Status") == 0
        if association.is_established:
            association.release()
        return established

    try:
        assert connects(certificate, key)
        assert not connects()
    finally:
        receiver.stop()
        intake.stop()
