"""A stack that is connected to archives."""

from __future__ import annotations

import json
import secrets
from pathlib import Path

import phantom
from harness import StackFactory, TestStack, free_port
from orthanc import AE_TITLE, PASSWORD, USER, Orthanc

PROGRAMS = ("postgres", "redis", "api", "edge", "ingestd", "pacs")
CALLER = "SCANNER1"


def archives_toml(archives: list[dict], receiver: dict | None = None) -> str:
    """Returns a settings file of the gateway."""
    lines: list[str] = []
    for one in archives:
        lines += ["[[archive]]", *_fields(one)]
    if receiver:
        callers = receiver.pop("callers")
        lines += ["[receiver]", *_fields(receiver)]
        for caller in callers:
            lines += ["[[receiver.caller]]", *_fields(caller)]
    return "\n".join(lines) + "\n"


def _fields(table: dict) -> list[str]:
    return [f"{name} = {json.dumps(value)}" for name, value in table.items()]


def web_archive(orthanc: Orthanc, **changes: object) -> dict:
    return {"name": "radiology", "title": "Radiology", "url": orthanc.web_url, "user": USER, "password_file": "secrets/pacs-password", **changes}


def dimse_archive(orthanc: Orthanc, **changes: object) -> dict:
    return {"name": "legacy", "title": "Old archive", "host": "127.0.0.1", "port": orthanc.dicom_port, "ae_title": AE_TITLE, **changes}


def open_stack(factory: StackFactory, archives: list[dict], only=PROGRAMS, quiet: float = 0.5, engine: str = "cpu", port: int = 0,
               extra_env: dict[str, str] | None = None) -> TestStack:
    """Opens a stack with these archives and a receiver. Its `caller_token` is the token of the AE title SCANNER1."""
    data = factory.folder()
    factory.give_cluster(data)
    token, port = new_token(), port or free_port()
    receiver = {"port": port, "ae_title": "DIAPHANE", "quiet_seconds": quiet, "callers": [{"ae_title": CALLER, "token_file": "secrets/caller-token"}]}
    files = {"archives.toml": archives_toml(archives, receiver), "secrets/pacs-password": PASSWORD, "secrets/caller-token": token,
             "secrets/wrong-password": "not-the-password"}
    for name, text in files.items():
        (data / name).write_text(text, encoding="utf-8")
        factory.run_as.own(data / name)
    stack = factory.open(only=only, data_dir=data, engine=engine, extra_env=extra_env)
    stack.caller_token, stack.receiver_port = token, port
    stack.wait_ready("pacs")
    return stack


def new_token() -> str:
    return "diaphane_" + secrets.token_hex(32)


def phantom_folder(factory: StackFactory) -> Path:
    return phantom.write(factory.folder())
