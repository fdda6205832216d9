"""Checks of the chart that need no helm: it uses every setting of the programs, and documents all of its values."""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import pytest
import yaml

REPO = Path(__file__).resolve().parents[2]
CHART = REPO / "helm" / "diaphane"


def _sources() -> str:
    folders = ("api", "common", "ingest", "renderd", "operator")
    files = [file for folder in folders for file in (REPO / folder).rglob("*.cpp")]
    return "\n".join(file.read_text(encoding="utf-8") for file in (*files, REPO / "pacs" / "diaphane_pacs" / "metrics.py"))


def _read_by_helpers(text: str) -> set[str]:
    """Returns the settings that a program reads with functions of common/."""
    helpers = {"postgres::read_url(in": {"POSTGRES"}, "wire::read_plain_allowed(in": {"INNER_PLAIN"}, "wire::read_redis(in": {"REDIS"},
               "service::read_admin_options(in": {"ADMIN_PORT", "ADMIN_ADDRESS"}}
    return set().union(*(names for call, names in helpers.items() if call in text))


def test_rules_and_dashboards_query_existing_metrics():
    there = set(re.findall(r'"(diaphane_[a-z0-9_]+)"', _sources()))
    asked = set(re.findall(r"\bdiaphane_[a-z0-9_]+", (CHART / "files" / "rules.yaml").read_text(encoding="utf-8")))
    asked |= set(re.findall(r"\bdiaphane_[a-z0-9_]+", (CHART / "files" / "dashboard.json").read_text(encoding="utf-8")))
    assert len(asked) > 20
    assert {name for name in asked if name not in there and re.sub("_(bucket|sum|count)$", "", name) not in there} == set()


def test_templates_set_only_settings_that_programs_read():
    programs = {"api.yaml": ("api/main.cpp", "api/settings.cpp", "api/gateway_main.cpp"), "migrate.yaml": ("api/main.cpp",), "ingest.yaml": ("ingest/main.cpp",), "fleet.yaml": ("renderd/settings.cpp",)}
    if (REPO / "operator" / "main.cpp").exists():
        programs["operator.yaml"] = programs["retire.yaml"] = ("operator/main.cpp",)
    for template, files in programs.items():
        text = "".join((REPO / file).read_text(encoding="utf-8") for file in files)
        read = {name.upper().replace("-", "_") for name in re.findall(r'in\.\w+\(\s*"([a-z-]+)"', text)} | _read_by_helpers(text)
        given = set(re.findall(r"name: DIAPHANE_([A-Z_]+)", (CHART / "templates" / template).read_text(encoding="utf-8")))
        assert given and given <= read, f"{template}: {given - read}"
    shared = (REPO / "common" / "wire" / "inner_tls.cpp").read_text(encoding="utf-8")
    read = {name.upper().replace("-", "_") for name in re.findall(r'in\.\w+\(\s*"([a-z-]+)"', shared)}
    given = set(re.findall(r"name: DIAPHANE_([A-Z_]+)", (CHART / "templates" / "_helpers.tpl").read_text(encoding="utf-8")))
    assert given == read - {"REDIS"}


@pytest.mark.parametrize("program, file, one", [("api", "settings.cpp", "FACTOR_KEY"), ("gateway", "gateway_main.cpp", "STREAM_PORT")])
def test_a_container_is_given_every_setting_that_its_program_needs(program, file, one):
    text = (REPO / "api" / file).read_text(encoding="utf-8")
    needed = {name.upper().replace("-", "_") for name in re.findall(r'in\.(?:text|port|directory)\(\s*"([a-z-]+)",\s*(?:"[^"]*"\s*)+\)', text)}
    assert one in needed
    needed |= _read_by_helpers(text) - {"ADMIN_ADDRESS", "INNER_PLAIN"}
    container = (CHART / "templates" / "api.yaml").read_text(encoding="utf-8").partition(f"- name: {program}\n")[2].partition("- name: edge\n")[0]
    assert needed <= set(re.findall(r"name: DIAPHANE_([A-Z_]+)", container))


def test_the_schema_has_exactly_the_values_of_the_chart():
    schema = json.loads((CHART / "values.schema.json").read_text(encoding="utf-8"))
    values = yaml.safe_load((CHART / "values.yaml").read_text(encoding="utf-8"))
    jsonschema.validate({**values, "publicUrl": "https://a.example", "existingSecret": "x"}, schema)
    missing = []

    def walk(schema, value, path):
        for name, inner in schema.get("properties", {}).items():
            if isinstance(inner.get("properties"), dict) and inner.get("additionalProperties") is False and path.count(".") < 3 and name not in ("requests",):
                if name not in (value or {}):
                    missing.append(f"{path}.{name}")
                else:
                    walk(inner, value[name], f"{path}.{name}")
            elif name not in (value or {}) and name != "global":
                missing.append(f"{path}.{name}")

    walk(schema, values, "")
    assert missing == []


def test_the_charts_fleet_matches_the_resource():
    crd = yaml.safe_load((CHART / "crds" / "renderfleets.yaml").read_text(encoding="utf-8"))
    spec = crd["spec"]["versions"][0]["schema"]["openAPIV3Schema"]["properties"]["spec"]["properties"]
    text = (CHART / "templates" / "fleet.yaml").read_text(encoding="utf-8").partition("\nspec:\n")[2]
    assert set(re.findall(r"^  ([a-zA-Z]+):", text, re.MULTILINE)) == set(spec)
    values = yaml.safe_load((CHART / "values.yaml").read_text(encoding="utf-8"))["fleet"]
    for name in ("sessionsPerWorker", "gpusPerWorker", "strategy", "minReplicas", "drainTimeout"):
        jsonschema.validate(values[name], {key: value for key, value in spec[name].items() if not key.startswith("x-")})


@pytest.mark.parametrize("setting, value, templates", [
    ("texture-memory-mb", ("fleet", "textureMemoryMb"), ("fleet.yaml",)),
    ("visitor-share", ("visitorShare",), ("fleet.yaml", "api.yaml")),
])
def test_chart_limits_have_the_defaults_and_bounds_of_the_programs(setting, value, templates):
    schema = json.loads((CHART / "values.schema.json").read_text(encoding="utf-8"))
    default = yaml.safe_load((CHART / "values.yaml").read_text(encoding="utf-8"))
    for name in value:
        schema, default = schema["properties"][name], default[name]
    read = re.search(rf'"{setting}",\s*(?:"[^"]*"\s*)+,\s*(\d+),\s*([\d <]+),\s*([\w >]+)\)', (REPO / "renderd" / "settings.cpp").read_text(encoding="utf-8"))
    constants = {"kVisitorPercent": ("common/visitor_share.h", r"kVisitorPercent = (\d+)"), "kTextureMemory": ("renderd/scene/texture_store.h", r"kTextureMemory = std::size_t\{(1)\} << 30")}
    constant = read[3].split()[0]
    file, pattern = constants[constant]
    [number] = re.findall(pattern, (REPO / file).read_text(encoding="utf-8"))
    expected = int(number) << (10 if constant == "kTextureMemory" else 0)    # converts GiB to MiB
    highest = int(read[2]) if "<<" not in read[2] else 1 << int(read[2].split("<<")[1])
    assert (default, schema["minimum"], schema["maximum"]) == (expected, int(read[1]), highest)
    for template in templates:
        text = (CHART / "templates" / template).read_text(encoding="utf-8")
        assert f"{{name: DIAPHANE_{setting.upper().replace('-', '_')}, value: {{{{ .Values.{'.'.join(value)} | int | quote }}}}}}" in text
