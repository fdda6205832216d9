#!/usr/bin/env python3
"""Runs `./diaphane bench NAME` with the programs of one build, on a machine where nothing else is installed.

bench.py BUILD REPORT [NAME [OPTIONS...]]. NAME defaults to `render`."""

import argparse
import importlib
import os
import pathlib
import sys

build, report, *rest = sys.argv[1:]
name, own = (rest[0], rest[1:]) if rest else ("render", [])
os.environ["DIAPHANE_BUILD"] = build
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from devtool import bench  # noqa: E402

load = os.getloadavg()[0]
measured = importlib.import_module(f"devtool.benches.{name}")
if hasattr(measured, "add_options"):
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    measured.add_options(parser)
    options = parser.parse_args(own)
    results = measured.measure(options.quick, options)
else:
    results = measured.measure(quick=False)
bench._print(results)
bench.write_report(pathlib.Path(report), name.replace("_", "-"), " ".join(["tools/gpu/bench.py BUILD REPORT", name, *own]), load, results)
