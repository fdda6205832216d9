"""The access matrix access_matrix.txt, and its operations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from api_client import CONTRACT
from access_matrix_fixture import ROLES

TABLE = Path(__file__).with_name("access_matrix.txt")
#: Path, method and operation by operationId.
OPERATIONS: dict[str, tuple[str, str, dict[str, Any]]] = {
    operation["operationId"]: (path, method, operation) for path, method, operation in CONTRACT.operations()}


def read_table() -> dict[str, dict[str, str]]:
    rows: dict[str, dict[str, str]] = {}
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if words := line.partition("#")[0].split():
            name, *cells = words
            assert len(cells) == len(ROLES), f"{name}: {len(cells)} cells"
            assert name not in rows, f"{name} is there twice"
            assert all(cell == "+" or cell in ("401", "403", "404", "410", "503") for cell in cells), line
            rows[name] = dict(zip(ROLES, cells))
    return rows


ROWS = read_table()
