"""From the hospital's archive to a picture: a real Orthanc holds a series of 512 x 512 slices, which is fetched by DICOMweb, built and
rendered. It excludes the user's own time to search."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from pathlib import Path
from typing import Iterator

from .. import paths, ports
from ..bench import Result, result
from ..bench_client import Person
from ..bench_stack import folder, prepared
from ..users import RunAs, ordinary_user

ABOUT = "time from starting to fetch 1000 slices of 512 x 512 from Orthanc to the first picture (target: 60 s)"

SECONDS = 60.0
SLICES, QUICK_SLICES, SIDE = 1000, 100, 512
STUDY, SERIES = "1.2.826.1", "1.2.826.1.1"
_PATIENCE = 900.0


def measure(quick: bool) -> list[Result]:
    slices = QUICK_SLICES if quick else SLICES
    steps: dict[str, list[float]] = {"fetched": [], "uploaded": [], "built": [], "from the archive to the first picture": []}
    run_as = ordinary_user()
    with folder(run_as) as base, _orthanc(base, run_as) as url:
        _store(url, slices)
        stack = prepared(base, "auto")
        stack.data.mkdir(mode=0o700)
        run_as.own(stack.data)
        (stack.data / "secrets").mkdir(mode=0o700)
        run_as.own(stack.data / "secrets")
        settings = stack.data / "archives.toml"
        settings.write_text(f'[[archive]]\nname = "bench"\ntitle = "Orthanc"\nurl = "{url}/dicom-web"\n', encoding="utf-8")
        run_as.own(settings)
        with stack:
            stack.wait_ready("pacs", 60)
            person = Person(stack)
            _give_access(stack, person)
            for _ in range(1 if quick else 3):
                _one(person, steps)
        ports.give_back(stack.ports.values())
    return [result(f"{name}, {slices} slices", runs, "s", at_most=SECONDS if "picture" in name else None) for name, runs in steps.items()]


def _one(person: Person, steps: dict[str, list[float]]) -> None:
    """Fetches the series once and waits for its first picture."""
    began = time.monotonic()
    path = "/v1/archives/bench/fetches"
    answer = person.http.post(path, json={"study": STUDY, "series": SERIES, "title": "Bench"})
    answer.raise_for_status()
    job, fetched = answer.json(), 0.0
    while job["state"] in ("fetching", "uploading"):
        time.sleep(0.2)
        job = person.http.get(f"{path}/{job['id']}").raise_for_status().json()
        if job["state"] != "fetching" and not fetched:
            fetched = time.monotonic()
    assert job["state"] == "done", job["problem"]
    uploaded = time.monotonic()
    data_set = job["data_set_id"]
    deadline = began + _PATIENCE
    while (state := person.http.get(f"/v1/data-sets/{data_set}").json())["state"] != "ready":
        assert state["state"] != "refused" and time.monotonic() < deadline, state
        time.sleep(0.2)
    built = time.monotonic()
    while person.http.get(f"/v1/data-sets/{data_set}/thumbnails/bone").status_code != 200:
        assert time.monotonic() < deadline, "no picture"
        time.sleep(0.2)
    steps["fetched"].append(fetched - began)
    steps["uploaded"].append(uploaded - fetched)
    steps["built"].append(built - uploaded)
    steps["from the archive to the first picture"].append(time.monotonic() - began)
    person.http.delete(f"/v1/data-sets/{data_set}")


def _give_access(stack, person: Person) -> None:
    import psycopg

    with psycopg.connect(stack.settings.dsn, autocommit=True) as database:
        database.execute("UPDATE users SET archive_access = true")


@contextlib.contextmanager
def _orthanc(base: Path, run_as: RunAs) -> Iterator[str]:
    """Yields the address of an Orthanc without accounts, which only this machine reaches."""
    import json

    import httpx

    given = ports.random_free()
    web, dicom, *others = given.values()
    ports.give_back(others)
    store = base / "orthanc"
    store.mkdir()
    run_as.own(store)
    settings = {"StorageDirectory": str(store), "IndexDirectory": str(store), "HttpPort": web, "DicomPort": dicom, "RemoteAccessAllowed": False,
                "AuthenticationEnabled": False, "Plugins": [str(path) for path in Path("/usr/lib/orthanc").glob("libOrthancDicomWeb.so*")],
                "DicomWeb": {"Enable": True, "Root": "/dicom-web/"}}
    (base / "orthanc.json").write_text(json.dumps(settings), encoding="utf-8")
    running = subprocess.Popen(["/usr/sbin/Orthanc", base / "orthanc.json"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/", **run_as.popen())
    try:
        url = f"http://127.0.0.1:{web}"
        for _ in range(600):
            with contextlib.suppress(httpx.TransportError):
                if httpx.get(f"{url}/system", trust_env=False).is_success:
                    break
            time.sleep(0.1)
        yield url
    finally:
        running.terminate()
        running.wait(30)
        ports.give_back((web, dicom))


def _store(url: str, slices: int) -> None:
    """Stores a CT scan of a made-up head: a shell in noise, so that nothing is unusually easy to compress or to build."""
    import httpx
    import numpy as np

    sys.path.insert(0, str(paths.REPO / "tests"))
    from phantom import slice_file

    rng = np.random.default_rng(1)
    y, x = np.ogrid[:SIDE, :SIDE]
    noise = rng.normal(0, 15, (SIDE, SIDE))
    with httpx.Client(base_url=url, trust_env=False, timeout=60) as http:
        for number in range(1, slices + 1):
            z = (number - slices / 2) * SIDE / slices
            far = np.sqrt((x - SIDE / 2) ** 2 + (y - SIDE / 2) ** 2 + z ** 2)
            pixels = (np.select([far < 170, far < 195, far < 210], [40, 1100, -60], -1000) + np.roll(noise, number, 0)).astype(np.int16)
            http.post("/instances", content=slice_file(number, pixels, STUDY, SERIES, 0.5)).raise_for_status()
