"""The chart with a test's values."""

from __future__ import annotations

import json
from pathlib import Path

import yaml

from devtool import paths

CHART = paths.REPO / "helm" / "diaphane"
SECRET = {"postgres": "postgresql://diaphane:x@postgres:5432/diaphane", "mail": "smtp://mail:25", "factor-key": "0" * 64, "postgres-password": "x"}
BASE = {"publicUrl": "https://scans.example.org", "existingSecret": "diaphane", "redis": {"address": "redis.stores:6379"},
        "innerTls": {"plain": True}}
INNER_TLS = {"redis": {"tls": True}, "innerTls": {"plain": False, "secretName": "inner"}}
#: Each choice adds or removes templates, or replaces a default.
CHOICES = {
    "base": {},
    "trial": {"trial": {"enabled": True}, "redis": {"address": ""}},
    "everything": {
        "image": {"repository": "registry.example.org/x/diaphane", "digest": "sha256:" + "a" * 64, "pullSecrets": ["pull"]},
        "api": {"replicas": 3, "extraEnv": {"DIAPHANE_SAMPLE_TOKEN": "/secrets/token"}, "nodeSelector": {"pool": "web"}, "tolerations": [{"operator": "Exists"}]},
        "edge": {"trustedProxies": ["10.0.0.0/8"]}, "legal": {"configMap": "legal"},
        "redis": {"tls": True}, "innerTls": {"plain": True, "secretName": "inner"},
        "ingest": {"replicas": 2, "antivirus": {"address": "clamd.security:3310"}, "nodeSelector": {"pool": "ingest"}, "tolerations": [{"key": "ingest", "operator": "Exists"}]},
        "operator": {"watchAllPods": True},
        "fleet": {"replicas": 2, "maxReplicas": 8, "scaleToZeroAfter": "30m", "nodeSelector": {"gpu": "yes"}, "strategy": "Packed",
                  "volumeCopies": {"sizeMb": 2048, "storageClassName": "local"}},
        "ingress": {"enabled": True, "className": "nginx", "annotations": {"a": "b"}, "tlsSecret": "tls"},
        "networkPolicy": {"ingressFrom": [{"namespaceSelector": {"matchLabels": {"a": "b"}}}], "postgresTo": [{"ipBlock": {"cidr": "10.1.0.0/16"}}],
                          "redisTo": [{"ipBlock": {"cidr": "10.1.0.0/16"}}], "mailTo": [{"ipBlock": {"cidr": "10.2.0.0/16"}}],
                          "apiServerTo": [{"ipBlock": {"cidr": "10.3.0.0/16"}}], "monitoringFrom": [{"podSelector": {}}]},
        "monitoring": {"podMonitor": {"enabled": True, "labels": {"x": "y"}}, "rules": {"enabled": True}, "dashboard": {"enabled": True}}},
    "archives": {"pacs": {"enabled": True, "secret": "archives", "receiver": {"enabled": True, "from": [{"ipBlock": {"cidr": "10.4.0.0/16"}}]},
                          "archivesTo": [{"ipBlock": {"cidr": "10.4.0.0/16"}}], "archivePorts": [443, 104], "spool": {"sizeMb": 1000, "storageClassName": "fast"},
                          "nodeSelector": {"pool": "web"}, "tolerations": [{"operator": "Exists"}]}},
    "backups": {"backup": {"enabled": True, "secret": "backups", "repository": "s3:https://s3.example.org/scans", "credentialsSecret": "s3",
                           "repositoryTo": [{"ipBlock": {"cidr": "10.5.0.0/16"}}], "nodeSelector": {"pool": "web"}, "tolerations": [{"operator": "Exists"}]}},
    "little": {"operator": {"enabled": False}, "fleet": {"enabled": False, "volumeCopies": {"sizeMb": 0}}, "networkPolicy": {"enabled": False}, "ingest": {"replicas": 0},
               "podDisruptionBudgets": {"enabled": False}, "studies": {"analysis": {"enabled": False}}, "migrate": {"enabled": False}, "api": {"replicas": 1},
               "storage": {"volumes": {"existingClaim": "a"}, "uploads": {"existingClaim": "b"}, "cache": {"existingClaim": "c"}}},
}


def merged(one: dict, other: dict) -> dict:
    out = dict(one)
    for key, value in other.items():
        out[key] = merged(out[key], value) if isinstance(value, dict) and isinstance(out.get(key), dict) else value
    return out


def values_file(folder: Path, *parts: dict) -> str:
    values: dict = {}
    for part in (BASE, *parts):
        values = merged(values, part)
    path = folder / "values.json"
    path.write_text(json.dumps(values), encoding="utf-8")
    return str(path)


def stored(namespace: str, claim: str, place: str = "/nowhere") -> dict:
    """Returns a volume for a claim, as a storage class would create it. The test cluster has none."""
    return {"apiVersion": "v1", "kind": "PersistentVolume", "metadata": {"name": f"{namespace}-{claim}"}, "spec": {
        "capacity": {"storage": "1Ti"}, "accessModes": ["ReadWriteMany", "ReadWriteOnce"], "hostPath": {"path": place}, "storageClassName": "",
        "claimRef": {"namespace": namespace, "name": claim}}}


def rendered(plane, folder: Path, *parts: dict, namespace: str = "default", hooks: bool = True) -> list[dict]:
    said = plane.helm("template", "it", str(CHART), "-n", namespace, "-f", values_file(folder, *parts), "--include-crds=false",
                      *([] if hooks else ["--no-hooks"]))
    return [one for one in yaml.safe_load_all(said.out) if one]


def pod_specs(objects: list[dict]) -> list[tuple[str, dict]]:
    """Returns the pod specs of all objects that create pods."""
    templates = [(one, one["spec"]["jobTemplate"] if one["kind"] == "CronJob" else one)
                 for one in objects if one["kind"] in ("Deployment", "StatefulSet", "Job", "CronJob", "RenderFleet")]
    return [(f"{one['kind']}/{one['metadata']['name']}", made["spec"]["template"]["spec"]) for one, made in templates]
