"""The components of Diaphane as CycloneDX 1.6: Debian's packages per program, locked npm and PyPI packages, and Go modules.
`document` is a pure function of `Part`s. The rest reads them from programs, dpkg and lock files."""

from __future__ import annotations

import base64
import json
import re
import subprocess
import uuid
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterable, Sequence
from urllib.parse import quote

from . import build, packages, paths
from .console import CliError, say, to_stderr

#: Namespace of the URN that identifies the document.
_NAMESPACE = uuid.UUID("9c1f8b52-6c0e-4a4f-9a5b-2f6d3e8a7c41")


@dataclass(frozen=True)
class Part:
    """A component. `kind` is deb, npm, pypi or golang. `needed` means at run time, not only for
    building and testing."""

    kind: str
    name: str
    version: str
    needed: bool = True
    licence: str = ""
    sha512: str = ""                       # of the archive, in hexadecimal
    arch: str = ""

    @property
    def url(self) -> str:
        """Returns the package URL (purl-spec)."""
        name = {"pypi": re.sub(r"[-_.]+", "-", self.name).lower(), "deb": f"debian/{self.name}"}.get(self.kind, self.name)
        # "+", ":" and "@" have special meanings in URLs.
        url = f"pkg:{self.kind}/{quote(name, safe='/-._~')}@{quote(self.version, safe='-._~')}"
        return url + (f"?arch={self.arch}" if self.arch else "")


@dataclass(frozen=True)
class Program:
    name: str
    uses: Sequence[str] = field(default_factory=tuple)   # package URLs


def document(version: str, when: str, programs: Sequence[Program], parts: Iterable[Part]) -> dict:
    """Returns the document, which is the same for the same parts. `when` is in the format of RFC
    3339."""
    merged: dict[str, Part] = {}
    for part in parts:
        known = merged.get(part.url)
        merged[part.url] = part if known is None or part.needed and not known.needed else known
    listed = [_component(merged[url]) for url in sorted(merged)]
    for program in programs:
        listed.append({"type": "application", "bom-ref": program.name, "name": program.name, "version": version, "scope": "required"})
    needed = [url for url in sorted(merged) if merged[url].needed and not url.startswith("pkg:deb/")]
    root = {"type": "application", "bom-ref": "diaphane", "name": "diaphane", "version": version}
    links = [{"ref": "diaphane", "dependsOn": [program.name for program in programs] + needed}]
    links += [{"ref": program.name, "dependsOn": sorted(set(program.uses))} for program in programs]
    content = json.dumps([version, listed, links], sort_keys=True)
    return {"$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json", "bomFormat": "CycloneDX", "specVersion": "1.6",
            "serialNumber": f"urn:uuid:{uuid.uuid5(_NAMESPACE, content)}", "version": 1,
            "metadata": {"timestamp": when, "component": root}, "components": listed, "dependencies": links}


def _component(part: Part) -> dict:
    group, _, name = part.name.rpartition("/") if part.kind == "npm" else ("", "", part.name)
    made = {"type": "library", "bom-ref": part.url, "name": name, "version": part.version, "purl": part.url,
            "scope": "required" if part.needed else "excluded"}
    if group:
        made["group"] = group
    if part.licence:
        made["licenses"] = [{"license": {"name": part.licence}}]
    if part.sha512:
        made["hashes"] = [{"alg": "SHA-512", "content": part.sha512}]
    return made


# Lock files

def npm_parts(lock: dict) -> list[Part]:
    made = []
    for path, entry in lock["packages"].items():
        if not path or entry.get("link"):
            continue
        name = entry.get("name") or path.rpartition("node_modules/")[2]
        algorithm, _, digest = entry.get("integrity", "").partition("-")
        licence = entry.get("license", "")
        made.append(Part("npm", name, entry["version"], not (entry.get("dev") or entry.get("devOptional")),
                         licence if isinstance(licence, str) else "",
                         base64.b64decode(digest).hex() if algorithm == "sha512" else ""))
    return made


def python_parts(text: str, needed: bool = False) -> list[Part]:
    """Returns the parts of a requirements file. Only the analysis of studies and the PACS gateway need PyPI packages at run time."""
    lines = (re.sub(r"\s*(#|--hash=).*", "", line).strip() for line in text.splitlines())
    found = (re.fullmatch(r"([A-Za-z0-9._-]+)(?:\[[^\]]*\])?==(\S+)", line) for line in lines if line)
    return [Part("pypi", match[1], match[2], needed=needed) for match in found if match]


def go_parts(text: str, needed: bool = True) -> list[Part]:
    """Returns the parts of a go.mod. A replaced module counts as its replacement."""
    required: dict[str, str] = {}
    replaced: dict[str, tuple[str, str]] = {}
    block = ""
    for line in text.splitlines():
        words = line.partition("//")[0].split()
        if words[1:] == ["("]:
            block = words[0]
        elif words == [")"]:
            block = ""
        elif words:
            verb, *rest = [block, *words] if block else words
            if verb == "require":
                required[rest[0]] = rest[1]
            elif verb == "replace" and len(rest[rest.index("=>"):]) == 3:
                replaced[rest[0]] = (rest[-2], rest[-1])
    return [Part("golang", *replaced.get(name, (name, version)), needed) for name, version in required.items()]


# Installed packages

def linked_files(program: Path) -> list[Path]:
    """Returns the libraries that the loader would load."""
    done = subprocess.run(["ldd", str(program)], capture_output=True, text=True)
    if done.returncode != 0:
        return []                          # a script, or linked statically
    lost = re.findall(r"(\S+) => not found", done.stdout)
    if lost:
        raise CliError(f"{program.name} needs shared libraries that are not installed: {', '.join(lost)}")
    return [Path(found) for found in re.findall(r"(/\S+) \(0x", done.stdout)]


def owners(files: Iterable[Path]) -> dict[Path, str]:
    """Returns the Debian package of each file as dpkg-query names it (with `:amd64` where applicable). Skips files without a
    package."""
    # dpkg may know a library loaded as /lib/x as /usr/lib/x, and the other way round.
    names: dict[str, Path] = {}
    for file in files:
        real = str(file.resolve())
        for name in (str(file), real, real.removeprefix("/usr"), "/usr" + real):
            names.setdefault(name, file)
    found: dict[Path, str] = {}
    listed = sorted(names)
    for first in range(0, len(listed), 500):
        done = subprocess.run(["dpkg-query", "-S", *listed[first:first + 500]], capture_output=True, text=True)
        for line in done.stdout.splitlines():
            owner, _, name = line.rpartition(": ")
            if name in names and not line.startswith("diversion"):
                found.setdefault(names[name], owner.partition(",")[0])
    return found


def debian_parts(names: Iterable[str], needed: bool) -> dict[str, Part]:
    """Returns parts by the requested names. Skips packages that are not installed."""
    asked = sorted(set(names))
    if not asked:
        return {}
    form = "${binary:Package}\\t${Package}\\t${Version}\\t${Architecture}\\t${db:Status-Status}\\n"
    done = subprocess.run(["dpkg-query", "-W", "-f", form, *asked], capture_output=True, text=True)
    made: dict[str, Part] = {}
    for line in done.stdout.splitlines():
        full, name, version, arch, state = line.split("\t")
        if state == "installed":
            made[full] = made[name] = Part("deb", name, version, needed, arch=arch)
    return {name: made[name] for name in asked if name in made}


#: Debian's programs that `./diaphane up` starts.
RUN = ("nginx-light", "libnginx-mod-http-lua", "postgresql", "redis-server")
#: Header-only libraries, which no program links.
HEADERS_ONLY = ("libboost-dev", "libexpected-dev", "nlohmann-json3-dev", "libtinyexr-dev")


def here(folder: Path) -> tuple[list[Program], list[Part]]:
    """Returns the parts of the programs in `folder`, of this checkout's lock files, and of this machine's Debian packages."""
    binaries = sorted(file for file in folder.glob("diaphane-*") if file.is_file() and not file.name.endswith("_test"))
    if not binaries:
        raise CliError(f"no programs found in {folder}. Run ./diaphane up to build them")
    linked = {file: linked_files(file) for file in binaries}
    owner = owners({library for libraries in linked.values() for library in libraries})
    libraries = debian_parts(owner.values(), needed=True)
    programs = [Program(file.name, [libraries[owner[library]].url for library in linked[file] if owner.get(library) in libraries])
                for file in binaries]
    parts = list(libraries.values()) + list(debian_parts((*RUN, *HEADERS_ONLY), needed=True).values())
    parts += debian_parts(packages.required(), needed=False).values()
    parts += npm_parts(json.loads((paths.FRONTEND / "package-lock.json").read_text(encoding="utf-8")))
    for file in (paths.TOOLS / "requirements.txt", paths.TOOLS / "cuda-requirements.txt", paths.TOOLS / "check-requirements.txt", paths.REPO / "tests" / "requirements.txt"):
        parts += python_parts(file.read_text(encoding="utf-8"))
    for folder in ("studies", "pacs"):
        parts += python_parts((paths.REPO / folder / "requirements.txt").read_text(encoding="utf-8"), needed=True)
    for file in sorted(paths.REPO.rglob("go.mod")):
        if not {"node_modules", "build", ".tools"} & set(file.parts):
            parts += go_parts(file.read_text(encoding="utf-8"), needed="tests" not in file.relative_to(paths.REPO).parts)
    return programs, parts


def run(out: Path | None) -> int:
    def git(*arguments: str) -> str:
        return subprocess.run(["git", "-C", str(paths.REPO), *arguments], capture_output=True, text=True).stdout.strip()

    if out is None:
        to_stderr()
    build.build_programs()
    programs, parts = here(paths.build_dir() / "bin")
    made = document(git("rev-parse", "HEAD") or "unknown", git("log", "-1", "--format=%cI") or "1970-01-01T00:00:00Z", programs, parts)
    text = json.dumps(made, indent=1, ensure_ascii=False) + "\n"
    if out is None:
        print(text, end="")
    else:
        out.write_text(text, encoding="utf-8")
        say(f"{len(made['components'])} components: {out}")
    return 0
