"""Measurements run from the command line in their quick form. Checks their output, not the speed."""

from __future__ import annotations

import csv
import json
import os
import subprocess

import pytest

from harness import REPO  # adds tools/ to the path
from devtool import paths


def bench(*arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([str(paths.VENV_PYTHON), str(REPO / "tools" / "devtool"), "bench", *arguments], text=True,
                          capture_output=True, env={**os.environ, "DIAPHANE_BUILD": str(paths.build_dir())}, timeout=500)


@pytest.mark.nightly
def test_growth_has_a_row_for_every_size_and_walk(tmp_path):
    done = bench("growth", "--quick", "--engine", "cpu", "--out", str(tmp_path), "--json", str(tmp_path / "results.json"))
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "growth-cpu.json").read_text())
    seen = {(row["volume"], row["width"], row["height"], row["walk"]) for row in report["rows"]}
    assert seen == {(volume, *canvas, walk) for walk in ("exact", "tracking")
                    for volume, canvas in (("16^3", (32, 32)), ("32^3", (32, 32)), ("32^3", (32, 18)), ("32^3", (64, 36)))}
    lines = list(csv.DictReader((tmp_path / "growth-cpu.csv").open()))
    assert len(lines) == len(report["rows"])
    for line in lines:
        for figure in ("pass_ms", "pass_in_a_row_ms", "load_ms", "prepare_ms", "edit_ms", "volume_bytes", "film_bytes"):
            assert float(line[figure]) > 0, (figure, line)
    assert any("exponent of the voxel count" in r["name"] for r in json.loads((tmp_path / "results.json").read_text())["results"])
    assert "32 x 32 x 32" in done.stdout


def test_load_reports_where_the_time_is_spent(tmp_path):
    done = bench("load", "--quick", "--json", str(tmp_path / "results.json"))
    assert done.returncode == 0, done.stdout + done.stderr
    results = {r["name"].partition(": ")[2]: r["value"] for r in json.loads((tmp_path / "results.json").read_text())["results"]}
    assert 0 < results["input to frame, p50"] <= results["input to frame, p95"] <= results["input to frame, p99"]
    whole = results["frame latency from its oldest input, mean"]
    parts = sum(results[f"of which {part}"] for part in ("rendering", "encoding", "waiting in renderd", "transport"))
    assert parts == pytest.approx(whole, rel=1e-6)
    assert results["frame rate of a moving session"] > 0 and results["device busy"] > 0


@pytest.mark.nightly
def test_a_recording_is_played_by_the_load_bench(tmp_path):
    scene = json.loads((REPO / "tests" / "scenes" / "cranium.json").read_text())
    events = [{"at_ms": 0, "scene": scene}]
    for number in range(1, 60):
        eye = {"x": 10 * number, "y": -400, "z": 50}
        events.append({"at_ms": number * 25, "camera": {**scene["camera"], "eye": eye}})
    recording = tmp_path / "recording.json"
    recording.write_text(json.dumps({"format": "diaphane-interaction", "version": 1, "viewport": {"width": 120, "height": 80}, "events": events}))
    done = bench("load", "--quick", "--recording", str(recording), "--json", str(tmp_path / "results.json"))
    assert done.returncode == 0, done.stdout + done.stderr
    results = json.loads((tmp_path / "results.json").read_text())["results"]
    assert results[0]["name"].startswith("2 sessions, 1 moving, 120 x 80: ") and all(r["value"] > 0 for r in results[:3])

    recording.write_text("{}")
    refused = bench("load", "--quick", "--recording", str(recording))
    assert refused.returncode != 0 and "the recording is not one" in refused.stdout + refused.stderr


@pytest.mark.nightly
def test_resources_do_not_grow_with_fifty_users_coming_and_going(tmp_path):
    """The soak's short form of 24 s. For the long one: `./diaphane bench soak`."""
    done = bench("soak", "--quick", "--json", str(tmp_path / "results.json"))
    assert done.returncode == 0, done.stdout + done.stderr
    results = json.loads((tmp_path / "results.json").read_text())["results"]
    watched = {tuple(r["name"].split(" growth")[0].split(": ")) for r in results if " growth, " in r["name"]}
    assert watched >= {(program, what) for program in ("gateway", "renderd") for what in ("memory", "descriptors", "threads")}
    assert all(r["met"] for r in results)


@pytest.mark.nightly
def test_head_detection_results_are_reported_by_body_part(tmp_path):
    """One synthetic body of each kind. `./diaphane bench heads` has twenty, and real scans."""
    done = bench("heads", "--quick", "--out", str(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "heads.json").read_text())
    said = {row["kind"]: (row["is_head"], row["said_head"], row["n"]) for row in report["kinds"]}
    for modality in ("CT", "MR"):
        assert said[f"made {modality}: head, whole"] == (True, 1, 1)
        for other in ("chest", "abdomen", "legs", "hand", "noise", "air and table"):
            assert said[f"made {modality}: {other}"] == (False, 0, 1), done.stdout
    lines = list(csv.DictReader((tmp_path / "heads.csv").open()))
    assert len(lines) == sum(n for _, _, n in said.values()) and all(float(line["seconds"]) > 0 for line in lines)
    assert "specificity 1.00 (0.21 to 1.00)" in done.stdout


@pytest.mark.nightly
def test_attacks_are_reported_by_route_group_and_role(tmp_path):
    done = bench("edge-attacks", "--quick", "--routes", "getMe,/", "--roles", "nobody,owner", "--out", str(tmp_path), "--json", str(tmp_path / "results.json"))
    assert done.returncode == 0, done.stdout + done.stderr
    lines = list(csv.DictReader((tmp_path / "edge-attacks.csv").open()))
    assert [(line["group"], line["role"]) for line in lines] == [(group, role) for group in ("accounts", "pages") for role in ("nobody", "owner")]
    assert all(int(line["sent"]) == sum(int(line[ended]) for ended in ("refused", "answered", "closed")) > 0 for line in lines)
    assert json.loads((tmp_path / "edge-attacks.json").read_text())["misses"] == []


@pytest.mark.nightly
def test_the_contract_is_reported_by_phase(tmp_path):
    done = bench("contract", "--only", "getMe", "--phases", "coverage", "--json", str(tmp_path / "results.json"))
    assert done.returncode == 0, done.stdout + done.stderr
    results = {r["name"]: r["value"] for r in json.loads((tmp_path / "results.json").read_text())["results"]}
    assert results["coverage: cases"] > 3 and results["coverage: findings"] == 0


@pytest.mark.nightly
def test_an_attack_fails_no_request_of_ordinary_users(tmp_path):
    """A few attackers for a few seconds. The long form is `./diaphane bench abuse`. Latencies are not judged here."""
    bench("abuse", "--quick", "--json", str(tmp_path / "results.json"))
    results = {r["name"]: r for r in json.loads((tmp_path / "results.json").read_text())["results"]}
    assert results["failed requests of ordinary users"]["value"] == 0
    assert results["programs that exited"]["value"] == 0
    assert results["under attack: requests of ordinary users"]["value"] > 0
    assert results["p95 under attack / calm"]["value"] > 0
