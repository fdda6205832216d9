"""The module that pins Kubernetes for `./diaphane test cluster`."""

from __future__ import annotations

import re

from house import kubernetes


def test_all_of_kubernetes_is_of_one_release():
    text = (kubernetes.MODULE / "go.mod").read_text(encoding="utf-8")
    replaced = dict(re.findall(r"^\s*(k8s\.io/\S+) => k8s\.io/\S+ v(\S+)$", text, re.MULTILINE))
    assert len(replaced) > 25
    assert set(replaced.values()) == {"0" + kubernetes.version().removeprefix("1")}
    sums = (kubernetes.MODULE / "go.sum").read_text(encoding="utf-8")
    assert f"k8s.io/kubernetes v{kubernetes.version()} h1:" in sums


def test_another_choice_of_versions_is_built_beside(monkeypatch):
    one = kubernetes.folder()
    monkeypatch.setattr(kubernetes, "KWOK", kubernetes.KWOK + "1")
    assert kubernetes.folder() != one and kubernetes.folder().parent == one.parent
