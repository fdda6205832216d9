"""The command line. Each command's module is imported when it is asked for: `up` needs the standard library only."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from . import users
from .says import HouseError, say, warn


def main(arguments: list[str]) -> int:
    parser = _parser()
    if not arguments:
        parser.print_help()
        return 2
    options, rest = parser.parse_known_args(arguments)
    if rest and not getattr(options, "takes_rest", False):
        parser.error(f"unknown: {' '.join(rest)}")
    try:
        return options.run(options, rest)
    except HouseError as error:
        warn(str(error))
        return error.code
    except KeyboardInterrupt:
        warn("interrupted")
        return 130
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w", encoding="ascii")
        return 141


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="./diaphane", description="Photo-realistic pictures of your own scan.")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)

    def command(name: str, run, about: str, rest: bool = False) -> argparse.ArgumentParser:
        # The tools behind `rest` have their own --help.
        made = commands.add_parser(name, help=about, description=about, add_help=not rest)
        made.set_defaults(run=run, takes_rest=rest)
        return made

    def with_data(made: argparse.ArgumentParser) -> None:
        made.add_argument("--data", type=lambda text: Path(text).expanduser().resolve(),
                          help=f"data directory (default {users.default_data_dir()})")

    up = command("up", _up, "install what is missing, build, and start everything; Ctrl-C stops it")
    with_data(up)
    up.add_argument("--no-install", action="store_true", help="only list what is missing; go on when nothing is")
    up.add_argument("--detach", action="store_true", help="return when it is ready; `down` stops it")
    up.add_argument("--port", type=_port, metavar="N", help="port of the page (default 8080, or the next free one)")
    up.add_argument("--engine", choices=("auto", "cpu", "cuda"), default="auto", help="what renders (default auto)")
    with_data(command("down", _down, "stop what runs on a data directory"))
    status = command("status", _status, "each program, its port, ready or not; engine and device")
    with_data(status)
    status.add_argument("--json", action="store_true")
    test = command("test", _test, "build and run the tests; the last line is `N passed, N failed`")
    test.add_argument("kind", nargs="?", choices=("unit", "integration", "e2e", "gpu", "cluster", "node"))
    test.add_argument("--no-install", action="store_true", help="only list what is missing; go on when nothing is")
    test.add_argument("--checks", action="store_true", help="with what ./diaphane check does, each counted as a test")
    check = command("check", _check, "format, clang-tidy, link rules, types, lint, contracts")
    check.add_argument("--fix", action="store_true", help="let clang-format and eslint mend what they can")
    check.add_argument("--only", metavar="NAME", action="append", help="only this check (repeatable)")
    with_data(command("sample", _sample, "load the sample scan once more; --write-dicom FOLDER: write it as a scanner would",
                      rest=True))
    administrators = command("admin", _admin, "who is an administrator, of what runs on a data directory: grant EMAIL, revoke EMAIL, list; forget-factor EMAIL: of who lost the second factor")
    with_data(administrators)
    administrators.add_argument("what", choices=("grant", "revoke", "list", "forget-factor"), help="give the role, take it away, show who has it; let in who lost the second factor")
    administrators.add_argument("email", nargs="?", metavar="EMAIL", help="of an account whose address is confirmed (not with list)")
    command("scan", _tool("diaphane-scan"), "FOLDER [--json] [--build VOLUME]: the series in a folder, and which are suitable", rest=True)
    command("render", _tool("diaphane-render"), "INPUT ...: render a picture without a server (--help)", rest=True)
    command("replay", _replay, "FILE (--link LINK | --scan SCAN --out FOLDER): recorded interaction, played again", rest=True)
    fuzz = command("fuzz", _fuzz, "fuzz the parsers of uploads, volumes, requests and stream messages (libFuzzer with ASan and UBSan)")
    fuzz.add_argument("target", nargs="?", metavar="TARGET", help="precheck, codestream, tar, report, volume, viewer, stream, fields, preset, recording or scene_xml (default: all)")
    fuzz.add_argument("--seconds", type=int, default=60, metavar="N", help="for each target (default 60)")
    fuzz.add_argument("--minimise", action="store_true", help="then keep the fewest files that reach as much, in tests/fuzz/corpus")
    races = command("races", _races, "everything that has threads, under ThreadSanitizer")
    races.add_argument("programs", nargs="*", metavar="PROGRAM", help="test programs (default: all that have threads)")
    bench = command("bench", _bench, "measure; without a name: which measurements there are")
    bench.add_argument("name", nargs="?")
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the results there")
    bench.add_argument("--quick", action="store_true", help="fewer repetitions")
    bench.set_defaults(takes_rest=True)    # a measurement may have options of its own
    bill = command("sbom", _sbom, "[FILE]: what Diaphane is made of, with versions, as CycloneDX JSON")
    bill.add_argument("file", nargs="?", type=Path, metavar="FILE", help="where to write it (default: standard output)")
    made = command("image", _image, "build the container image with buildah, from the programs of this checkout; by root")
    made.add_argument("--out", type=Path, metavar="FILE.tar", help="write it there too, as an OCI archive")
    made.add_argument("--check", action="store_true", help="then look at it: size, no compiler, each program on a read-only root")
    made.add_argument("--base", metavar="IMAGE", help="a Debian 12 to pull, instead of one made by debootstrap")
    made.add_argument("--source", action="store_true", help="build the programs inside, from this checkout's sources")
    made.add_argument("--stage", type=Path, metavar="FOLDER", help="only lay out there what goes in (the Containerfile's first stage)")
    pictures = command("screenshots", _screenshots, "FOLDER: a picture of every page at three sizes, light and dark, to be looked at")
    pictures.add_argument("folder", type=Path)
    pictures.add_argument("--only", default="", metavar="TEXT", help="only what has this in its name (person-scans, nobody-sign-in, viewer-light, ...)")
    pictures.add_argument("--size", choices=("phone", "tablet", "desk"), help="only this size")
    pictures.add_argument("--look", choices=("light", "dark"), help="only this look")
    command("guide", lambda *_: _guide(), "make the pictures of docs/guide.md anew")
    commands.add_parser("help", help="this").set_defaults(run=lambda *_: parser.print_help() or 0)
    return parser


def _port(text: str) -> int:
    number = int(text)
    if not 1024 <= number < 65536:
        raise argparse.ArgumentTypeError("a port from 1024 to 65535 (below, only root may listen, and nothing runs as root)")
    return number


def _data(options: argparse.Namespace) -> Path:
    return options.data or users.default_data_dir()


def _up(options: argparse.Namespace, _: list[str]) -> int:
    from . import build, datadir, install, supervise

    data = _data(options)
    if supervise.running_supervisor(data):
        say(f"Diaphane runs already: {datadir.read_record(data).get('url')}/")
        return 0
    if options.data is None and os.geteuid() == 0:
        say(f"Started by root: the data directory is {data}, where the user '{users.NAME}' can reach it.")
    datadir.check(data)
    install.ensure("up", may_install=not options.no_install)
    build.build_page()      # before the programs: what is wrong with it shows in the first minute
    build.build_programs()
    chosen = supervise.UpOptions(data=data, engine=options.engine, port=options.port)
    return supervise.detach(chosen) if options.detach else supervise.hold(chosen)


def _down(options: argparse.Namespace, _: list[str]) -> int:
    from . import supervise

    return supervise.down(_data(options))


def _status(options: argparse.Namespace, _: list[str]) -> int:
    from . import status

    return status.show(_data(options), options.json)


def _test(options: argparse.Namespace, _: list[str]) -> int:
    from . import testing

    return testing.run(options.kind, may_install=not options.no_install, with_checks=options.checks)


def _check(options: argparse.Namespace, _: list[str]) -> int:
    from . import check

    return check.run(only=options.only or [], fix=options.fix)


def _sample(options: argparse.Namespace, rest: list[str]) -> int:
    from . import tools

    return tools.sample(_data(options), rest)


def _screenshots(options: argparse.Namespace, _: list[str]) -> int:
    from . import screenshots

    return screenshots.run(options.folder.resolve(), options.only, options.size, options.look)


def _guide() -> int:
    from . import screenshots

    return screenshots.guide()


def _sbom(options: argparse.Namespace, _: list[str]) -> int:
    from . import sbom

    return sbom.run(options.file)


def _image(options: argparse.Namespace, _: list[str]) -> int:
    from . import image

    return image.run(options.out, options.check, options.base, options.source, options.stage)


def _admin(options: argparse.Namespace, _: list[str]) -> int:
    from . import admin

    return admin.run(_data(options), options.what, options.email)


def _tool(name: str):
    def run(_: argparse.Namespace, rest: list[str]) -> int:
        from . import tools

        return tools.run(name, rest)

    return run


def _replay(_: argparse.Namespace, rest: list[str]) -> int:
    from . import replay

    return replay.run(rest)


def _races(options: argparse.Namespace, _: list[str]) -> int:
    from . import races

    return races.run(options.programs)


def _fuzz(options: argparse.Namespace, _: list[str]) -> int:
    from . import fuzz

    return fuzz.run(options.target, options.seconds, options.minimise)


def _bench(options: argparse.Namespace, rest: list[str]) -> int:
    from . import bench

    return bench.run(options.name, options.json, options.quick, rest)
