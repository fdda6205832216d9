#!/usr/bin/env python3
"""`./diaphane bench render` with the programs of one build, on a machine where nothing else is installed."""

import dataclasses
import json
import os
import pathlib
import sys

build, report = sys.argv[1:3]
os.environ["DIAPHANE_BUILD"] = build
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from house import bench  # noqa: E402
from house.benches import render  # noqa: E402

results = render.measure(quick=False)
bench._print(results)
written = {"bench": "render", "machine": bench.machine(), "results": [dataclasses.asdict(r) for r in results]}
pathlib.Path(report).write_text(json.dumps(written, indent=1) + "\n", encoding="utf-8")
