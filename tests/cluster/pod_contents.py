"""What a container of a pod finds, as plain data: its environment, its arguments, the files of its volumes. Nothing is started here.

All pods of a node share one loopback here, so a port that a pod names is another number outside: `Places.ports` says which, and each
place where the pod's own objects say that number (settings, probes, the edge's configuration) is read through it."""

from __future__ import annotations

import base64
import re
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Places:
    """The location of one pod on this machine."""

    address: str
    ports: dict[int, int] = field(default_factory=dict)


def ports_named(spec: dict) -> list[int]:
    """Returns every port on which the pod's containers listen, according to its spec."""
    named = {port["containerPort"] for one in spec["containers"] for port in one.get("ports", [])}
    for one in spec["containers"]:
        named |= {int(env["value"]) for env in one.get("env", []) if env["name"].endswith("_PORT") and env.get("value", "").isdigit()}
    return sorted(named)


def mapped(text: str, places: Places) -> str:
    """Replaces this pod's ports by the ones on this machine, and `0.0.0.0` by its address, because other addresses belong to
    other pods."""
    if text == "0.0.0.0":
        return places.address
    for inside, outside in places.ports.items():
        text = re.sub(rf"(?<![\w.]){inside}(?![\w.])", str(outside), text)
    return text


def field_of(pod: dict, path: str, places: Places) -> str:
    """Returns a field of the downward API."""
    if path == "status.podIP":
        return places.address
    value: object = pod
    for word in re.findall(r"[^.\[\]']+(?:/[^\[\]']+)?", path):
        value = value.get(word, "") if isinstance(value, dict) else ""
    return str(value)


def environment(pod: dict, container: dict, places: Places, secret_of, config_of) -> dict[str, str]:
    """Returns the environment in the order of the spec. $(NAME) refers to earlier variables. `secret_of(name)` and
    `config_of(name)` return values as bytes by key."""
    env: dict[str, str] = {}
    for one in container.get("env", []):
        source = one.get("valueFrom", {})
        if "fieldRef" in source:
            value = field_of(pod, source["fieldRef"]["fieldPath"], places)
        elif "secretKeyRef" in source:
            value = secret_of(source["secretKeyRef"]["name"])[source["secretKeyRef"]["key"]].decode()
        elif "configMapKeyRef" in source:
            value = config_of(source["configMapKeyRef"]["name"])[source["configMapKeyRef"]["key"]].decode()
        else:
            value = mapped(re.sub(r"\$\(([A-Za-z_]\w*)\)", lambda name: env.get(name[1], name[0]), one.get("value", "")), places)
        env[one["name"]] = value
    return env


def data_of(answer: dict) -> dict[str, bytes]:
    """Returns the values of a secret or config map."""
    binary = answer.get("binaryData", {}) if answer.get("kind") == "ConfigMap" else answer.get("data", {})
    plain = answer.get("data", {}) if answer.get("kind") == "ConfigMap" else {}
    return {**{key: text.encode() for key, text in (plain or {}).items()}, **{key: base64.b64decode(text) for key, text in (binary or {}).items()}}


def chosen(data: dict[str, bytes], items: list[dict] | None) -> dict[str, bytes]:
    """Returns files by path: all keys, or those in `items`."""
    return data if not items else {one["path"]: data[one["key"]] for one in items}


def probe_port(container: dict, probe: dict, places: Places) -> int:
    said = (probe.get("httpGet") or probe.get("tcpSocket"))["port"]
    inside = next((one["containerPort"] for one in container.get("ports", []) if one.get("name") == said), said)
    return places.ports.get(int(inside), int(inside))


def phase_of(policy: str, exits: list[int | None], started: list[bool]) -> str:
    """`exits`: the last exit status of each container, or None while it runs."""
    if policy != "Always" and all(code is not None for code in exits):
        if all(code == 0 for code in exits):
            return "Succeeded"
        if policy == "Never":
            return "Failed"
    return "Running" if all(started) else "Pending"
