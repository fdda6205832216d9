"""The chart: rendered for every combination of values, accepted by the API server, installed, upgraded and rolled back."""

from __future__ import annotations

import itertools
import json
import shutil
import subprocess

import pytest
import yaml
from certificates import issue, with_roles
from chart_helpers import CHART, CHOICES, INNER_TLS, SECRET, pod_specs, rendered, stored, values_file
from conftest import wait_for

pytestmark = pytest.mark.chosen


@pytest.fixture(scope="session")
def monitoring(plane):
    """Installs the resources of Prometheus' operator as shipped."""
    for kind in ("podmonitors", "prometheusrules"):
        plane.kubectl("apply", "--server-side", "-f", str(plane.bin / f"{kind}.yaml"))
    plane.kubectl("wait", "--for=condition=Established", "crd/podmonitors.monitoring.coreos.com", "crd/prometheusrules.monitoring.coreos.com")
    return plane


def test_helm_lint_passes(plane, tmp_path):
    said = plane.helm("lint", str(CHART), "--strict", "-f", values_file(tmp_path))
    assert "1 chart(s) linted, 0 chart(s) failed" in said.text and "WARNING" not in said.text, said.text


@pytest.mark.parametrize("values, words", [
    ({"publicUrl": "scans.example.org"}, "publicUrl"),
    ({"publicUrl": "https://scans.example.org/"}, "publicUrl"),
    ({"existingSecret": ""}, "existingSecret"),
    ({"redis": {"address": "redis"}}, "redis"),
    ({"redis": {"address": ""}}, "redis.address (host:port) is missing"),
    ({"trial": {"enabled": True}}, "not both"),
    ({"innerTls": {"plain": False}}, "or innerTls.plain=true if the network"),
    ({"innerTls": {"plain": False, "secretName": "inner"}}, "redis.tls=false would connect to Redis without TLS"),
    ({**INNER_TLS, "ingest": {"antivirus": {"address": "clamd:3310"}}}, "clamd does not support TLS"),
    ({"redis": {"tls": True}}, "redis.tls requires innerTls.secretName"),
    ({"innerTls": {"issuer": {"name": "x"}, "roles": False}}, "innerTls.issuer.name requires innerTls.roles=true"),
    ({"trial": {"enabled": True}, "redis": {"address": "", "tls": True}, "innerTls": {"secretName": "inner"}}, "redis.tls and trial.enabled"),
    ({"postgres": {"password": "x"}}, "postgres"),
    ({"image": {"digest": "latest"}}, "digest"),
    ({"api": {"replicas": 0}}, "replicas"),
    ({"api": {"extraEnv": {"PATH": "x"}}}, "extraEnv"),
    ({"fleet": {"strategy": "Random"}}, "strategy"),
    ({"fleet": {"textureMemoryMb": 63}}, "textureMemoryMb"),
    ({"visitorShare": 101}, "visitorShare"),
    ({"fleet": {"drainTimeout": 300}}, "drainTimeout"),
    ({"fleet": {"minReplicas": 1, "scaleToZeroAfter": "5m"}}, "scaleToZeroAfter requires"),
    ({"fleet": {"volumeCopies": {"hostPath": "/a", "storageClassName": "b"}}}, "not both"),
    ({"fleet": {"volumeCopies": {"hostPath": "../a"}}}, "hostPath"),
    ({"operator": {"enabled": False}}, "fleet.enabled requires operator.enabled"),
    ({"networkPolicy": {"postgresTo": [{}]}}, "postgresTo"),
    ({"publicUrl": "http://x", "ingress": {"enabled": True, "tlsSecret": "t"}}, "ingress.tlsSecret"),
    ({"mailFrom": "a@b\nBcc: c@d"}, "mailFrom"),
    ({"backup": {"enabled": True}}, "backup.enabled requires"),
    ({"backup": {"enabled": True, "secret": "a", "repository": "/backups"}}, "requires backup.claim"),
    ({"backup": {"repository": "/a b"}}, "repository"),
    ({"backup": {"schedule": "hourly"}}, "schedule"),
    ({"pacs": {"enabled": True}}, "pacs.enabled requires pacs.secret"),
    ({"pacs": {"spool": {"sizeMb": 1}}}, "sizeMb"),
], ids=str)
def test_invalid_values_are_refused_by_name(plane, tmp_path, values, words):
    said = plane.helm("template", "it", str(CHART), "-f", values_file(tmp_path, values), check=False)
    assert said.code != 0 and words in said.text, said.text


@pytest.mark.parametrize("choice", CHOICES)
def test_the_api_server_accepts_every_variant_in_a_restricted_namespace(monitoring, namespace, tmp_path, choice):
    objects = rendered(monitoring, tmp_path, CHOICES[choice], namespace=namespace)
    said = monitoring.kubectl("create", "-n", namespace, "--dry-run=server", "--validate=strict", "-f", "-", given=objects)
    assert "would violate PodSecurity" not in said.text, said.text


def test_every_combination_of_optional_parts_is_accepted(monitoring, namespace, tmp_path):
    """Renders each combination of optional parts."""
    switches = {
        "trial": (CHOICES["trial"], {}), "policy": ({}, {"networkPolicy": {"enabled": False}}), "ingress": (CHOICES["everything"]["ingress"], {}),
        "monitoring": ({"monitoring": CHOICES["everything"]["monitoring"]}, {}), "operator": ({}, {"operator": {"enabled": False}, "fleet": {"enabled": False}}),
        "migrate": ({}, {"migrate": {"enabled": False}}), "budgets": ({}, {"podDisruptionBudgets": {"enabled": False}}),
    }
    switches["ingress"] = ({"ingress": CHOICES["everything"]["ingress"]}, {})
    seen = set()
    everything: list[dict] = []
    for pick in itertools.product((0, 1), repeat=len(switches)):
        parts = [pair[index] for pair, index in zip(switches.values(), pick)]
        for one in rendered(monitoring, tmp_path, *parts, namespace=namespace):
            text = json.dumps(one, sort_keys=True)
            if text not in seen:     # each distinct object of all combinations once
                seen.add(text)
                everything.append(one)
    said = monitoring.kubectl("create", "-n", namespace, "--dry-run=server", "--validate=strict", "-f", "-", given=everything, check=False)
    assert said.code == 0 and "would violate" not in said.text, said.err
    assert said.out.count("created (server dry run)") == len(everything)
    assert len(everything) > 30


@pytest.mark.parametrize("choice", CHOICES)
def test_pods_are_hardened_and_have_limits_and_probes(plane, tmp_path, choice):
    for name, spec in pod_specs(rendered(plane, tmp_path, CHOICES[choice])):
        assert spec["securityContext"]["runAsNonRoot"] and spec["securityContext"]["runAsUser"] > 0, name
        assert spec["securityContext"]["seccompProfile"]["type"] == "RuntimeDefault", name
        assert spec["automountServiceAccountToken"] is name.endswith(("-operator", "-retire")), name
        assert spec["enableServiceLinks"] is False, name
        for one in spec["containers"]:
            assert one["securityContext"] == {"allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True, "capabilities": {"drop": ["ALL"]}}, name
            assert one["resources"]["limits"]["memory"] and one["resources"]["requests"]["cpu"], name
            for probe in ("livenessProbe", "startupProbe"):
                assert one.get(probe, {}).get("httpGet", {"path": "/healthz"})["path"] == "/healthz", f"{name}: {probe} asks what it depends on"
            inside = [env for env in one.get("env", []) if any(word in env.get("value", "") for word in ("://diaphane", "smtp:"))]
            assert not inside, f"{name}: a secret by its value: {inside}"


@pytest.mark.parametrize("given, wanted", [
    ({}, {"emptyDir": {"sizeLimit": "10752Mi"}}),
    ({"sizeMb": 0}, None),
    ({"hostPath": "/var/lib/diaphane-copies"}, {"hostPath": {"path": "/var/lib/diaphane-copies", "type": "Directory"}}),
    ({"sizeMb": 512, "storageClassName": "local"}, {"ephemeral": {"volumeClaimTemplate": {"spec": {
        "accessModes": ["ReadWriteOnce"], "storageClassName": "local", "resources": {"requests": {"storage": "1024Mi"}}}}}}),
], ids=str)
def test_volume_copies_are_mounted_where_configured(plane, tmp_path, given, wanted):
    spec = next(one for one in rendered(plane, tmp_path, {"fleet": {"volumeCopies": given}}) if one["kind"] == "RenderFleet")["spec"]["template"]["spec"]
    volume = next((one for one in spec["volumes"] if one["name"] == "copies"), None)
    assert volume == (wanted and {"name": "copies", **wanted})
    env = {one["name"]: one.get("value") for one in spec["containers"][0]["env"]}
    assert env.get("DIAPHANE_VOLUME_COPIES_DIR") == (wanted and "/copies/volumes")
    assert any(one["mountPath"] == "/copies" for one in spec["containers"][0]["volumeMounts"]) is (wanted is not None)


def test_configured_limits_reach_the_programs(plane, tmp_path):
    specs = dict(pod_specs(rendered(plane, tmp_path, {"visitorShare": 10, "fleet": {"textureMemoryMb": 256}, "legal": {"consentVersion": "2027-01-01"}})))
    environment = {name: {one["name"]: one.get("value") for one in specs[pod]["containers"][0]["env"]}
                   for name, pod in {"api": "Deployment/it-diaphane-api", "renderd": "RenderFleet/it-diaphane"}.items()}
    assert environment["api"]["DIAPHANE_VISITOR_SHARE"] == environment["renderd"]["DIAPHANE_VISITOR_SHARE"] == "10"
    assert environment["renderd"]["DIAPHANE_TEXTURE_MEMORY_MB"] == "256"
    assert environment["api"]["DIAPHANE_CONSENT_VERSION"] == "2027-01-01"


def test_custom_texts_are_mounted_where_the_edge_reads_them(plane, tmp_path):
    for given, wanted in (({}, []), ({"legal": {"configMap": "our-texts"}}, [{"name": "legal", "mountPath": "/etc/legal", "readOnly": True}])):
        objects = rendered(plane, tmp_path, given)
        spec = dict(pod_specs(objects))["Deployment/it-diaphane-api"]
        edge = next(one for one in spec["containers"] if one["name"] == "edge")
        assert [one for one in edge["volumeMounts"] if one["name"] == "legal"] == wanted
        assert [one["configMap"]["name"] for one in spec["volumes"] if one["name"] == "legal"] == (["our-texts"] if given else [])
    assert any("root /etc/legal;" in one["data"].get("nginx.conf", "") for one in objects if one["kind"] == "ConfigMap")


TALKERS = {"api": "Deployment/it-diaphane-api", "gateway": "Deployment/it-diaphane-api", "renderd": "RenderFleet/it-diaphane", "operator": "Deployment/it-diaphane-operator"}


@pytest.mark.parametrize("choice", ["tls", "plain", "nothing"])
@pytest.mark.parametrize("program", TALKERS)
def test_the_programs_accept_the_tls_settings_of_the_pods(plane, tmp_path, all_stacks, program, choice):
    """The program reads the pod's settings and complains only about the one that is removed, so that it exits."""
    issue(tmp_path, ca="ca.crt", certificate="tls.crt", key="tls.key", names=with_roles(program, names="DNS:renderd.diaphane"))
    objects = pod_specs(rendered(plane, tmp_path, INNER_TLS if choice == "tls" else {}))
    assert not [name for name, spec in objects if "inner-tls" in json.dumps(spec) and name not in TALKERS.values()]
    spec = dict(objects)[TALKERS[program]]
    container = next((one for one in spec["containers"] if one["name"] == program), spec["containers"][0])
    environment = {one["name"]: one["value"] for one in container["env"] if one["name"] not in ("DIAPHANE_ADMIN_PORT", "DIAPHANE_INNER_PLAIN" * (choice == "nothing"))
                   and "value" in one}
    if choice == "tls":
        assert {"name": f"inner-tls-{program}", "mountPath": "/inner-tls", "readOnly": True} in container["volumeMounts"]
        assert [one["mountPath"] for one in container["volumeMounts"]].count("/inner-tls") == 1
        secret = next(one for one in spec["volumes"] if one["name"] == f"inner-tls-{program}")["secret"]
        assert secret["secretName"] == f"inner-{program}" and secret["defaultMode"] & 0o007 == 0
        paths = {name: value for name, value in environment.items() if value.startswith("/inner-tls/")}
        assert sorted(paths.values()) == sorted("/inner-tls/" + one["path"] for one in secret["items"])
        for name, value in paths.items():
            environment[name] = str(tmp_path / value.removeprefix("/inner-tls/"))
        assert environment["DIAPHANE_REDIS"] == "rediss://redis.stores:6379" and "DIAPHANE_INNER_PLAIN" not in environment
    said = subprocess.run([str(all_stacks.layout().bin / f"diaphane-{program}")], env=environment, capture_output=True, text=True, timeout=60)
    assert said.returncode == 78 and "admin-port" in said.stderr, said.stderr
    complaints = [line for line in said.stderr.splitlines() if "TLS" in line or "tls" in line]
    assert bool(complaints) is (choice == "nothing"), said.stderr


def test_cert_manager_issues_each_program_a_certificate_with_its_role(plane, tmp_path):
    objects = rendered(plane, tmp_path, {"redis": {"tls": True}, "innerTls": {"plain": False, "issuer": {"name": "diaphane"}}})
    issued = {one["spec"]["secretName"]: one["spec"] for one in objects if one["kind"] == "Certificate"}
    used = {volume["secret"]["secretName"]: pod for pod, spec in pod_specs(objects) for volume in spec.get("volumes", []) if volume["name"].startswith("inner-tls-")}
    assert used == {f"it-diaphane-inner-{program}": pod for program, pod in TALKERS.items()} and set(used) == set(issued)
    for secret, spec in issued.items():
        program = secret.rpartition("-")[2]
        assert spec["uris"] == [f"spiffe://diaphane/{program}"]
        assert spec["issuerRef"] == {"name": "diaphane", "kind": "Issuer", "group": "cert-manager.io"}
        # No other program can be taken for renderd.
        assert (spec.get("dnsNames"), "server auth" in spec["usages"]) == ((["renderd.diaphane"], True) if program == "renderd" else (None, False))


def test_a_shared_certificate_disables_the_role_check(plane, tmp_path):
    objects = pod_specs(rendered(plane, tmp_path, INNER_TLS, {"innerTls": {"roles": False}}))
    names = {volume["secret"]["secretName"] for _, spec in objects for volume in spec.get("volumes", []) if volume["name"].startswith("inner-tls-")}
    assert names == {"inner"}
    told = [name for name, spec in objects for container in spec["containers"]
            if {"name": "DIAPHANE_INNER_TLS_ROLES", "value": "0"} in container.get("env", [])]
    assert sorted(told) == sorted(TALKERS.values())


def test_an_image_digest_overrides_the_tag(plane, tmp_path):
    images = {one["image"] for _, spec in pod_specs(rendered(plane, tmp_path, CHOICES["everything"])) for one in spec["containers"]}
    assert images == {"registry.example.org/x/diaphane@sha256:" + "a" * 64}


def test_a_new_chart_version_alone_restarts_no_pod(plane, tmp_path):
    copy = tmp_path / "chart"
    shutil.copytree(CHART, copy)
    before = pod_specs_and_labels(rendered(plane, tmp_path, CHOICES["everything"]))
    text = (copy / "Chart.yaml").read_text(encoding="utf-8")
    (copy / "Chart.yaml").write_text(text.replace("version: 0.1.0", "version: 9.9.9").replace('"0.1.0"', '"9.9.9"'), encoding="utf-8")
    said = plane.helm("template", "it", str(copy), "-f", values_file(tmp_path, CHOICES["everything"]))
    objects = [one for one in yaml.safe_load_all(said.out) if one]
    assert "9.9.9" in said.out and pod_specs_and_labels(objects) == before


def pod_specs_and_labels(objects: list[dict]) -> list[tuple]:
    return [(one["kind"], one["spec"]["template"]) for one in objects if one["kind"] in ("Deployment", "StatefulSet", "RenderFleet")]


def test_unused_objects_are_not_created(plane, tmp_path):
    kinds = sorted({one["kind"] for one in rendered(plane, tmp_path, CHOICES["little"])})
    assert kinds == ["ConfigMap", "Deployment", "Job", "Service"]     # the job is the helm test
    assert [one["metadata"]["name"] for one in rendered(plane, tmp_path, CHOICES["little"]) if one["kind"] == "Deployment"] == ["it-diaphane-api"]


def test_network_policies_allow_only_needed_connections(plane, tmp_path):
    policies = {one["metadata"]["name"].removeprefix("it-diaphane-"): one["spec"]
                for one in rendered(plane, tmp_path, {"monitoring": {}}) if one["kind"] == "NetworkPolicy"}

    def out(name):
        return sorted(port["port"] for rule in policies[name]["egress"] for port in rule["ports"])

    assert set(policies["nothing"]) == {"podSelector", "policyTypes"}
    looked_at = rendered(plane, tmp_path, {"ingest": {"antivirus": {"address": "clamd.security:3311"}}})
    talks = next(one["spec"]["egress"] for one in looked_at if one["kind"] == "NetworkPolicy" and one["metadata"]["name"].endswith("-ingest"))
    assert sorted(port["port"] for rule in talks for port in rule["ports"]) == [53, 53, 3311, 5432]
    assert out("ingest") == [53, 53, 5432] and out("migrate") == [53, 53, 5432] and out("renderd") == [53, 53, 6379]
    assert out("retire") == [53, 53, 443, 6443]
    assert out("operator") == [53, 53, 443, 6379, 6443] and out("api") == [25, 53, 53, 465, 587, 5432, 6379, 8085, 8095]
    archives = {one["metadata"]["name"].removeprefix("it-diaphane-"): one["spec"]
                for one in rendered(plane, tmp_path, CHOICES["archives"]) if one["kind"] == "NetworkPolicy"}
    assert {"ports": [{"port": 443}, {"port": 104}], "to": [{"ipBlock": {"cidr": "10.4.0.0/16"}}]} in archives["pacs"]["egress"]
    assert {"ports": [{"port": "dicom"}], "from": [{"ipBlock": {"cidr": "10.4.0.0/16"}}]} in archives["pacs"]["ingress"]
    assert any(port["port"] == 8096 for rule in archives["api"]["egress"] for port in rule["ports"])
    saved = {one["metadata"]["name"].removeprefix("it-diaphane-"): one["spec"]
             for one in rendered(plane, tmp_path, CHOICES["backups"]) if one["kind"] == "NetworkPolicy"}
    assert {"ports": [{"port": 443}], "to": [{"ipBlock": {"cidr": "10.5.0.0/16"}}]} in saved["backup"]["egress"]
    grpc = [rule for rule in policies["renderd"]["ingress"] if rule["ports"] == [{"port": "grpc"}]]
    assert grpc[0]["from"][0]["podSelector"]["matchLabels"]["app.kubernetes.io/component"] == "api"
    pods = {spec_labels(one)["app.kubernetes.io/component"] for one in rendered(plane, tmp_path) if one["kind"] in ("Deployment", "Job", "RenderFleet")}
    assert pods <= set(policies), "a pod that no policy is about"


def spec_labels(one: dict) -> dict:
    return one["spec"]["template"]["metadata"]["labels"]


def test_the_edge_configuration_is_valid_and_complete(plane, tmp_path):
    """nginx accepts it, every placeholder is replaced, and a trusted proxy determines the client's address."""
    for choice in ("base", "everything", "archives"):
        config = next(one for one in rendered(plane, tmp_path, CHOICES[choice]) if one["kind"] == "ConfigMap" and "nginx.conf" in one["data"])
        text = config["data"]["nginx.conf"]
        assert "@" not in "".join(line for line in text.splitlines() if "@" in line and line.split("@")[1].isupper())
        assert ("set_real_ip_from 10.0.0.0/8;" in text) is (choice == "everything")
        assert ('set $archives "on";' in text, 'set $archives "off";' in text) == (choice == "archives", choice != "archives")
        # nginx looks names up when it reads its configuration, and here nobody knows this one.
        text = text.replace("server it-diaphane-pacs:8096", "server 127.0.0.1:8096")
        for inside, outside in (("/run/edge", tmp_path), ("/opt/diaphane/page", tmp_path), ("/data/cache", tmp_path), ("/dev/stdout", tmp_path / "log")):
            text = text.replace(inside, str(outside))
        (tmp_path / "nginx.conf").write_text(text, encoding="utf-8")
        done = subprocess.run(["/usr/sbin/nginx", "-t", "-e", "stderr", "-p", str(tmp_path), "-c", str(tmp_path / "nginx.conf")], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def test_the_gateway_to_archives_keeps_received_series_in_a_volume_of_its_own(plane, tmp_path):
    objects = rendered(plane, tmp_path, CHOICES["archives"])
    spec = dict(pod_specs(objects))["Deployment/it-diaphane-pacs"]
    environment = {one["name"]: one["value"] for one in spec["containers"][0]["env"]}
    assert (environment["DIAPHANE_SPOOL_DIR"], environment["DIAPHANE_SPOOL_MB"]) == ("/spool/series", "900")
    [claim] = [one for one in objects if one["kind"] == "PersistentVolumeClaim" and one["metadata"]["name"] == "it-diaphane-pacs"]
    assert (claim["spec"]["storageClassName"], claim["spec"]["resources"]["requests"]["storage"]) == ("fast", "1000Mi")
    assert {"name": "spool", "persistentVolumeClaim": {"claimName": "it-diaphane-pacs"}} in spec["volumes"]
    own = rendered(plane, tmp_path, CHOICES["archives"], {"pacs": {"spool": {"existingClaim": "mine"}}})
    assert {"name": "spool", "persistentVolumeClaim": {"claimName": "mine"}} in dict(pod_specs(own))["Deployment/it-diaphane-pacs"]["volumes"]
    assert not [one for one in own if one["kind"] == "PersistentVolumeClaim" and one["metadata"]["name"] == "it-diaphane-pacs"]


def test_backups_read_the_scans_and_only_a_restore_writes_them(plane, tmp_path):
    jobs = {one["metadata"]["name"]: one["spec"] for one in rendered(plane, tmp_path, CHOICES["backups"]) if one["kind"] == "CronJob"}
    assert {name: job["suspend"] for name, job in jobs.items()} == {"it-diaphane-backup": False, "it-diaphane-restore": True}
    for name, job in jobs.items():
        pod = job["jobTemplate"]["spec"]["template"]["spec"]
        [container] = pod["containers"] if name.endswith("backup") else pod["initContainers"]
        mounts = {one["mountPath"]: one.get("readOnly", False) for one in container["volumeMounts"]}
        assert mounts["/data/volumes"] is mounts["/data/uploads"] is name.endswith("backup") and mounts["/secrets"]
        assert container["envFrom"] == [{"secretRef": {"name": "s3"}}]
    kept = rendered(plane, tmp_path, CHOICES["backups"], {"backup": {"repository": "/backups", "claim": "mine"}})
    pod = next(one for one in kept if one["metadata"]["name"] == "it-diaphane-backup" and one["kind"] == "CronJob")["spec"]["jobTemplate"]["spec"]["template"]["spec"]
    assert {"name": "repository", "persistentVolumeClaim": {"claimName": "mine"}} in pod["volumes"]


def test_promtool_accepts_the_rules_and_their_tests_pass(plane, tmp_path):
    rules = CHART / "files" / "rules.yaml"
    checked = subprocess.run([str(plane.bin / "promtool"), "check", "rules", str(rules)], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    cases = yaml.safe_load((CHART.parents[1] / "tests" / "cluster" / "rules_test.yaml").read_text(encoding="utf-8"))
    fired = {rule["alertname"] for case in cases["tests"] for rule in case["alert_rule_test"] if rule.get("exp_alerts")}
    assert fired == {rule["alert"] for group in yaml.safe_load(rules.read_text(encoding="utf-8"))["groups"] for rule in group["rules"]}
    cases["rule_files"] = [str(rules)]
    (tmp_path / "cases.yaml").write_text(yaml.safe_dump(cases), encoding="utf-8")
    done = subprocess.run([str(plane.bin / "promtool"), "test", "rules", str(tmp_path / "cases.yaml")], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


# Installed

def prepare(plane, namespace: str, *more: str) -> None:
    """Creates what a user creates before the install."""
    plane.kubectl("create", "-n", namespace, "-f", "-", given={"apiVersion": "v1", "kind": "Secret", "metadata": {"name": "diaphane"}, "stringData": SECRET})
    for name in ("it-diaphane-volumes", "it-diaphane-uploads", "it-diaphane-cache", *more):
        plane.apply(stored(namespace, name))


@pytest.fixture
def installed(plane, namespace, tmp_path):
    """A release `it` that helm installed with everything ready. Images on a kwok node run nothing."""
    prepare(plane, namespace)
    plane.helm("install", "it", str(CHART), "-n", namespace, "-f", values_file(tmp_path), "--wait", "--timeout", "180s")
    yield namespace
    plane.helm("uninstall", "it", "-n", namespace, "--wait", "--timeout", "120s", check=False)


def ready(plane, namespace: str) -> dict[str, int]:
    items = plane.kubectl("get", "deploy", "-n", namespace, "-o", "json").json["items"]
    return {one["metadata"]["name"]: one["status"].get("readyReplicas", 0) for one in items}


def test_install_upgrade_rollback_and_uninstall_succeed(plane, installed, tmp_path):
    assert ready(plane, installed) == {"it-diaphane-api": 2, "it-diaphane-ingest": 1, "it-diaphane-operator": 2}
    fleet = plane.kubectl("get", "rf/it-diaphane", "-n", installed, "-o", "json").json
    assert fleet["spec"]["warm"]["minIdleSlots"] == 4 and fleet["spec"]["sessionsPerWorker"] == 16
    plane.helm("test", "it", "-n", installed, "--timeout", "120s")

    # An upgrade keeps what the operator wrote, and a manual change of the scale.
    url = f"/apis/diaphane.dev/v1alpha1/namespaces/{installed}/renderfleets/it-diaphane"
    plane.api.patch(f"{url}/status", json={"status": {"replicas": 3}}, headers={"Content-Type": "application/merge-patch+json"}).raise_for_status()
    plane.kubectl("scale", "rf/it-diaphane", "-n", installed, "--replicas=5")
    plane.helm("upgrade", "it", str(CHART), "-n", installed, "-f", values_file(tmp_path, {"api": {"replicas": 3}, "fleet": {"sessionsPerWorker": 8}}),
               "--wait", "--timeout", "180s")
    assert ready(plane, installed)["it-diaphane-api"] == 3
    seen = plane.api.get(url).json()
    assert seen["spec"]["sessionsPerWorker"] == 8 and seen["spec"]["replicas"] == 5 and seen["status"]["replicas"] == 3 and seen["metadata"]["uid"] == fleet["metadata"]["uid"]

    plane.helm("rollback", "it", "1", "-n", installed, "--wait", "--timeout", "180s")
    wait_for(lambda: ready(plane, installed)["it-diaphane-api"] == 2, "two api again")
    assert plane.api.get(url).json()["spec"]["sessionsPerWorker"] == 16

    plane.helm("uninstall", "it", "-n", installed, "--wait", "--timeout", "120s")
    assert plane.kubectl("get", "deploy,rf,cm,svc,role,netpol,pdb", "-n", installed, "-o", "name").out.split() == ["configmap/kube-root-ca.crt"]
    claims = plane.kubectl("get", "pvc", "-n", installed, "-o", "name").out.split()
    assert len(claims) == 3, "people's scans went with the release"


def test_the_trial_installs_its_own_stores(plane, namespace, tmp_path):
    prepare(plane, namespace, "data-it-diaphane-trial-postgres-0", "data-it-diaphane-trial-redis-0")
    plane.helm("install", "it", str(CHART), "-n", namespace, "-f", values_file(tmp_path, CHOICES["trial"]), "--wait", "--timeout", "180s")
    stores = plane.kubectl("get", "statefulset", "-n", namespace, "-o", "json").json["items"]
    assert {one["metadata"]["name"]: one["status"]["readyReplicas"] for one in stores} == {"it-diaphane-trial-postgres": 1, "it-diaphane-trial-redis": 1}
    assert sum(ready(plane, namespace).values()) == 5
    plane.helm("uninstall", "it", "-n", namespace, "--wait", "--timeout", "120s")


def test_pods_are_spread_and_protected_by_disruption_budgets(plane, installed):
    pods = plane.kubectl("get", "pods", "-n", installed, "-l", "app.kubernetes.io/component=api", "-o", "json").json["items"]
    assert len({one["spec"]["nodeName"] for one in pods}) == 2
    budget = f"/apis/policy/v1/namespaces/{installed}/poddisruptionbudgets/it-diaphane-api"
    wait_for(lambda: plane.api.get(budget).json()["status"]["disruptionsAllowed"] == 1, "the budget's count")

    def evict(name):
        return plane.api.post(f"/api/v1/namespaces/{installed}/pods/{name}/eviction", json={
            "apiVersion": "policy/v1", "kind": "Eviction", "metadata": {"name": name, "namespace": installed}}).status_code

    # otherwise a replacement of the first worker could be ready before the second is evicted
    plane.stop_program("kube-scheduler")
    try:
        assert [evict(one["metadata"]["name"]) for one in pods] == [201, 429]
    finally:
        plane.start_program("kube-scheduler")


def test_a_ready_worker_is_not_evicted(plane, installed):
    """`kubectl drain` cordons the node and then waits for the operator."""
    labels = {"app.kubernetes.io/name": "diaphane", "app.kubernetes.io/instance": "it", "app.kubernetes.io/component": "renderd"}
    spec = plane.kubectl("get", "rf/it-diaphane", "-n", installed, "-o", "json").json["spec"]["template"]["spec"]
    plane.kubectl("create", "-n", installed, "-f", "-", given={"apiVersion": "v1", "kind": "Pod", "metadata": {"name": "it-diaphane-0", "labels": labels},
                                                              "spec": spec})
    plane.kubectl("wait", "-n", installed, "pod/it-diaphane-0", "--for=condition=Ready", "--timeout=60s")
    wait_for(lambda: plane.kubectl("get", "pdb/it-diaphane-renderd", "-n", installed, "-o", "jsonpath={.status.currentHealthy}").out == "1", "the budget's count")
    answer = plane.api.post(f"/api/v1/namespaces/{installed}/pods/it-diaphane-0/eviction", json={
        "apiVersion": "policy/v1", "kind": "Eviction", "metadata": {"name": "it-diaphane-0", "namespace": installed}})
    assert answer.status_code == 429, answer.text


MAY = [("list", "pods"), ("create", "pods"), ("delete", "pods"), ("watch", "renderworkers"), ("create", "renderworkers"), ("patch", "renderfleets"),
       ("patch", "renderfleets/status"), ("patch", "renderworkers/status"), ("create", "leases"), ("create", "events")]
MAY_NOT = [("create", "renderfleets"), ("delete", "renderfleets"), ("get", "secrets"), ("list", "secrets"), ("get", "configmaps"), ("create", "pods/exec"),
           ("get", "pods/log"), ("update", "pods"), ("create", "deployments.apps"), ("delete", "persistentvolumeclaims"), ("impersonate", "users"),
           ("create", "serviceaccounts/token"), ("create", "roles.rbac.authorization.k8s.io"), ("delete", "leases")]


def test_the_operator_has_exactly_the_rights_it_needs(plane, installed):
    token = plane.service_account_token(installed, "it-diaphane-operator")
    who = plane.client(token=token)

    def may(verb, what, namespace):
        resource, _, group = what.partition(".")
        resource, _, sub = resource.partition("/")
        group = group or {"renderworkers": "diaphane.dev", "renderfleets": "diaphane.dev", "leases": "coordination.k8s.io"}.get(resource, "")
        asked = {"verb": verb, "resource": resource, "subresource": sub, "group": group, **({"namespace": namespace} if namespace else {})}
        answer = who.post("/apis/authorization.k8s.io/v1/selfsubjectaccessreviews", json={
            "apiVersion": "authorization.k8s.io/v1", "kind": "SelfSubjectAccessReview", "spec": {"resourceAttributes": asked}})
        return answer.json()["status"]["allowed"]

    assert [pair for pair in MAY if not may(*pair, installed)] == []
    assert [pair for pair in MAY_NOT if may(*pair, installed)] == []
    assert may("list", "nodes", "") and may("watch", "nodes", "")
    assert not any(may(verb, "nodes", "") for verb in ("patch", "update", "delete", "create"))
    assert [pair for pair in MAY if may(*pair, "default") or may(*pair, "")] == [], "beyond its own namespace"
    # Tries it, in addition to asking the API server.
    assert who.get(f"/api/v1/namespaces/{installed}/secrets/diaphane").status_code == 403
    assert who.get("/api/v1/namespaces/kube-system/pods").status_code == 403
    assert who.get("/api/v1/nodes").status_code == 200
    lease = f"/apis/coordination.k8s.io/v1/namespaces/{installed}/leases"
    assert who.post(lease, json={"metadata": {"name": "it-diaphane-operator"}, "spec": {"holderIdentity": "x"}}).status_code == 201
    assert who.get(f"{lease}/it-diaphane-operator").status_code == 200 and who.get(f"{lease}/another").status_code == 403
