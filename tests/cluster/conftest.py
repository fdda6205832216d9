"""The control plane, once for all tests of a run. Fixtures: `plane` has the custom resources and two kwok nodes with 8 GPUs each.
`namespace` is an empty namespace of the test with Pod Security "restricted" enforced. `cluster` contains what an operator needs
in it. A failing test shows the ends of the programs' logs."""

from __future__ import annotations

import itertools
import os
import shutil
import tempfile
import time
from pathlib import Path

import pytest
from plane import Plane

from devtool import kubernetes, logfiles, users

_numbers = itertools.count(1)
#: Needs its own namespaces (`./diaphane test node`).
collect_ignore = [] if os.environ.get("DIAPHANE_WHOLE_NODE") else ["test_whole_node.py"]


@pytest.fixture(scope="session")
def plane():
    if missing := kubernetes.missing():
        pytest.fail(f"not built: {', '.join(missing)}; ./diaphane test cluster builds them")
    run_as = users.ordinary_user()
    folder = Path(tempfile.mkdtemp(prefix="diaphane-plane-"))
    run_as.own(folder)
    made = Plane(folder, run_as).start()
    try:
        made.define_resources()
        made.add_nodes(2, gpus=8)
        yield made
    finally:
        made.stop()
        if not os.environ.get("DIAPHANE_KEEP"):
            shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def namespace(plane: Plane):
    name = f"test-{next(_numbers)}"
    plane.apply({"apiVersion": "v1", "kind": "Namespace", "metadata": {"name": name, "labels": {
        "pod-security.kubernetes.io/enforce": "restricted", "pod-security.kubernetes.io/enforce-version": "latest"}}})
    wait_for(lambda: plane.api.get(f"/api/v1/namespaces/{name}/serviceaccounts/default").status_code == 200, "the namespace's account")
    yield name
    plane.api.delete(f"/api/v1/namespaces/{name}")


@pytest.fixture
def cluster(plane: Plane, namespace: str, request):
    """Yields what an operator needs in the test's namespace, and reports the ends of the operators' logs after a failure."""
    from operator_helpers import Cluster     # imports wait_for from this module

    folder = Path(tempfile.mkdtemp(prefix="diaphane-operator-"))
    plane.run_as.own(folder)
    made = Cluster(plane, namespace, folder)
    yield made
    for one in made.operators:
        request.node.add_report_section("teardown", one.name, logfiles.tail(one.log, 40))
    made.close()
    shutil.rmtree(folder, ignore_errors=True)


def wait_for(condition, what: str, timeout: float = 120):
    """Returns the first true value of `condition`."""
    deadline = time.monotonic() + timeout
    while not (value := condition()):
        assert time.monotonic() < deadline, f"{what} did not come within {timeout} s"
        time.sleep(0.1)
    return value


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    made = getattr(item, "funcargs", {}).get("plane")
    if report.failed and isinstance(made, Plane):
        for program, text in made.log_tails().items():
            report.sections.append((f"end of the log of {program}", text))
    return report
