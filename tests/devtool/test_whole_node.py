"""Why a machine cannot run a complete node."""

from __future__ import annotations

import os
import subprocess

from devtool import whole_node


def test_who_is_not_root_is_told(monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert whole_node.absence() == "running a node requires root"


def test_control_groups_that_are_not_there_are_named(monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(whole_node, "cgroup_folders", lambda: [])
    monkeypatch.setattr(whole_node, "CONTROL_GROUPS", whole_node.Path("/nowhere"))
    assert whole_node.absence() == "cgroup controllers are missing below /nowhere: cpu, cpuset, memory"


def test_namespaces_that_are_refused_are_told_with_the_reason(monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setattr(whole_node, "_no_cgroups", lambda: "")
    monkeypatch.setattr(whole_node.Path, "exists", lambda _: True)
    monkeypatch.setattr(whole_node.Path, "read_text", lambda *_, **__: "nodev\toverlay\n")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: subprocess.CompletedProcess([], 1, "", "unshare: Operation not permitted\n"))
    assert whole_node.absence() == "cannot create network, mount and PID namespaces with a bridge: unshare: Operation not permitted"
