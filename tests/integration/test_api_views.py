"""The log of who viewed a scan, which its owner reads, and what the audit log has of the same views."""

from __future__ import annotations

import io
import json
import re
import secrets
import zipfile
from concurrent.futures import ThreadPoolExecutor

import psycopg
import pytest
from api_client import PASSWORD, add_worker, api, client, forget_attempts, make_ready, one, other, person, problem, remove_worker  # noqa: F401
from test_api_sharing import make_link, publish, ready, sample, session_of, share, unshare, visit


@pytest.fixture
def worker(api):  # noqa: F811
    add_worker(api, "views-test", slots=64)
    yield
    remove_worker(api, "views-test")


def views(owner, data_set: str, **query: str) -> list[dict]:
    answer = owner.http.get(f"/v1/data-sets/{data_set}/views", params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()["items"]


def audited(api, data_set: str) -> list[tuple]:  # noqa: F811
    return api.psql("SELECT actor, actor_id::text, details->>'by' FROM audit_log WHERE subject_id = %s AND action = 'data-set.looked-at' "
                    "ORDER BY id", data_set)


def join(api, owner, session: str, key: str) -> None:  # noqa: F811
    link = owner.http.post(f"/v1/sessions/{session}/links").json()["token"]
    assert client(api).post("/v1/join", json={"token": link, "key": key}).status_code == 201


def add_entries(api, data_set: str, route: str, count: int, age: str = "0 s") -> None:  # noqa: F811
    api.psql("""INSERT INTO views (id, data_set_id, route, viewer_hash, network, browser, first_at, last_at)
                SELECT gen_random_uuid(), %s, %s, 'viewer ' || n, '', '', t, t
                  FROM generate_series(1, %s) AS n CROSS JOIN LATERAL (SELECT now() - %s::interval - n * interval '1 s' AS t) AS times""",
             data_set, route, count, age)


def test_an_owner_sees_each_route_by_which_a_scan_was_viewed(api, one, other, worker):  # noqa: F811
    made = ready(api, one, anonymised=True)
    mine = session_of(one, made)
    join(api, one, mine, secrets.token_hex(32))
    share(one, made, other.email.upper())
    session_of(other, made)
    link = make_link(one, made)
    visit(api, token=link["token"])
    assert publish(one, made).status_code == 200
    stranger, boss = person(api), person(api)
    session_of(stranger, made)
    boss.becomes_administrator()
    session_of(boss, made)

    found = views(one, made)
    assert [entry["route"] for entry in found] == ["administrator", "gallery", "link", "person", "live-link", "owner"]
    assert [entry["email"] for entry in found if entry["email"]] == [other.email.lower()]
    [by_link] = [entry for entry in found if entry["route"] == "link"]
    assert by_link["link_created_at"] == link["created_at"]
    for entry in found:
        assert entry["network"] == "127.0.0.0/16" and entry["same_network"] and entry["times"] == 1
        assert entry["browser"] == "Unknown browser" and entry["first_at"] == entry["last_at"]
    assert [entry["route"] for entry in views(one, made, own="false")] == ["administrator", "gallery", "link", "person", "live-link"]
    assert audited(api, made) == [("person", one.id, "owner"), ("person", None, "live-link"), ("person", other.id, "person"),
                                  ("person", None, "link"), ("person", stranger.id, "gallery"), ("administrator", boss.id, "administrator")]
    assert not re.search(r"127\.0\.0\.1|@|httpx", str(api.psql("SELECT * FROM audit_log WHERE subject_id = %s", made)))
    stored = str(api.psql("SELECT * FROM views WHERE data_set_id = %s", made))
    assert not re.search(r"127\.0\.0\.1|httpx", stored) and stranger.email not in stored and stranger.id not in stored


def test_repeated_views_within_an_hour_are_one_entry(api, one, other, worker):  # noqa: F811
    made = ready(api, one)
    share(one, made, other.email)
    session = session_of(other, made)
    for _ in range(2):  # a lost connection
        assert other.http.post(f"/v1/sessions/{session}/tickets").status_code == 201
    [entry] = views(one, made)
    assert entry["times"] == 3 and entry["first_at"] < entry["last_at"]
    other.http.headers["User-Agent"] = "Mozilla/5.0 (iPhone; CPU iPhone OS 18_0 like Mac OS X) Safari/604.1"
    session_of(other, made)
    assert [entry["browser"] for entry in views(one, made)] == ["Safari on iOS", "Unknown browser"]
    api.psql("UPDATE views SET last_at = last_at - interval '61 minutes' WHERE data_set_id = %s", made)
    session_of(other, made)
    assert [entry["times"] for entry in views(one, made)] == [1, 1, 3]
    assert len(audited(api, made)) == 1


def test_simultaneous_views_are_counted_in_one_entry(api, one, other, worker):  # noqa: F811
    made = ready(api, one)
    share(one, made, other.email)
    tickets = f"/v1/sessions/{session_of(other, made)}/tickets"
    api.psql("DELETE FROM views WHERE data_set_id = %s", made)
    waiting = "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND wait_event_type = 'Lock'"
    with ThreadPoolExecutor(2) as pool, psycopg.connect(api.dsn) as holder:
        holder.execute("SELECT FROM data_sets WHERE id = %s FOR UPDATE", (made,))
        answers = [pool.submit(other.http.post, tickets) for _ in range(2)]
        api.wait_until(lambda: api.psql(waiting)[0][0] >= 2, what="both")
        holder.commit()
        assert [answer.result().status_code for answer in answers] == [201, 201]
    assert [entry["times"] for entry in views(one, made)] == [2]


def test_a_returning_guest_is_recognised_but_not_another(api, one, worker):  # noqa: F811
    made = ready(api, one)
    token, key = make_link(one, made)["token"], secrets.token_hex(32)
    for guest in (key, key, secrets.token_hex(32)):
        assert visit(api, guest, token=token).status_code == 201
    assert [entry["times"] for entry in views(one, made)] == [1, 2]


def test_only_the_owner_reads_the_log(api, one, other, worker):  # noqa: F811
    made = ready(api, one)
    path = f"/v1/data-sets/{made}/views"
    problem(client(api).get(path), 401, "unauthenticated")
    problem(other.http.get(path), 404, "not-found")
    share(one, made, other.email, "save")
    problem(other.http.get(path), 403, "forbidden")
    for query in ({"own": "perhaps"}, {"limit": "0"}, {"cursor": "x"}):
        problem(one.http.get(path, params=query), 422, "invalid")


def test_the_log_is_read_page_by_page(api, one):  # noqa: F811
    made = ready(api, one)
    add_entries(api, made, "link", 5)
    whole = views(one, made)
    read, cursor = [], None
    for _ in range(3):
        page = one.http.get(f"/v1/data-sets/{made}/views", params={"limit": 2, **({"cursor": cursor} if cursor else {})}).json()
        read, cursor = read + page["items"], page["next_cursor"]
    assert read == whole and len(whole) == 5 and cursor is None


def test_the_log_of_a_scan_is_limited_per_route(api, one, other, worker):  # noqa: F811
    made, another = ready(api, one, anonymised=True), ready(api, one)
    add_entries(api, made, "link", 200)
    add_entries(api, made, "gallery", 200)
    add_entries(api, another, "gallery", 1, age="1 day")
    [(oldest,)] = api.psql("SELECT id::text FROM views WHERE data_set_id = %s AND route = 'gallery' ORDER BY last_at LIMIT 1", made)
    assert publish(one, made).status_code == 200
    session_of(other, made)
    counts = api.psql("SELECT route, count(*) FROM views WHERE data_set_id = %s GROUP BY route ORDER BY route", made)
    assert counts == [("gallery", 200), ("link", 200)]
    assert api.psql("SELECT 1 FROM views WHERE id = %s", oldest) == []
    assert len(views(one, another)) == 1


def test_old_entries_are_deleted(api, one):  # noqa: F811
    made = ready(api, one)
    add_entries(api, made, "link", 1, age="89 days")
    add_entries(api, made, "gallery", 1, age="90 days")
    assert len(views(one, made)) == 2
    api.stop("api")    # it deletes them when it starts, and then every ten minutes
    api.start("api")
    api.wait_ready("api")
    api.wait_until(lambda: [entry["route"] for entry in views(one, made)] == ["link"], what="the deletion")


def test_a_person_who_is_gone_is_not_named(api, one, worker):  # noqa: F811
    made = ready(api, one)
    friend = person(api)
    share(one, made, friend.email)
    session_of(friend, made)
    unshare(one, made)
    assert views(one, made)[0]["email"] == friend.email, "the owner still sees who viewed it"
    forget_attempts(api)
    assert friend.http.post("/v1/me/deletion", json={"password": PASSWORD}).status_code == 204
    [entry] = views(one, made)
    assert entry["route"] == "person" and entry["email"] is None
    assert friend.email not in str(api.psql("SELECT * FROM views"))


def test_the_log_is_in_the_export_and_ends_with_the_scan(api, one, other, worker):  # noqa: F811
    made, announced = ready(api, one), one.data_set(10)["data_set"]["id"]
    share(one, made, other.email)
    session_of(other, made)
    assert one.http.post("/v1/me/export").status_code == 202
    api.wait_until(lambda: one.http.get("/v1/me/export").json()["state"] == "ready", what="the export")
    for _ in range(2):
        file = one.http.get("/v1/me/export/file")
        assert file.status_code == 200
    records = json.loads(zipfile.ZipFile(io.BytesIO(file.content)).read("records/views.data_set_id.json"))
    [row] = [row for row in records if row["data_set_id"] == made]
    assert (row["route"], row["email_key"]) == ("person", other.email) and "viewer_hash" not in row
    assert [(entry["route"], entry["times"]) for entry in views(one, made)] == [("export", 2), ("person", 1)]
    assert views(one, announced) == []
    assert api.psql("SELECT count(*) FROM audit_log WHERE actor_id = %s AND action = 'account.export-downloaded'", one.id) == [(1,)]

    assert one.http.delete(f"/v1/data-sets/{made}").status_code == 204
    assert api.psql("SELECT count(*) FROM views WHERE data_set_id = %s", made) == [(0,)]
    assert api.psql("SELECT actor, actor_id::text FROM audit_log WHERE subject_id = %s AND action = 'data-set.deleted'",
                    made) == [("person", one.id)]


def test_views_of_a_sample_are_not_recorded(api, other, worker):  # noqa: F811
    made = sample(api, "Sample without a log")
    join(api, other, session_of(other, made), secrets.token_hex(32))
    assert visit(api, data_set_id=made).status_code == 201
    assert api.psql("SELECT count(*) FROM views WHERE data_set_id = %s", made) == [(0,)] and audited(api, made) == []
    api.psql("DELETE FROM data_sets WHERE id = %s", made)
