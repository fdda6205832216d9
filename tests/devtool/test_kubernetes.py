"""The module that pins Kubernetes for `./diaphane test cluster`."""

from __future__ import annotations

import re

from devtool import kubernetes


def test_all_kubernetes_programs_have_one_version():
    text = (kubernetes.MODULE / "go.mod").read_text(encoding="utf-8")
    replaced = dict(re.findall(r"^\s*(k8s\.io/\S+) => k8s\.io/\S+ v(\S+)$", text, re.MULTILINE))
    assert len(replaced) > 25
    assert set(replaced.values()) == {"0" + kubernetes.version().removeprefix("1")}
    sums = (kubernetes.MODULE / "go.sum").read_text(encoding="utf-8")
    assert f"k8s.io/kubernetes v{kubernetes.version()} h1:" in sums


def test_other_versions_get_a_folder_of_their_own(monkeypatch):
    one = kubernetes.folder()
    monkeypatch.setattr(kubernetes, "KWOK", kubernetes.KWOK + "1")
    assert kubernetes.folder() != one and kubernetes.folder().parent == one.parent


def test_checkouts_share_kubernetes_builds(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(kubernetes, "folder", lambda: tmp_path / "checkout" / "key")
    assert set(kubernetes.missing()) >= set(kubernetes.PROGRAMS)
    kubernetes.shared().mkdir(parents=True)
    (kubernetes.shared() / "etcd").write_text("etcd", encoding="utf-8")
    assert "etcd" not in kubernetes.missing() and "kubectl" in kubernetes.missing()
    assert (tmp_path / "checkout" / "key" / "etcd").read_text(encoding="utf-8") == "etcd"
