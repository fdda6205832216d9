"""The commands of `./diaphane`."""

from __future__ import annotations

import argparse
import importlib
import inspect
from pathlib import Path

import pytest

from devtool import admin, cli

[SUBPARSERS] = [action for action in cli._parser()._actions if isinstance(action, argparse._SubParsersAction)]


@pytest.mark.parametrize("name", SUBPARSERS.choices)
def test_the_function_of_a_command_takes_its_options(name):
    parser = SUBPARSERS.choices[name]
    given = {action.dest for action in parser._actions if action.dest != "help"} | set(parser._defaults)
    function = getattr(importlib.import_module(f"devtool.{parser.get_default('module')}"), parser.get_default("function"))
    rest = {"rest"} if parser.get_default("takes_rest") else set()
    inspect.signature(function).bind(**dict.fromkeys(given - {"module", "function", "takes_rest"} | rest))


@pytest.mark.parametrize("arguments", (("grant", "anna@example.org", "--data", "/d"), ("grant", "--data", "/d", "anna@example.org"),
                                       ("--data", "/d", "grant", "anna@example.org")))
def test_an_administrator_can_be_named_before_and_after_the_options(arguments, monkeypatch):
    asked = []
    monkeypatch.setattr(admin, "run", lambda **given: asked.append(given))
    cli.main(["admin", *arguments])
    assert asked == [{"what": "grant", "email": "anna@example.org", "data": Path("/d")}]


def test_unknown_arguments_are_refused():
    with pytest.raises(SystemExit, match="2"):
        cli.main(["down", "--nonsense"])
