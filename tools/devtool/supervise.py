"""`up` once everything is built: runs the stack until it receives a stop signal."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from . import archive_settings, datadir, gpu, install, layout, ports, prepare, study, users, venv
from .processes import Identity, end, wait_gone
from .console import CliError, say, step, warn
from .plan import POSTGRES_STOP_SECONDS
from .stack import Stack

STOP_SECONDS = 5.0 + POSTGRES_STOP_SECONDS


@dataclass(frozen=True)
class UpOptions:
    data: Path
    engine: str = "auto"
    port: int | None = None
    sample: bool = True
    may_install: bool = False       # the libraries of the analysis of studies, once everything runs
    extra_env: tuple[tuple[str, str], ...] = ()
    archives: str = ""              # settings of the PACS gateway that replace those of an earlier --archive


def running_supervisor(data: Path) -> Identity | None:
    return datadir.recorded(datadir.read_record(data).get("supervisor", {}))


def up(data: Path, may_install: bool, background: bool, port: int | None, engine: str, archives: Sequence[str] = ()) -> int:
    wanted = archive_settings.from_options(archives)
    if running_supervisor(data):
        say(f"Diaphane is already running: {datadir.read_record(data).get('url')}/")
        return 0
    if os.geteuid() == 0 and data == users.default_data_dir():
        say(f"Started as root: using the data directory {data}, which the user '{users.NAME}' can access.")
    datadir.check(data)
    if (why := gpu.absence()) and gpu.is_plugged_in():
        warn(f"This machine has an NVIDIA GPU, but {why}. Diaphane renders on the CPU.")
    prepare.for_up(may_install)
    if wanted or (data / "archives.toml").exists():
        install.ensure_parts([venv.PACS], may_install)
    chosen = UpOptions(data=data, engine=engine, port=port, may_install=may_install, archives=wanted)
    return detach(chosen) if background else hold(chosen)


def hold(options: UpOptions, on_ready=lambda: None) -> int:
    """Starts the stack, prints its address, and keeps it until SIGINT or SIGTERM. Returns the exit code."""
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: stop.set())
    # An existing directory keeps its owner, even if root starts the stack.
    owner = users.owner_of(options.data)
    run_as = owner if owner.uid >= 0 else users.ordinary_user()
    datadir.claim(options.data, run_as)
    if options.archives:
        archive_settings.write(options.data, options.archives, run_as)
    programs = layout.reachable(run_as, layout.copy_folder())
    installer = study.start_installer(programs.study_libraries) if options.may_install else None
    os.chdir("/")           # the ordinary user may have no access to the current directory
    run_as = run_as.become()
    stack = Stack(data=options.data, ports=_ports(options), run_as=run_as, engine=options.engine, layout=programs,
                  extra_env=dict(options.extra_env), on_event=step, stop_requested=stop)
    try:
        stack.start()
        if options.sample and not stop.is_set():
            load_sample(stack)
        if not stop.is_set():
            say(f"Diaphane is at {stack.settings.url}/  (emails are saved in {stack.data / 'mail'})")
            on_ready()
            if installer:
                threading.Thread(target=add_analysis, args=(stack, installer), daemon=True).start()
            if options.sample:
                threading.Thread(target=load_more_samples, args=(stack, stop), daemon=True).start()
        stop.wait()
        step("Stopping")
    finally:
        if installer:
            installer.stdin.close()     # ends it if it has not begun
        stack.stop()
    return 0


def add_analysis(stack: Stack, installer: subprocess.Popen) -> None:
    """Installs the libraries of the analysis while people already use Diaphane, and starts it."""
    _, said = installer.communicate(b"go\n")
    if installer.returncode == 0:
        stack.add_optional()
    else:
        warn(f"cannot install the analysis of studies: {said.decode(errors='replace').strip()}")


def _ports(options: UpOptions) -> dict[str, int]:
    requested = dict(ports.DEFAULTS)
    if options.port is not None:
        requested["edge"] = options.port
    # Ports of a killed supervisor become free once its remaining processes are ended.
    record = datadir.read_record(options.data)
    ours = set(record.get("ports", {}).values()) if datadir.left_running(record) else set()
    given, notes = ports.allot(requested, lambda port: (port in ours or ports.is_free(port)) and ports.claim(port))
    for note in notes:
        say(note)
    return given


def load_sample(stack: Stack, again: bool = False) -> None:
    """Loads the sample scan, once per data directory. A failure does not prevent the start."""
    marker = stack.data / "sample.loaded"
    tool = stack.layout.bin / "diaphane-sample"
    if (marker.exists() and not again) or not tool.exists():
        return
    step("Loading the sample scan (first start only)")
    done = subprocess.run(sample_command(tool, stack.settings.url, stack.data), cwd="/", capture_output=True, text=True,
                          timeout=300, **stack.run_as.popen())
    if done.returncode == 0:
        marker.write_text(done.stdout, encoding="ascii")   # id of its data set
    else:
        warn(f"cannot load the sample scan (exit {done.returncode}): {done.stderr.strip() or done.stdout.strip()}")


#: Samples besides the cranium: the title, the file of Debian's mricron-data, and the modality.
MORE_SAMPLES = (("Head", "ch2.nii.gz", "MR"), ("Brain of a macaque", "inia19-t1-brain.nii.gz", "MR"))
_TEMPLATES = Path("/usr/share/mricron/templates")


def load_more_samples(stack: Stack, stop: threading.Event) -> None:
    """Loads the other samples while people already use the first one, each once per data directory."""
    tool = stack.layout.bin / "diaphane-sample"
    for title, file, modality in MORE_SAMPLES:
        marker, source = stack.data / f"sample-{file.partition('.')[0]}.loaded", _TEMPLATES / file
        if stop.is_set() or marker.exists() or not source.exists() or not tool.exists():
            continue
        command = [*sample_command(tool, stack.settings.url, stack.data), "--file", str(source), "--modality", modality, "--title", title]
        loading = subprocess.Popen(command, cwd="/", stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **stack.run_as.popen())
        while loading.poll() is None and not stop.wait(0.2):
            pass
        loading.terminate()     # does nothing once it has ended
        said = loading.communicate()[0]
        if loading.returncode == 0:
            marker.write_text(said, encoding="ascii")
        elif not stop.is_set():
            warn(f"cannot load the sample “{title}” (exit {loading.returncode}): {said.strip()}")


def sample_command(tool: Path, url: str, data: Path) -> list[str]:
    return [str(tool), "--upload", url, "--token-file", str(data / "secrets" / "sample-token")]


def detach(options: UpOptions) -> int:
    """Runs hold() in the background and passes on its messages. Returns when it is ready."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.close(reading)
            code = _held_in_background(options, writing)
        except CliError as error:
            warn(str(error))
            code = error.code
        except Exception:   # a bug: its traceback must reach the user before the process ends
            traceback.print_exc()
        finally:
            os._exit(code)
    os.close(writing)
    with os.fdopen(reading, encoding="utf-8", errors="replace") as output:
        for line in output:
            print(line, end="", flush=True)
    record = datadir.read_record(options.data)
    if record.get("ready") and record["supervisor"]["pid"] == child:
        return 0
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) or 1


def _held_in_background(options: UpOptions, output: int) -> int:
    os.setsid()
    nothing = os.open(os.devnull, os.O_RDONLY)
    for source, target in ((nothing, 0), (output, 1), (output, 2)):
        os.dup2(source, target)
    os.close(nothing)
    os.close(output)

    def on_ready() -> None:
        log = os.open(options.data / "logs" / "supervisor.log", os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        os.dup2(log, 1)
        os.dup2(log, 2)
        os.close(log)

    return hold(options, on_ready)


def down(data: Path) -> int:
    """Stops what runs on a data directory through its supervisor, or directly if that is dead."""
    users.owner_of(data).become()   # so that root ends only processes of this user
    supervisor = running_supervisor(data)
    programs = datadir.left_running(datadir.read_record(data))
    if supervisor is None and not programs:
        say(f"Diaphane is not running on {data}")
        return 0
    if supervisor is not None:
        supervisor.send(signal.SIGTERM)
        if wait_gone([supervisor], STOP_SECONDS):
            supervisor.send(signal.SIGKILL)
    for _, leader in reversed(programs):
        end(leader, seconds=1.0)
    if left := [name for name, leader in programs if leader.alive() or leader.group()]:
        warn(f"could not stop: {', '.join(left)}")
        return 1
    say("Stopped")
    return 0
