"""The command line. A command's module is imported when the command runs, so that `up` needs only the standard library."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path

from . import users
from .console import CliError, warn


def main(arguments: list[str]) -> int:
    parser = _parser()
    if not arguments:
        parser.print_help()
        return 2
    options, rest = parser.parse_known_args(arguments)
    given = vars(options)
    # The parser gives up an optional argument such as EMAIL at the first option before it.
    if len(rest) == 1 and not rest[0].startswith("-") and given.get("email", "") is None:
        given["email"] = rest.pop()
    module, function, takes_rest = given.pop("module"), given.pop("function"), given.pop("takes_rest")
    if takes_rest:
        given["rest"] = rest
    elif rest:
        parser.error(f"unknown arguments: {' '.join(rest)}")
    try:
        return getattr(importlib.import_module(f".{module}", __package__), function)(**given)
    except CliError as error:
        warn(str(error))
        return error.code
    except KeyboardInterrupt:
        warn("interrupted")
        return 130
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w", encoding="ascii")
        return 141


class _Commands:
    def __init__(self) -> None:
        self.parser = argparse.ArgumentParser(prog="./diaphane", description="Diaphane shows CT and MR scans as photo-realistic 3D pictures.")
        self.all = self.parser.add_subparsers(metavar="COMMAND", required=True)

    def __call__(self, name: str, calls: str, about: str, rest: bool = False, data: bool = False) -> argparse.ArgumentParser:
        """Adds a command. `calls` is the MODULE.FUNCTION that gets the options by their names, and
        with `rest` also the arguments that are not options here. With `data`, it works on a data
        directory."""
        made = self.all.add_parser(name, help=about, description=f"{about[0].upper()}{about[1:]}.", add_help=not rest)
        module, _, function = calls.partition(".")
        made.set_defaults(module=module, function=function, takes_rest=rest)
        if data:
            made.add_argument("--data", metavar="FOLDER", type=_path, default=users.default_data_dir(),
                              help="data directory (default: %(default)s)")
        return made


def _parser() -> argparse.ArgumentParser:
    command = _Commands()
    _add_instance(command)
    _add_scans(command)
    _add_checks(command)
    _add_documents(command)
    command("help", "cli.show_help", "show this help")
    return command.parser


def show_help() -> int:
    _parser().print_help()
    return 0


def _may_install(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--no-install", dest="may_install", action="store_false", help="do not install anything: if dependencies are missing, list them and exit")


def _add_instance(command: _Commands) -> None:
    up = command("up", "supervise.up", "install missing dependencies, build and start everything; press Ctrl-C to stop", data=True)
    _may_install(up)
    up.add_argument("--detach", dest="background", action="store_true", help="run in the background and return once everything is ready; stop it with `./diaphane down`")
    up.add_argument("--port", type=_port, metavar="N", help="port of the web page (default: 8080, or the next free port)")
    up.add_argument("--engine", choices=("auto", "cpu", "cuda"), default="auto", help="rendering engine; auto uses CUDA if a GPU is available (default: auto)")
    up.add_argument("--archive", dest="archives", action="append", default=[], metavar="NAME=URL",
                    help="connect to an archive (PACS) with DICOMweb, or to dicom://AE_TITLE@HOST:PORT with DIMSE (repeatable); for more, edit archives.toml in the data directory")
    command("down", "supervise.down", "stop the instance that runs on a data directory", data=True)
    status = command("status", "status.show", "show each program with its port and state, and the rendering engine and device", data=True)
    status.add_argument("--json", dest="as_json", action="store_true", help="print the status as JSON")
    backup = command("backup", "backup.save", "back up a running instance, encrypted, to a folder, s3:... or sftp:... (see docs/operate.md)", data=True)
    backup.add_argument("place", metavar="PLACE", help="repository for restic; it is created if there is none")
    backup.add_argument("--key", type=_path, metavar="FILE", help="key of the repository (default: backup-key in the data directory's secrets, created at the first backup)")
    backup.add_argument("--list", dest="list_only", action="store_true", help="list the backups instead")
    backup.add_argument("--check", dest="check_percent", type=int, choices=range(101), metavar="PERCENT",
                        help="verify the repository instead, and read back this part of its data")
    restore = command("restore", "backup.restore", "restore a backup into a new data directory", data=True)
    restore.add_argument("place", metavar="PLACE", help="repository of the backup")
    restore.add_argument("--key", type=_path, metavar="FILE", required=True, help="key of the repository")
    restore.add_argument("--backup", dest="snapshot", default="latest", metavar="NAME", help="name of the backup from `./diaphane backup PLACE --list` (default: the newest)")


def _add_scans(command: _Commands) -> None:
    command("sample", "run_binary.sample", "upload the sample scan again, or write it as DICOM files (--write-dicom FOLDER)", rest=True, data=True)
    administrators = command("admin", "admin.run", "manage the administrators of a running instance: grant, revoke, list, reset-2fa", data=True)
    administrators.add_argument("what", choices=("grant", "revoke", "list", "reset-2fa", "forget-factor"), metavar="{grant,revoke,list,reset-2fa}",
                                help="grant or revoke the administrator role, list all administrators, or turn off a user's second factor")
    administrators.add_argument("email", nargs="?", metavar="EMAIL", help="confirmed email address of the account (not used by list)")
    command("scan", "run_binary.scan", "list the series in a folder, an archive or a research file and say which are suitable (FOLDER or FILE [--json] [--build VOLUME [--phases LIST]])", rest=True)
    command("export", "run_binary.export", "write a scan as NIfTI, or a part of it as STL or glTF (INPUT OUTPUT ..., see --help)", rest=True)
    command("align", "run_binary.align", "align two scans by a rotation and a shift, and print how well (FIXED MOVING, see --help)", rest=True)
    command("render", "run_binary.render", "render a picture without a server (INPUT ..., see --help)", rest=True)
    command("study", "study.run", "analyse the export of a study, or simulate one (analyse EXPORT or simulate KIND, see --help)", rest=True)
    command("replay", "replay.run", "replay a recorded interaction (FILE, and --link LINK or --scan SCAN --out FOLDER)", rest=True)


def _add_checks(command: _Commands) -> None:
    test = command("test", "testing.run", "build and run the tests; the last line of output is `N passed, N failed`")
    test.add_argument("kind", nargs="?", choices=("unit", "integration", "e2e", "gpu", "cluster", "node"),
                      help="run only these tests (default: unit, integration and e2e)")
    test.add_argument("--all", dest="nightly", action="store_true", help="the nightly lane: also the tests that take long, longer fuzzing, the sanitizers and Kubernetes")
    _may_install(test)
    test.add_argument("--checks", dest="with_checks", action="store_true", help="also run `./diaphane check`; each check counts as a test")
    check = command("check", "check.run", "run the static checks: formatting, prose, linters, types, link rules and API contracts")
    check.add_argument("--fix", action="store_true", help="let clang-format, Prettier and ESLint fix what they can")
    check.add_argument("--only", metavar="NAME", action="append", default=[], help="run only this check: files, prose, format, contracts, links, types, lint, client, services or tidy (repeatable)")
    fuzz = command("fuzz", "fuzz.run", "fuzz the upload, volume, request and stream parsers (libFuzzer with ASan and UBSan)")
    fuzz.add_argument("target", nargs="?", metavar="TARGET", help="precheck, codestream, nifti, labels, tar, report, volume, viewer, stream, fields, preset, recording, scene_xml or panorama (default: all)")
    fuzz.add_argument("--seconds", type=int, default=60, metavar="N", help="duration per target in seconds (default: 60)")
    fuzz.add_argument("--minimise", action="store_true", help="then minimise the corpus in tests/fuzz/corpus without losing coverage")
    races = command("races", "races.run", "run the multi-threaded tests under ThreadSanitizer")
    races.add_argument("programs", nargs="*", metavar="PROGRAM", help="test program (default: all multi-threaded ones)")
    mutants = command("mutants", "mutants.command", "put random faults into the product and count those that the tests notice")
    mutants.add_argument("--count", type=int, default=300, metavar="N", help="number of mutants (default: 300)")
    mutants.add_argument("--seed", type=int, default=1, metavar="N", help="draw other mutants (default: 1)")
    mutants.add_argument("--area", dest="areas", action="append", metavar="NAME",
                         help="renderer, scheduler, access, ingest, operator, page or tools (repeatable; default: all but tools)")
    mutants.add_argument("--jobs", type=int, metavar="N", help="copies of the sources that are tested in parallel (default: three quarters of the cores)")
    mutants.add_argument("--minutes", type=float, metavar="N", help="start no more mutants after this time")
    mutants.add_argument("--deep", action="store_true", help="let the integration tests look for what the unit tests missed")
    mutants.add_argument("--json", type=Path, metavar="FILE", help="write each mutant and its outcome to this file")
    bench = command("bench", "bench.run", "run a benchmark; without a name, list all benchmarks", rest=True)
    bench.add_argument("name", nargs="?", metavar="NAME", help="benchmark to run")
    bench.add_argument("--json", dest="json_file", type=Path, metavar="FILE", help="write the results to this file")
    bench.add_argument("--quick", action="store_true", help="fewer repetitions")
    bench.set_defaults(print_help=bench.print_help)    # NAME --help belongs to the measurement


def _add_documents(command: _Commands) -> None:
    command("bounds", "bounds.run", "write docs/bounds.md from docs/bounds.toml")
    command("client", "client_code.run", "generate the part of the Python client that follows from the API contract")
    command("figures", "figures.run", "write docs/figures.md from the benchmark results in docs/figures/")
    bill = command("sbom", "sbom.run", "write the software bill of materials as CycloneDX JSON")
    bill.add_argument("out", nargs="?", type=Path, metavar="FILE", help="output file (default: standard output)")
    made = command("image", "image.run", "build the container image with buildah from this checkout's programs (requires root)")
    made.add_argument("--out", type=Path, metavar="FILE.tar", help="also export the image as an OCI archive")
    made.add_argument("--check", action="store_true", help="then verify the image: its size, that it contains no compiler, and that each program runs on a read-only root")
    made.add_argument("--base", metavar="IMAGE", help="Debian 12 base image to pull (default: build one with debootstrap)")
    made.add_argument("--source", action="store_true", help="compile the programs inside the image from this checkout's sources")
    made.add_argument("--stage", dest="only_stage", type=Path, metavar="FOLDER", help="only copy the image's files to this folder (the Containerfile's first stage)")
    pictures = command("screenshots", "screenshots.run", "take screenshots of every page in three sizes, light and dark, for manual review")
    pictures.add_argument("out", type=Path, metavar="FOLDER", help="output folder")
    pictures.add_argument("--only", default="", metavar="TEXT", help="only screenshots whose name contains this text (person-scans, nobody-sign-in, viewer-light, ...)")
    pictures.add_argument("--size", dest="one_size", choices=("phone", "tablet", "desk"), help="only this size")
    pictures.add_argument("--look", dest="one_look", choices=("light", "dark"), help="only this colour scheme")
    command("guide", "screenshots.guide", "recreate the pictures of docs/guide.md")


def _path(text: str) -> Path:
    return Path(text).expanduser().resolve()


def _port(text: str) -> int:
    number = int(text)
    if not 1024 <= number < 65536:
        raise argparse.ArgumentTypeError("not a port from 1024 to 65535 (lower ports require root, and Diaphane does not run as root)")
    return number
