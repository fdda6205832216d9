"""Lint of the contracts, OpenAPI and Protobuf."""

from __future__ import annotations

import json
import subprocess

from . import commands, paths

# This script runs in .tools/venv, which has the libraries.
_READ_OPENAPI = """
import json, sys, yaml
from openapi_spec_validator import OpenAPIV31SpecValidator
spec = yaml.safe_load(open(sys.argv[1], encoding="utf-8"))
errors = [f"{'/'.join(map(str, e.absolute_path))}: {e.message[:300]}" for e in OpenAPIV31SpecValidator(spec).iter_errors()]
print(json.dumps({"spec": spec, "errors": errors}, default=str))
"""
_METHODS = ("get", "put", "post", "delete", "patch", "head", "options")


def check() -> list[str]:
    return _openapi() + _protobuf()


def _openapi() -> list[str]:
    contract = paths.REPO / "api" / "openapi.yaml"
    done = subprocess.run([str(paths.VENV_PYTHON), "-c", _READ_OPENAPI, str(contract)], capture_output=True, text=True)
    if done.returncode != 0:
        return [f"api/openapi.yaml cannot be read: {done.stderr.strip().splitlines()[-1]}"]
    read = json.loads(done.stdout)
    return [f"api/openapi.yaml: {error}" for error in read["errors"] + style(read["spec"])]


def style(spec: dict) -> list[str]:
    """Checks what client generators and readers need beyond validity."""
    found = []
    visited: set[str] = set()
    for path, item in spec.get("paths", {}).items():
        for method in (m for m in _METHODS if m in item):
            operation = item[method]
            name = f"{method.upper()} {path}"
            identity = operation.get("operationId")
            if not identity:
                found.append(f"{name} has no operationId")
            elif identity in visited:
                found.append(f"{name}: operationId {identity} is used twice")
            visited.add(identity or "")
            if not operation.get("summary"):
                found.append(f"{name} has no summary")
            if not any(str(code)[0] in "4d" for code in operation.get("responses", {})):
                found.append(f"{name} documents no error response")
    return found


def _protobuf() -> list[str]:
    protos = sorted(str(path.relative_to(paths.REPO)) for path in (paths.REPO / "api" / "proto").glob("*.proto"))
    done = commands.run(["protoc", "-I", ".", "--fatal_warnings", "--descriptor_set_out=/dev/null", *protos], cwd=paths.REPO)
    return [] if done.returncode == 0 else [done.stdout.strip()]
