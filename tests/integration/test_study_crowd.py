"""Many participants of a study at once: no acknowledged answer is lost, whatever fails, and nothing identifies them."""

from __future__ import annotations

import random
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest
from harness import contents_below
from study_helpers import Participant, definition, export, opened, rating, researcher

PROGRAMS = ("postgres", "redis", "api", "edge")
STEPS = [f"rating-{i}" for i in range(10)]
#: Longest time that a participant repeats one request: an outage lasts a few seconds.
PATIENCE = 120


@pytest.fixture(scope="module")
def stack(all_stacks):
    running = all_stacks.open(only=PROGRAMS)
    yield running
    all_stacks.shut(running)


def crowd_study(lab, places: int) -> tuple[str, str]:
    return opened(lab, definition(*({**rating(), "id": one} for one in STEPS), places=places))


def until_accepted(ask) -> httpx.Response:
    """Repeats a request as the page does: until it is answered, and neither by an outage nor by a limit."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            answer = ask()
            if answer.status_code < 500 and answer.status_code != 429:
                return answer
        except httpx.TransportError:
            pass
        assert time.monotonic() < end, "no answer"
        time.sleep(random.uniform(0.1, 0.5))


def take_part(stack, token: str, number: int, pause: float) -> tuple[Participant, dict[str, int]]:
    """Joins, answers every step and finishes. Returns what was acknowledged."""
    acknowledged: dict[str, int] = {}
    with httpx.Client(base_url=stack.url, timeout=30, verify=False) as http:
        one = Participant(stack, token, http)
        assert until_accepted(one.join).status_code == 201
        for i, step in enumerate(STEPS):
            value = (number + i) % 11
            # The sequence is that of the answer, not of the attempt.
            assert until_accepted(lambda: one.answer(step, {"rating": value}, i + 1)).status_code == 204  # noqa: B023
            acknowledged[step] = value
            time.sleep(random.uniform(0, pause))
        assert until_accepted(lambda: one.post("finish")).status_code == 204
    return one, acknowledged


def run_crowd(stack, participants: int, pause: float, disturb) -> None:
    lab = researcher(stack)
    study, token = crowd_study(lab, participants)
    done = threading.Event()
    breaker = threading.Thread(target=disturb, args=(done,))
    with ThreadPoolExecutor(participants) as pool:
        parts = [pool.submit(take_part, stack, token, number, pause) for number in range(participants)]
        breaker.start()
        acknowledged = [part.result()[1] for part in parts]
        done.set()
    breaker.join()
    stack.wait_ready("postgres", "redis", "api")
    exported = until_accepted(lambda: lab.http.get(f"/v1/studies/{study}/export")).json()
    stored = [{answer["step"]: answer["value"]["rating"] for answer in one["answers"]} for one in exported["participants"]]
    assert sorted(map(sorted_items, stored)) == sorted(map(sorted_items, acknowledged))
    assert all(one["state"] == "finished" for one in exported["participants"])
    assert until_accepted(lambda: Participant(stack, token).join()).status_code == 410, "the places are taken"


def sorted_items(answers: dict[str, int]) -> list[tuple[str, int]]:
    return sorted(answers.items())


def kill_each(stack, every: float):
    def disturb(done: threading.Event) -> None:
        for program in ("api", "redis", "postgres"):
            if done.wait(every):
                return
            stack.kill(program)
            stack.wait_ready(program)
    return disturb


def test_thirty_participants_lose_no_answer_while_api_and_stores_are_killed(stack):
    run_crowd(stack, 30, pause=0.8, disturb=kill_each(stack, 1.0))


@pytest.mark.nightly
def test_two_hundred_participants_lose_no_answer_while_api_and_stores_are_killed(stack):
    def disturb(done: threading.Event) -> None:
        while not done.is_set():
            kill_each(stack, 5.0)(done)
    run_crowd(stack, 200, pause=6.0, disturb=disturb)


ADDRESS, AGENT, COOKIE = "203.0.113.77", "CanaryBrowser/98.76", "c4" * 32


def dump_of_postgres(stack) -> bytes:
    """Returns all rows of all tables as text."""
    tables = stack.psql("SELECT quote_ident(tablename) FROM pg_tables WHERE schemaname = 'public'")
    return b"\n".join(str(stack.psql(f"SELECT * FROM {table}")).encode() for (table,) in tables)


def dump_of_redis(stack) -> bytes:
    return b"\n".join(stack.redis.dump(key) or b"" for key in stack.redis.scan_iter())


def test_nothing_in_any_store_or_log_identifies_a_participant(stack):
    lab = researcher(stack)
    study, token = crowd_study(lab, 3)
    headers = {"X-Forwarded-For": ADDRESS, "X-Real-IP": ADDRESS, "Forwarded": f"for={ADDRESS}", "User-Agent": AGENT,
               "Cookie": f"diaphane={COOKIE}; tracker={COOKIE}", "Referer": "https://canary.example/ward-9"}
    with httpx.Client(base_url=stack.url, timeout=30, verify=False, headers=headers) as http:
        one = Participant(stack, token, http)
        joined = one.join()
        assert joined.status_code == 201 and "set-cookie" not in joined.headers
        answer = one.answer(STEPS[0], {"rating": 1})
        assert answer.status_code == 204 and "set-cookie" not in answer.headers
    [participant] = export(lab, study)["participants"]
    assert set(participant) == {"number", "language", "seed", "state", "day", "recorded", "answers", "recordings"}
    columns = {name for (name,) in stack.psql("SELECT column_name FROM information_schema.columns WHERE table_name = 'study_participants'")}
    assert columns == {"id", "study_id", "number", "key_hash", "language", "seed", "day", "recorded", "finished", "preview_until",
                       "session_id", "session_expires_at"}, "a new column may identify a participant"
    [(row,)] = stack.psql("SELECT p::text FROM study_participants p WHERE study_id = %s", study)
    assert "127.0.0.1" not in row
    words = [word.encode() for word in (ADDRESS, AGENT, COOKIE, "canary.example", "ward-9", one.key, token)]
    dumps = {"rows": dump_of_postgres(stack), "keys": dump_of_redis(stack)}
    # The stores' own files are searched too; the log of the edge has the address of its peer, but no step, key or study.
    dumps |= {str(path): content for path, content in contents_below(stack.data_dir)}
    dumps |= {program: stack.log(program).encode() for program in PROGRAMS}
    assert [(name, word) for name, content in dumps.items() for word in words if word in content] == []
    assert str(participant["seed"]).encode() in dumps["rows"], "the search reads what is stored"
