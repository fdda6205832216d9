"""Finds cycles of includes and imports among the project's own files."""

from __future__ import annotations

import os
import re
from graphlib import CycleError, TopologicalSorter
from typing import Iterable, Mapping

_INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
_IMPORT = re.compile(r'^\s*(?:import|export)\s+[^;"\']*?\bfrom\s+["\'](\.[^"\']*)["\']|\bimport\s*\(?\s*["\'](\.[^"\']*)["\']', re.MULTILINE)


def includes(sources: Mapping[str, str]) -> dict[str, set[str]]:
    """Returns the own files that each C++ or CUDA file includes. `sources` maps names in the checkout to texts."""
    return {name: {one for one in _INCLUDE.findall(text) if one in sources} for name, text in sources.items()}


def imports(sources: Mapping[str, str]) -> dict[str, set[str]]:
    """Returns the own files that each TypeScript file imports: statically, dynamically or for types alone."""
    graph = {}
    for name, text in sources.items():
        targets = {os.path.normpath(os.path.join(os.path.dirname(name), one or other)) for one, other in _IMPORT.findall(text)}
        graph[name] = {path for target in targets for path in (target, f"{target}.ts", f"{target}.tsx", f"{target}/index.ts") if path in sources}
    return graph


def cycle(graph: Mapping[str, Iterable[str]]) -> list[str]:
    """Returns a cycle, beginning and ending with the same file, or an empty list if there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []
