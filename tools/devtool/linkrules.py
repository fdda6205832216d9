"""Compares the graph of CMake's targets with the allowed links in link_rules.toml."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Iterable

from . import build, commands, cycles, filelint, paths

RULES = Path(__file__).with_name("link_rules.toml")
TRIALS = ("bench", "tests")    # folders of code that only measures and tests the product
PROGRAM = "egg"            # shapes in CMake's graph
UNKNOWN = "septagon"
_NODE = re.compile(r'^\s*"(node\d+)" \[ label = "([^"]+)", shape = (\w+) \];')
_EDGE = re.compile(r'^\s*"(node\d+)" -> "(node\d+)"')
_INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


@dataclass(frozen=True)
class Graph:
    """The project's own targets: the shape of each, and direct links between them."""

    shapes: dict[str, str]
    links: frozenset[tuple[str, str]]


def parse(dot: str) -> Graph:
    nodes: dict[str, tuple[str, str]] = {}
    edges = []
    for line in dot.splitlines():
        if found := _NODE.match(line):
            nodes[found[1]] = (found[2].split("\\n")[0], found[3])
        elif found := _EDGE.match(line):
            edges.append((found[1], found[2]))
    ours = {node: name for node, (name, shape) in nodes.items() if "::" not in name and shape != UNKNOWN}
    shapes = {name: nodes[node][1] for node, name in ours.items()}
    return Graph(shapes, frozenset((ours[a], ours[b]) for a, b in edges if a in ours and b in ours))


def violations(graph: Graph, allowed: dict[str, list[str]]) -> list[str]:
    """Returns one sentence per violation. Tests and benchmarks may link any library, but no program."""
    found = []
    for name, shape in sorted(graph.shapes.items()):
        if not _is_trial(name) and name not in allowed:
            found.append(f"target {name} is missing from {RULES.name}: add it with the targets that it may link")
        for user, used in sorted(graph.links):
            if used == name and shape == PROGRAM:
                found.append(f"{user} links the program {used}, but programs must not be linked")
    for user, used in sorted(graph.links):
        if user in allowed and used not in allowed[user] and graph.shapes[used] != PROGRAM:
            found.append(f"{user} links {used}, but may link only: {', '.join(allowed[user]) or 'nothing'}")
    return found


def header_violations(sources: dict[str, str], owners: dict[str, list[str]]) -> list[str]:
    """Returns files that include headers of a library in another folder that they may not use. `sources` maps names in the
    checkout to texts."""
    found = []
    for name, text in sorted(sources.items()):
        if _is_trial(name.rpartition(".")[0]):
            continue
        for header in _INCLUDE.findall(text):
            for prefix, folders in owners.items():
                if header.startswith(prefix) and not any(name.startswith(f"{folder}/") for folder in folders):
                    found.append(f"{name} includes <{header}>, but only {', '.join(folders)} may include it")
    return found


def layer_violations(sources: dict[str, str], layers: dict[str, dict], features: dict[str, list[str]]) -> list[str]:
    """Returns includes between files of api's features that the order of layers or of features forbids."""
    found = []
    for name, text in sorted(sources.items()):
        layer, feature = _layer(name, layers, features), name.rpartition("/")[0]
        if layer is None or _is_trial(name.rpartition(".")[0]):
            continue
        for header in _INCLUDE.findall(text):
            other, owner = _layer(header, layers, features), header.rpartition("/")[0]
            if other is None:
                continue
            if other not in layers[layer]["includes"]:
                found.append(f"{name} includes {header}, but the layer '{layer}' may include only: {', '.join(layers[layer]['includes'])}")
            elif layer != "routes" and owner != feature and owner not in features[feature]:
                found.append(f"{name} includes {header}, but {feature} may include only: {', '.join(features[feature]) or 'nothing'}")
    return found


def _layer(name: str, layers: dict[str, dict], features: dict[str, list[str]]) -> str | None:
    if name.rpartition("/")[0] not in features:
        return None
    return next((layer for layer, rule in layers.items() if any(fnmatch(name, pattern) for pattern in rule["files"])), None)


def trial_violations(sources: dict[str, str]) -> list[str]:
    """Returns product files that include code for measuring or testing."""
    return [f"{name} includes {header}, but only tests and benchmarks may include {header.partition('/')[0]}/"
            for name, text in sorted(sources.items()) if not _is_trial(name.rpartition(".")[0])
            for header in _INCLUDE.findall(text) if _is_trial(header)]


def support_violations(sources: dict[str, str]) -> list[str]:
    """Returns headers in product folders that only tests and benchmarks include."""
    users: dict[str, set[str]] = {}
    for name, text in sources.items():
        for header in _INCLUDE.findall(text):
            users.setdefault(header, set()).add(name.rpartition(".")[0])
    return [f"{name} is included by tests and benchmarks alone: move it into tests/support/"
            for name in sorted(sources) if name in users and not _is_trial(name)
            and all(_is_trial(user) for user in users[name] - {name.rpartition(".")[0]})]


def prefix_violations(sources: Iterable[str], limits: dict[str, int]) -> list[str]:
    """Returns files whose prefix should be a folder."""
    found = []
    for prefix, limit in limits.items():
        count = sum(name.rpartition("/")[2].startswith(prefix) for name in sources)
        if count > limit:
            found.append(f"{count} files begin with {prefix}, but at most {limit} are allowed. Put new ones into a folder instead")
    return found


def _is_trial(name: str) -> bool:
    return name.endswith("_test") or name.startswith(tuple(f"{room}/" for room in TRIALS))


def rules() -> dict:
    return tomllib.loads(RULES.read_text(encoding="utf-8"))


def graph_of(folder: Path) -> Graph:
    dot = folder / "targets.dot"
    commands.output(["cmake", f"--graphviz={dot}", folder], env=build.environment())
    return parse(dot.read_text(encoding="utf-8"))


def check() -> list[str]:
    book = rules()
    sources = {str(path.relative_to(paths.REPO)): path.read_text(encoding="utf-8") for path in cpp_sources()}
    pages = {str(path.relative_to(paths.REPO)): path.read_text(encoding="utf-8") for path in filelint.files()
             if path.suffix in (".ts", ".tsx") and path.is_relative_to(paths.FRONTEND)}
    return (violations(graph_of(build.configure()), book["links"]) + header_violations(sources, book["headers"])
            + layer_violations(sources, book["layers"], book["features"])
            + trial_violations(sources) + support_violations(sources) + prefix_violations(sources, book["prefixes"])
            + [f"cycle: {', '.join(found)}" for graph in (cycles.includes(sources), cycles.imports(pages)) if (found := cycles.cycle(graph))])


def cpp_sources() -> list[Path]:
    """Returns the project's C++ and CUDA files, committed or not."""
    return [path for path in filelint.files() if path.suffix in (".h", ".cpp", ".cu", ".cuh")]
