"""Fixtures that start the real programs.

    stack          the whole of Diaphane, once for all tests of a run, or of a worker of a parallel run. Leave it as you found it.
    stores         only Postgres and Redis, once likewise.
    fresh_stack    a whole one of its own, for tests that break things.
    stack_factory  the same with choices: stack_factory(only=("postgres", "redis", "api"), extra_env={...}).

What they give is a harness.TestStack. Its programs come from build/release, or from $DIAPHANE_BUILD.
When a test fails, the ends of the logs of its stacks are in the report.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import pytest

import workers
from archives import phantom_folder
from harness import StackFactory, TestStack, free_port
from orthanc import Orthanc


@pytest.fixture(scope="session")
def all_stacks(request):
    shared = getattr(request.config, "workerinput", {}).get("shared") or request.config.getoption("--shared")
    factory = StackFactory(Path(shared).resolve() if shared else None)
    yield factory
    factory.close()


@pytest.fixture(scope="session")
def stack(all_stacks: StackFactory) -> TestStack:
    return all_stacks.open()


@pytest.fixture(scope="session")
def stores(all_stacks: StackFactory) -> TestStack:
    return all_stacks.open(only=("postgres", "redis"))


@pytest.fixture(scope="module")
def orthanc(all_stacks: StackFactory):
    """Yields a PACS with the phantom, which knows the receiver of a stack with port `receiver_port`."""
    port = free_port()
    with Orthanc(all_stacks, {"diaphane": ["DIAPHANE", "127.0.0.1", port]}) as running:
        running.receiver_port = port
        running.store(phantom_folder(all_stacks))
        yield running


@pytest.fixture
def stack_factory(all_stacks: StackFactory):
    opened = []

    def make(**choices) -> TestStack:
        opened.append(all_stacks.open(**choices))
        return opened[-1]

    yield make
    for one in opened:
        all_stacks.shut(one)


@pytest.fixture
def fresh_stack(stack_factory) -> TestStack:
    return stack_factory()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if report.failed:
        for name, value in getattr(item, "funcargs", {}).items():
            stacks = [value] if isinstance(value, TestStack) else []
            if isinstance(value, StackFactory):
                stacks = value.opened
            for one in stacks:
                for program, text in one.log_tails().items():
                    report.sections.append((f"{name}: end of the log of {program}", text))
    return report


# Parallel runs

def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--claims", type=Path, help="run only the files of tests that no other run with this folder has claimed")
    parser.addoption("--shared", type=Path, help="folder for what is made once for all runs that share it")


def pytest_configure(config: pytest.Config) -> None:
    if folder := config.getoption("--claims"):
        config.claims = workers.Claims(folder)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> bool | None:
    """Passes over a test, as if it had run, by returning True."""
    claims = getattr(item.config, "claims", None)
    return None if claims is None or claims.ours(item.nodeid) else True


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: workers.rank_of(item.path.name))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    return workers.ByFile(config, log)


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node) -> None:
    """Called for each worker by the process that the user started."""
    if given := node.config.getoption("--shared"):
        node.workerinput["shared"] = str(given)
        return
    if not hasattr(node.config, "shared_by_workers"):
        node.config.shared_by_workers = tempfile.mkdtemp(prefix="diaphane-shared-")
        Path(node.config.shared_by_workers).chmod(0o755)
    node.workerinput["shared"] = node.config.shared_by_workers


def pytest_unconfigure(config: pytest.Config) -> None:
    if folder := getattr(config, "shared_by_workers", ""):
        shutil.rmtree(folder, ignore_errors=True)
