"""Environments: uploading panoramas, who sees what of them, refusing bad files, the quota, and what is left after a deletion."""

from __future__ import annotations

import io
import math
import zipfile
from pathlib import Path

import pytest
from api_client import PASSWORD, api, client, one, other, person, problem  # noqa: F401
from panoramas import exr, hdr

MOST = 16
#: A sun of 100,000 in a sky of 1.
SUN = (40, 10)


def sky(x: int, y: int) -> tuple[float, float, float]:
    return (1e5, 1e5, 1e5) if (x, y) == SUN else (1.0, 1.0, 1.0)


def add(who, file: bytes, name: str = "Sky"):
    return who.http.post("/v1/environments", params={"name": name}, content=file)


def stored(stack, identifier: str) -> Path:
    return stack.data_dir / "volumes" / "environments" / f"{identifier}.hdr"


def radiances(file: Path, width: int, height: int) -> list[float]:
    """Returns the green components."""
    pixels = file.read_bytes()[-4 * width * height:]
    return [math.ldexp(pixels[i + 1], pixels[i + 3] - 136) for i in range(0, len(pixels), 4)]


@pytest.mark.parametrize("encode", (hdr, exr))
def test_a_panorama_is_stored_with_a_mean_of_one(api, encode):  # noqa: F811
    one = person(api)  # noqa: F811
    answer = add(one, encode(64, 32, sky), "My  sky")
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert made["name"] == "My sky" and made["mine"] and answer.headers["location"].endswith(made["id"])
    green = radiances(stored(api, made["id"]), 64, 32)
    assert math.isclose(max(green) / min(green), 1e5, rel_tol=0.02) and green.index(max(green)) == SUN[0] + 64 * SUN[1]
    weights = [math.sin(math.pi * (i // 64 + 0.5) / 32) for i in range(len(green))]
    assert math.isclose(sum(w * g for w, g in zip(weights, green)) / sum(weights), 1, rel_tol=0.02)
    assert add(one, encode(64, 32, sky), "Again").json()["id"] == made["id"], "an account stores a file once"
    assert [each["name"] for each in one.http.get("/v1/environments").json()["items"]] == ["My sky"]


def test_only_the_owner_sees_and_changes_an_environment(api, one, other):  # noqa: F811
    made = add(one, hdr(8, 4, lambda x, y: (x + 1, 1, 1)), "Our garden").json()["id"]
    path = f"/v1/environments/{made}"
    for who in (other.http, client(api)):
        seen = who.get(path).json()
        assert not seen["mine"] and "name" not in seen and len(seen["preview"]) == 3072
    assert other.http.get("/v1/environments").json()["items"] == []
    problem(other.http.patch(path, json={"name": "Mine"}), 404, "not-found")
    problem(other.http.delete(path), 404, "not-found")
    assert one.http.patch(path, json={"name": "Garden"}).json()["name"] == "Garden"
    assert one.http.delete(path).status_code == 204
    problem(one.http.get(path), 404, "not-found")
    api.wait_until(lambda: not stored(api, made).exists(), what="the disposal of the file")


@pytest.mark.parametrize(("file", "word"), (
    (b"", None), (b"\x89PNG\r\n\x1a\n", "format"), (hdr(8, 4, sky)[:-1], "damaged"),
    (b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 4 +X 8\n" + bytes(128), "variant"),
    (b"#?RADIANCE\n\n-Y 30000 +X 60000\n", "too_many_pixels"), (hdr(8, 8, sky), "shape"),
    (hdr(8, 4, lambda x, y: (0, 0, 0)), "black"), (exr(8, 4, sky)[:-5], "damaged"),
    (exr(8, 4, sky).replace(b"R\0", b"X\0", 1), "variant"), (b"\x76\x2f\x31\x01" + b"\xff" * 500, "damaged"),
))
def test_a_bad_file_is_refused_by_reason(api, one, file, word):  # noqa: F811
    refused = problem(add(one, file), 422, "invalid")
    assert refused["errors"][0]["field"] == f"file.{word or 'format'}", refused
    assert not list((api.data_dir / "volumes" / "environments").glob(".tmp*"))


def test_only_finite_radiances_reach_the_renderer(api, one):  # noqa: F811
    bad = {3: (math.nan, -5.0, 1.0), 4: (math.inf, 1.0, 1.0), 5: (3e38, 3e38, 3e38)}
    made = add(one, exr(16, 8, lambda x, y: bad.get(x, (1.0, 1.0, 1.0)) if y == 4 else (1.0, 1.0, 1.0))).json()["id"]
    pixels = stored(api, made).read_bytes()[-4 * 16 * 8:]
    assert pixels[4 * (3 + 16 * 4)] == 0 and pixels[4 * (3 + 16 * 4) + 1] == 0
    assert max(pixels[3::4]) <= 128 + 20


def test_a_panorama_larger_than_four_megabytes_is_refused_unread(api, one):  # noqa: F811
    problem(add(one, bytes(4 * 1024 * 1024 + 1)), 413, "body-too-large")
    problem(add(one, bytes(4 * 1024 * 1024)), 422, "invalid")


def test_an_account_has_at_most_sixteen_environments(api):  # noqa: F811
    full = person(api)
    for i in range(MOST):
        assert add(full, hdr(4, 2, lambda x, y, i=i: (i + 1, 1, 1))).status_code == 201
    problem(add(full, hdr(4, 2, lambda x, y: (99, 1, 1))), 429, "too-many")


def test_an_environment_is_in_the_export_and_goes_with_the_account(api):  # noqa: F811
    leaving = person(api)
    made = add(leaving, hdr(4, 2, lambda x, y: (1, 2, 3)), "Mine alone").json()["id"]
    kept = stored(api, made).read_bytes()
    assert leaving.http.post("/v1/me/export").status_code == 202
    api.wait_until(lambda: leaving.http.get("/v1/me/export").json()["state"] == "ready", what="the export")
    archive = zipfile.ZipFile(io.BytesIO(leaving.http.get("/v1/me/export/file").content))
    assert archive.read(f"environments/{made}.hdr") == kept
    assert b"Mine alone" in archive.read("records/environments.owner_id.json")
    assert leaving.http.post("/v1/me/deletion", json={"password": PASSWORD}).status_code == 204
    problem(client(api).get(f"/v1/environments/{made}"), 404, "not-found")
    api.wait_until(lambda: not stored(api, made).exists(), what="the disposal of the file")

