"""Studies for the tests: definitions, researchers and participants."""

from __future__ import annotations

import io
import secrets
from datetime import UTC, datetime, timedelta
from typing import Any

import httpx
from analysis_double import AnalysisDouble
from api_client import CONTRACT, client, make_ready, person
from PIL import Image

BOTH = {"en": "Hello", "de": "Hallo"}
CAMERA = {"eye": [0, -500, 0], "target": [0, 0, 0], "up": [0, 0, 1]}
SCENE = {**CONTRACT.spec["components"]["schemas"]["Scene"]["example"],
         "highlight": {"centre": {"x": 1}, "radius": 20, "colour": {"b": 1}, "strength": 0.5}}


def in_days(days: float) -> str:
    return (datetime.now(UTC) + timedelta(days=days)).strftime("%Y-%m-%dT%H:%M:%SZ")


def view(data_set: str, **more: Any) -> dict[str, Any]:
    return {"data_set_id": data_set, "scene": SCENE, "preset": "secret preset", "may_change": ["camera"], "start": "random", **more}


def step(kind: str, **more: Any) -> dict[str, Any]:
    return {"id": kind, "kind": kind, "group": "", "text": BOTH, **more}


def rating() -> dict[str, Any]:
    return step("rating", low=0, high=10, low_text=BOTH, high_text=BOTH)


def definition(*steps: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"version": 1, "template": "own", "title": BOTH, "places": 10, "ends_at": in_days(7), "record": True,
            "steps": [step("consent"), *(steps or (rating(),))], **more}


def every_kind(data_set: str) -> dict[str, Any]:
    """Returns a definition with a step of each kind."""
    seen = view(data_set, region={"name": BOTH, "centre": [0, 0, 10], "radius": 5})
    return definition(
        step("text"), rating(), step("words"),
        step("colours", view=seen, materials=[{"channel": "bone", "name": BOTH}]),
        step("order", pictures=[{"id": "a", "comfort": -2}, {"id": "b", "comfort": 2}]),
        step("viewpoint", view=seen), step("latency", view=seen, delays_ms=[0, 200]),
        step("choice", options=[{"id": "yes", "text": BOTH}, {"id": "no", "text": BOTH}], multiple=False))


#: A valid answer to each step of every_kind().
ANSWERS: dict[str, dict[str, Any]] = {
    "text": {}, "rating": {"rating": 7}, "words": {"words": "=1+1, \"quoted\"\nand äöü"},
    "colours": {"colours": [{"channel": "bone", "from": "#E8BA94", "to": "#ffffff"}]},
    "order": {"order": ["b", "a"], "shown": ["a", "b"]},
    "viewpoint": {"camera": CAMERA, "start": CAMERA},
    "latency": {"trials": [{"delay_ms": delay, "time_ms": 900, "error_degrees": 4.5, "acceptable": True, "rating": 8} for delay in (200, 0)]},
    "choice": {"choice": ["yes"]},
}


def tour_of(step: str, data_set: str, count: int = 2) -> dict[str, Any]:
    """Returns the tour of a step as the analysis gives it: views from the front, each a little higher."""
    views = [{"eye": [0.5, -400.0, 10.0 * n], "target": [0.0, 0.0, 10.0 * n], "up": [0.0, 0.0, 1.0]} for n in range(count)]
    return {"step": step, "data_set_id": data_set, "views": views}


def picture(kind: str = "PNG", **more: Any) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (8, 6), (200, 100, 50)).save(file, kind, **more)
    return file.getvalue()


def researcher(stack):
    """Returns a user with the role, as an administrator gives it."""
    made = person(stack)
    stack.psql("UPDATE users SET is_researcher = true WHERE id = %s", made.id)
    return made


def scan_of(stack, owner) -> str:
    made = owner.upload(b"x" * 100)["id"]
    make_ready(stack, made)
    return made


def create(who, of: dict[str, Any]) -> str:
    made = who.http.post("/v1/studies", json={"definition": of})
    assert made.status_code == 201, made.text
    return made.json()["id"]


def set_state(who, study: str, state: str) -> httpx.Response:
    return who.http.post(f"/v1/studies/{study}/state", json={"state": state})


def opened(who, of: dict[str, Any]) -> tuple[str, str]:
    """Returns an open study and the token of its link."""
    study = create(who, of)
    for one in of["steps"]:
        for shown in one.get("pictures", []):
            answer = who.http.put(f"/v1/studies/{study}/pictures/{shown['id']}", content=picture(), headers={"Content-Type": "image/png"})
            assert answer.status_code == 204, answer.text
    answer = set_state(who, study, "open")
    assert answer.status_code == 200, answer.text
    return study, who.http.post(f"/v1/studies/{study}/link").json()["path"].removeprefix("/study#")


class Participant:
    """A browser without an account that takes part in a study."""

    def __init__(self, stack, token: str, http: httpx.Client | None = None):
        self.http, self.token, self.key, self.sequence = http or client(stack), token, secrets.token_hex(32), 0

    def post(self, what: str, **body: Any) -> httpx.Response:
        return self.http.post(f"/v1/study/{what}", json={"key": self.key, **body})

    def join(self, record: bool = False, language: str = "en") -> httpx.Response:
        return self.post("participants", token=self.token, language=language, record=record)

    def answer(self, of: str, value: Any, sequence: int | None = None) -> httpx.Response:
        self.sequence += 1
        return self.post("answers", step=of, value=value, duration_ms=1500, sequence=self.sequence if sequence is None else sequence)


def joined(stack, token: str, **how: Any) -> Participant:
    made = Participant(stack, token)
    answer = made.join(**how)
    assert answer.status_code == 201, answer.text
    return made


def export(who, study: str) -> dict[str, Any]:
    answer = who.http.get(f"/v1/studies/{study}/export", params={"format": "json"})
    assert answer.status_code == 200, answer.text
    return answer.json()


def study_ways(stack, who, data_set: str) -> None:
    """Runs all operations of studies that succeed without the analysis."""
    stack.psql("UPDATE users SET is_researcher = true WHERE id = %s", who.id)
    study, token = opened(who, every_kind(data_set))
    path = f"/v1/studies/{study}"
    who.http.get("/v1/studies")
    who.http.get(f"{path}/pictures/a")
    export(who, study)
    who.http.post(f"{path}/preview", json={"key": secrets.token_hex(32)})
    found = who.http.get(path)
    who.http.put(path, json={"definition": every_kind(data_set)}, headers={"If-Match": found.headers["etag"]})
    set_state(who, study, "open")
    client(stack).post("/v1/study/invitation", json={"token": token})
    one = joined(stack, token, record=True)
    one.answer("rating", ANSWERS["rating"])
    one.post("pictures", picture="a")
    one.post("visits", step="viewpoint")
    one.post("recordings", step="viewpoint", recording={
        "format": "diaphane-interaction", "version": 1, "viewport": {"width": 64, "height": 64}, "events": [{"at_ms": 0, "scene": {}}]})
    for last in ("finish", "withdrawal"):
        one.post(last)
    client(stack).get("/v1/perception")
    who.http.delete(path)
    who.http.get(f"/v1/data-sets/{data_set}/tour")


def study_result_ways(all_stacks) -> None:
    """Runs the operations that need the analysis, on a stack of their own."""
    double = AnalysisDouble()
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge"), extra_env={"DIAPHANE_STUDY_ANALYSIS_URL": double.url})
    who = researcher(stack).becomes_administrator()
    study = create(who, definition())
    double.answer["adoptable"]["comfort"] = {"bone": [0, 0, 0], "blood": [0, 0, 0]}
    who.http.get(f"/v1/studies/{study}/analysis")
    who.http.post(f"/v1/studies/{study}/adoption", json={"comfort": True})
    who.http.delete("/v1/perception/comfort")
    scan = scan_of(stack, who)
    double.answer["adoptable"]["tours"] = [tour_of("viewpoint", scan)]
    who.http.put(f"/v1/data-sets/{scan}/tour", json={"study_id": study, "step": "viewpoint"})
    who.http.delete(f"/v1/data-sets/{scan}/tour")
    all_stacks.shut(stack)
    double.close()
