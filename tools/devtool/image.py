"""The container image: the files of this machine that go into it (`stage`), and its build with buildah (Containerfile)."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import tarfile
from pathlib import Path

from . import build, commands, install, packages, paths, sbom, study, venv
from .console import CliError, say, step
from .plan import POSTGRES_BIN

CHART = paths.REPO / "helm" / "diaphane"
LIMIT = 800_000_000
#: Tools for users in a pod, besides the chart's programs, if the build contains them.
_TOOLS = ("diaphane-scan", "diaphane-export", "diaphane-align", "diaphane-render", "diaphane-sample")
_NGINX = Path("/usr/sbin/nginx")
#: Modules that the edge's configuration loads, and Debian's packages with the Lua files that the second one needs.
NGINX_MODULES = (Path("/usr/lib/nginx/modules/ndk_http_module.so"), Path("/usr/lib/nginx/modules/ngx_http_lua_module.so"))
_LUA_PACKAGES = ("lua-resty-core", "lua-resty-lrucache")
#: Debian's Python, without pip and the documents, for the analysis of studies.
PYTHON = Path("/usr/bin/python3.11")
#: For backups. Debian's /usr/bin/pg_dump is a Perl script.
_BACKUP_PROGRAMS = (*(POSTGRES_BIN / name for name in ("pg_dump", "pg_restore", "psql")), Path("/usr/bin/restic"))
_PYTHON_PACKAGES = ("python3.11-minimal", "libpython3.11-minimal", "libpython3.11-stdlib")
_CERTIFICATES = Path("/usr/share/ca-certificates/mozilla")
#: Debian packages that the machine which builds the image needs. They contain no services.
_MAKERS = ["buildah", "debootstrap"]


def version() -> str:
    """Returns the version of the chart's programs, which is the image's tag."""
    return re.search(r'^appVersion: "(.+)"$', (CHART / "Chart.yaml").read_text(encoding="utf-8"), re.MULTILINE)[1]


def name() -> str:
    return f"localhost/diaphane:{version()}"


def chart_programs() -> list[str]:
    """Returns the programs that the chart's pods start."""
    text = "".join(file.read_text(encoding="utf-8") for file in sorted((CHART / "templates").rglob("*.yaml")))
    return sorted(set(re.findall(r"/opt/diaphane/bin/(diaphane-[a-z]+)", text)))


# Contents

def stage(into: Path) -> None:
    """Arranges the files in `into` as they will be in the image."""
    if into.exists():
        raise CliError(f"{into} already exists")
    bin_dir = paths.build_dir() / "bin"
    needed = chart_programs()
    if absent := [program for program in needed if not (bin_dir / program).exists()]:
        raise CliError(f"{bin_dir} lacks programs that the chart starts: {', '.join(absent)}")
    ours = [bin_dir / program for program in (*needed, *_TOOLS) if (bin_dir / program).exists()]
    page = paths.FRONTEND / "dist"
    if not (page / "index.html").exists():
        raise CliError("the web page is not built (frontend/dist is missing)")
    home = into / "opt" / "diaphane"
    (home / "bin").mkdir(parents=True)
    for file in ours:
        commands.output(["strip", "-o", home / "bin" / file.name, file])
    shutil.copytree(page, home / "page")
    shutil.copytree(paths.REPO / "migrations", home / "migrations")
    _nvrtc(bin_dir / "diaphane-renderd", home / "lib")
    _studies(home / "studies")
    _pacs(home / "pacs")
    shutil.copytree(paths.REPO / "backup" / "diaphane_backup", home / "backup" / "diaphane_backup", ignore=shutil.ignore_patterns("__pycache__"))
    python = _package_files(*_PYTHON_PACKAGES)
    edge = [_NGINX, *NGINX_MODULES, *_BACKUP_PROGRAMS]
    for file in (*edge, *_package_files(*_LUA_PACKAGES, below="/usr/share/lua/"), *python):
        _put(file, into)
    _certificates(into)
    _libraries(ours, [*edge, *(file for file in python if file.suffix == ".so" or file == PYTHON)], into, home)


def _put(file: Path, into: Path) -> None:
    """Copies a file to its place, and the target of a link. Debian's /lib is /usr/lib."""
    place = into / str(file.parent.resolve() / file.name).lstrip("/")
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.exists() or place.is_symlink():
        return
    shutil.copy2(file, place, follow_symlinks=False)
    if file.is_symlink():
        target = Path(os.readlink(file))
        _put(target if target.is_absolute() else file.parent / target, into)


def _package_files(*names: str, below: str = "/usr/") -> list[Path]:
    listed = commands.output(["dpkg-query", "-L", *names])
    return [file for line in listed.splitlines()
            if line.startswith(below) and not line.startswith("/usr/share/doc") and (file := Path(line)).is_file() and "__pycache__" not in line]


def _pacs(into: Path) -> None:
    """Copies the PACS gateway, the Python client that it uses, and their libraries."""
    leave_out = shutil.ignore_patterns("__pycache__", "*.pyc")
    shutil.copytree(venv.PACS.folder, into, ignore=leave_out)
    shutil.copytree(paths.REPO / "pacs" / "diaphane_pacs", into / "diaphane_pacs", ignore=leave_out)
    shutil.copytree(paths.REPO / "clients" / "python" / "src" / "diaphane", into / "diaphane", ignore=leave_out)


def _studies(into: Path) -> None:
    """Copies the analysis of studies and its libraries, which bring their own shared libraries."""
    leave_out = shutil.ignore_patterns("__pycache__", "*.pyi", "*.pxd", "*.h", "sample_data")
    shutil.copytree(study.libraries(), into, ignore=leave_out)
    shutil.copytree(study.PACKAGE / "diaphane_studies", into / "diaphane_studies", ignore=leave_out)


def _nvrtc(renderd: Path, into: Path) -> None:
    """Copies the run-time compiler of kernels if the CUDA engine is built in."""
    if b"nvrtcCompileProgram" not in renderd.read_bytes():
        say("renderd was built without CUDA, so the image contains only the CPU engine")
        return
    found = [file for file in sorted((venv.cuda_root() / "lib").glob("libnvrtc*.so.*")) if ".alt." not in file.name]
    if len(found) != 2:
        raise CliError(f"NVRTC was not found in {venv.cuda_root() / 'lib'} (see docs/gpu.md)")
    into.mkdir(parents=True)
    for file in found:
        shutil.copy2(file, into / file.name)


def _certificates(into: Path) -> None:
    """Copies Mozilla's certificates from Debian, without those that an administrator added to this machine."""
    place = into / "etc" / "ssl" / "certs" / "ca-certificates.crt"
    place.parent.mkdir(parents=True)
    texts = [file.read_text(encoding="ascii") for file in sorted(_CERTIFICATES.glob("*.crt"))]
    if not texts:
        raise CliError("the Debian package ca-certificates is not installed")
    place.write_text("".join(texts), encoding="ascii")


def _libraries(ours: list[Path], edge: list[Path], into: Path, home: Path) -> None:
    """Copies all libraries that the loader would load, each package's licence and its entry for vulnerability scanners, and the
    list of components."""
    programs = [*ours, *edge]
    linked = {program: sbom.linked_files(program) for program in programs}
    files = {file for listed in linked.values() for file in listed}
    for file in files:
        _put(file, into)
    owner = sbom.owners([*files, *edge])
    names = {*owner.values(), *_LUA_PACKAGES, *_PYTHON_PACKAGES, "ca-certificates"}
    parts = sbom.debian_parts(names, needed=True)
    for package in sorted(parts):
        _package(package, into)
    made = [sbom.Program(program.name, [parts[owner[file]].url for file in linked[program] if owner.get(file) in parts]) for program in programs]
    npm = sbom.npm_parts(json.loads((paths.FRONTEND / "package-lock.json").read_text(encoding="utf-8")))
    cuda = sbom.python_parts((paths.TOOLS / "cuda-requirements.txt").read_text(encoding="utf-8")) if (home / "lib").exists() else []
    studies = sbom.python_parts("\n".join((paths.REPO / folder / "requirements.txt").read_text(encoding="utf-8") for folder in ("studies", "pacs")), needed=True)
    listed = [*parts.values(), *studies, *(part for part in npm if part.needed), *(part for part in cuda if part.name == "cuda-toolkit")]
    document = sbom.document(version(), "1970-01-01T00:00:00Z", made, listed)
    (home / "sbom.json").write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def _package(package: str, into: Path) -> None:
    plain = package.partition(":")[0]
    _documents(Path("/usr/share/doc") / plain, into)
    status = commands.output(["dpkg-query", "-s", package])
    place = into / "var/lib/dpkg/status.d" / plain
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(status, encoding="utf-8")


def _documents(of: Path, into: Path) -> None:
    """Copies a package's licence. Some folders, such as that of libgcc-s1, are links to that of their source package."""
    place = into / str(of).lstrip("/")
    if of.is_symlink():
        place.parent.mkdir(parents=True, exist_ok=True)
        if not place.is_symlink():
            place.symlink_to(os.readlink(of))
        _documents(of.parent / os.readlink(of), into)
    elif (of / "copyright").exists():
        place.mkdir(parents=True, exist_ok=True)
        shutil.copy2(of / "copyright", place / "copyright")


# Build

def folder() -> Path:
    return paths.REPO / "build" / "image"


def buildah(*arguments: str, capture: bool = True) -> str:
    """Runs buildah with its own store. Uses no overlay file system and no namespaces, which are not available everywhere."""
    store = folder()
    command = ["buildah", "--root", str(store / "store"), "--runroot", str(store / "run"), "--storage-driver", "vfs", *arguments]
    env = {**os.environ, "BUILDAH_ISOLATION": "chroot"}
    if capture:
        return commands.output(command, f"buildah {arguments[0]}", env=env).strip()
    if subprocess.run(command, stdin=subprocess.DEVNULL, env=env).returncode != 0:
        raise CliError(f"buildah {arguments[0]} failed; see its output above")
    return ""


def _base() -> str:
    """Returns a Debian of this machine's release, which debootstrap creates once."""
    release = re.search(r"^VERSION_CODENAME=(\S+)", Path("/etc/os-release").read_text(encoding="utf-8"), re.MULTILINE)[1]
    tag = f"localhost/debian-minbase:{release}"
    made = folder() / f"base-{release}"
    archive = made / "base.tar"
    if not archive.exists():
        step(f"Building a Debian {release} base image with debootstrap (takes several minutes)")
        shutil.rmtree(made, ignore_errors=True)
        root = made / "root"
        root.mkdir(parents=True)
        commands.output(["debootstrap", "--variant=minbase", release, root, _mirror(release)], "debootstrap")
        (root / "etc/apt/sources.list").write_text(f"deb http://deb.debian.org/debian {release} main\n", encoding="ascii")
        for cache in (root / "var/cache/apt/archives").glob("*.deb"):
            cache.unlink()
        for machine in ("etc/resolv.conf", "etc/hostname"):
            (root / machine).unlink(missing_ok=True)
        with tarfile.open(made / "new.tar", "w") as tar:
            for entry in sorted(root.iterdir()):
                if entry.name not in ("proc", "sys", "dev"):
                    tar.add(entry, entry.name)
                else:
                    tar.add(entry, entry.name, recursive=False)
        shutil.rmtree(root)
        (made / "new.tar").rename(archive)
    (made / "Containerfile").write_text("FROM scratch\nADD base.tar /\n", encoding="ascii")
    buildah("bud", "-t", tag, str(made))
    return tag


def _mirror(release: str) -> str:
    """Returns the mirror from which this machine installs Debian."""
    urls = subprocess.run(["apt-get", "indextargets", "--format", "$(REPO_URI)", "Identifier: Packages", f"Codename: {release}", "Component: main"],
                          capture_output=True, text=True).stdout.split()
    return urls[0] if urls else "http://deb.debian.org/debian"


def run(out: Path | None, check: bool, base: str | None, source: bool, only_stage: Path | None) -> int:
    if only_stage is None and os.geteuid() != 0:
        raise CliError("building an image requires root (for debootstrap and file ownership)")
    if not source:
        install.ensure("image")
        if absent := packages.missing(["restic"]):
            packages.install(absent)
        build.build_page()
        build.build_programs()
    if only_stage is not None:
        stage(only_stage)
        return 0
    if absent := packages.missing(_MAKERS):
        packages.install(absent)
    folder().mkdir(parents=True, exist_ok=True)
    base = base or _base()
    context = paths.REPO
    if not source:
        step("Copying files into the build context")
        context = folder() / "context"
        shutil.rmtree(context, ignore_errors=True)
        stage(context / "staged")
    step("Building the image")
    buildah("bud", "-t", name(), "--build-arg", f"BASE={base}", "-f", str(paths.REPO / "Containerfile"), str(context), capture=not source)
    if out is not None:
        out.unlink(missing_ok=True)
        buildah("push", name(), f"oci-archive:{out.resolve()}:{name()}")
        step(f"{out}: {out.stat().st_size / 1e6:.0f} MB compressed")
    step(f"{name()} in {folder() / 'store'}")
    if check:
        from . import image_check

        return image_check.run()
    return 0
