"""Reports what runs on a data directory, and whether each program is ready."""

from __future__ import annotations

import json
from pathlib import Path

from . import datadir, plan, ready
from .layout import of_checkout
from .plan import Settings
from .console import say

NAMES = ("edge", "api", "gateway", "ingestd", "renderd", "postgres", "redis")


def status(data: Path) -> dict:
    record = datadir.read_record(data)
    supervisor = datadir.recorded(record.get("supervisor", {}))
    entries = {entry.get("name"): entry for entry in record.get("programs", [])}
    probes = {}
    if record.get("ports"):
        settings = Settings(data=data, ports=record["ports"], layout=of_checkout(), postgres_password="",
                            sockets=Path(record["sockets"]) if record.get("sockets") else None)
        probes = {program.name: program.ready for program in plan.programs(settings)}
    programs = []
    for name in NAMES:
        entry = entries.get(name, {})
        alive = datadir.recorded(entry) is not None
        programs.append({
            "name": name, "running": alive, "pid": entry.get("pid") if alive else None, "port": entry.get("port"),
            "ready": bool(alive and name in probes and ready.is_ready(probes[name])),
            "restarts": entry.get("restarts", 0)})
    engine = _engine(entries.get("renderd", {}))
    return {"running": supervisor is not None, "url": record.get("url") if supervisor else None, "data": str(data),
            "mail": record.get("mail"), "engine": engine.get("engine"), "device": engine.get("device"),
            "programs": programs}


def _engine(entry: dict) -> dict:
    """Returns engine and device as the worker reports them."""
    return ready.readyz(entry["admin_port"]) if datadir.recorded(entry) and entry.get("admin_port") else {}


def show(data: Path, as_json: bool) -> int:
    """Prints the status. Returns 0 if everything is ready, 3 if nothing runs (as in LSB), otherwise
    1."""
    now = status(data)
    all_ready = all(program["ready"] for program in now["programs"])
    if as_json:
        say(json.dumps(now, indent=1))
    elif not any(program["running"] for program in now["programs"]):
        say(f"Diaphane is not running on {data}")
    else:
        say(now["url"] or "The supervisor has died. Run ./diaphane down to stop its programs, or ./diaphane up to restart.")
        for program in now["programs"]:
            state = "ready" if program["ready"] else "not ready" if program["running"] else "not running"
            restarts = f", restarts: {program['restarts']}" if program["restarts"] else ""
            say(f"  {program['name']:<9} {program['port'] or '-':>6}  {state}{restarts}")
        say(f"  engine: {now['engine'] or 'unknown'}, device: {now['device'] or 'unknown'}")
    if not any(program["running"] for program in now["programs"]):
        return 3
    return 0 if all_ready else 1
