"""Validates responses against api/openapi.yaml: the operation, the status, the headers and the schema of the body."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any, Iterator

import httpx
import jsonschema
import yaml


class Contract:
    def __init__(self, path: Path):
        self.spec: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
        self.seen: set[tuple[str, int]] = set()
        # Made once, because there are many thousand responses.
        self.patterns_ = [(verb, re.compile(re.sub(r"\{[^}]+\}", "[^/]+", path)), operation) for path, verb, operation in self.operations()]
        self.validators_: dict[int, jsonschema.Draft202012Validator] = {}

    def operations(self) -> Iterator[tuple[str, str, dict[str, Any]]]:
        """Yields (path, METHOD, operation), with the parameters of the path among the operation's own."""
        for path, item in self.spec["paths"].items():
            for method, operation in item.items():
                if method == "parameters":
                    continue
                operation = dict(operation)
                operation["parameters"] = [self.resolve(p) for p in
                                           item.get("parameters", []) + operation.get("parameters", [])]
                yield path, method.upper(), operation

    def resolve(self, node: dict[str, Any]) -> dict[str, Any]:
        while "$ref" in node:
            found: Any = self.spec
            for step in node["$ref"].removeprefix("#/").split("/"):
                found = found[step]
            node = found
        return node

    def schema(self, node: dict[str, Any]) -> dict[str, Any]:
        """Returns a self-contained schema."""
        return {**copy.deepcopy(node), "components": self.spec["components"]}

    def operation_of(self, method: str, path: str) -> dict[str, Any] | None:
        return next((operation for verb, pattern, operation in self.patterns_ if verb == method and pattern.fullmatch(path)), None)

    def validator(self, node: dict[str, Any]) -> jsonschema.Draft202012Validator:
        """Returns the validator of a schema of the contract."""
        if id(node) not in self.validators_:
            self.validators_[id(node)] = jsonschema.Draft202012Validator(self.schema(node), format_checker=jsonschema.FormatChecker())
        return self.validators_[id(node)]

    def check(self, answer: httpx.Response) -> None:
        """An httpx event hook that raises AssertionError for a response that the contract does not allow."""
        answer.read()
        request = answer.request
        where = f"{request.method} {request.url.path} -> {answer.status_code}"
        assert answer.headers.get("x-request-id"), f"{where}: no request id"
        if answer.status_code in (429, 503):
            assert int(answer.headers["retry-after"]) >= 1, where
        operation = self.operation_of(request.method, request.url.path)
        if operation is None:
            assert answer.status_code in (204, 400, 404, 405, 200), where
            return
        self.seen.add((operation["operationId"], answer.status_code))
        responses = operation["responses"]
        declared = responses.get(str(answer.status_code))
        assert declared or answer.status_code >= 400, f"{where}: a success that is not in the contract"
        declared = self.resolve(declared or responses["default"])
        for name, header in declared.get("headers", {}).items():
            if name in answer.headers:
                self._check_value(where, name, answer.headers[name], self.resolve(header)["schema"])
            else:
                assert name in ("Retry-After", "Upload-Expires", "ETag"), f"{where}: {name} is missing"
        content = declared.get("content", {})
        if request.method == "HEAD" or not content:
            assert answer.content == b"", f"{where}: a body that is not in the contract"
            return
        media = answer.headers["content-type"].split(";")[0]
        assert media in content, f"{where}: {media} is not in the contract"
        if media.endswith("json"):
            checker = self.validator(content[media]["schema"])
            errors = [f"{e.json_path}: {e.message}" for e in checker.iter_errors(answer.json())]
            assert not errors, f"{where}: {errors}"

    def _check_value(self, where: str, name: str, text: str, schema: dict[str, Any]) -> None:
        schema = self.resolve(schema)
        value: Any = int(text) if schema.get("type") == "integer" else text
        assert self.validator(schema).is_valid(value), f"{where}: {name}: {text}"
