"""Why a machine cannot run a complete node."""

from __future__ import annotations

import os
import subprocess

from devtool import whole_node


def test_a_user_other_than_root_gets_a_message(monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert whole_node.absence() == "running a node requires root"


def test_missing_control_groups_are_named(monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(whole_node, "cgroup_folders", lambda: [])
    monkeypatch.setattr(whole_node, "CONTROL_GROUPS", whole_node.Path("/nowhere"))
    assert whole_node.absence() == "cgroup controllers are missing below /nowhere: cpu, cpuset, memory"


def test_denied_namespaces_are_reported_with_the_reason(monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(whole_node, "_no_cgroups", lambda: "")
    monkeypatch.setattr(whole_node.Path, "exists", lambda _: True)
    monkeypatch.setattr(whole_node.Path, "read_text", lambda *_, **__: "nodev\toverlay\n")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: subprocess.CompletedProcess([], 1, "", "unshare: Operation not permitted\n"))
    assert whole_node.absence() == "cannot create network, mount and PID namespaces with a bridge: unshare: Operation not permitted"
