"""Finds cycles of includes and imports among the project's own files."""

from __future__ import annotations

import os
import re
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


def cycles(graph: Mapping[str, Iterable[str]]) -> list[list[str]]:
    """Returns the strongly connected components of more than one file (Tarjan's algorithm), each sorted by name."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    on_stack: set[str] = set()
    found = []
    for root in sorted(graph):
        work = [(root, iter(sorted(graph[root])))] if root not in index else []
        while work:
            node, rest = work[-1]
            if node not in index:
                index[node] = low[node] = len(index)
                stack.append(node)
                on_stack.add(node)
            for target in rest:
                if target not in index:
                    work.append((target, iter(sorted(graph[target]))))
                    break
                if target in on_stack:
                    low[node] = min(low[node], index[target])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    part = []
                    while not part or part[-1] != node:
                        part.append(stack.pop())
                        on_stack.discard(part[-1])
                    if len(part) > 1:
                        found.append(sorted(part))
    return sorted(found)
