"""Sharing a data set with people, by links and publicly, revoking it, and viewing without an account."""

from __future__ import annotations

import secrets
import uuid

import httpx
import pytest
from api_client import (CONTRACT, add_worker, api, client, forget_attempts, make_ready, one, other, person, problem,  # noqa: F401
                        remove_worker)


@pytest.fixture
def worker(api):  # noqa: F811
    add_worker(api, "sharing-test", slots=64)
    yield
    remove_worker(api, "sharing-test")


def ready(api, owner, title: str = "", anonymised: bool = False) -> str:  # noqa: F811
    made = owner.upload(b"x" * 100, title=title)["id"]
    make_ready(api, made)
    if anonymised:
        api.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", made)
    return made


def publish(owner, data_set: str) -> httpx.Response:
    return owner.http.post(f"/v1/data-sets/{data_set}/visibility", json={"visibility": "public"})


def make_private(owner, data_set: str) -> None:
    answer = owner.http.post(f"/v1/data-sets/{data_set}/visibility", json={"visibility": "private"})
    assert answer.status_code == 200 and not answer.json()["is_public"]


def share(owner, data_set: str, email: str, may: str = "view") -> None:
    answer = owner.http.post(f"/v1/data-sets/{data_set}/people", json={"email": email, "may": may})
    assert answer.status_code == 204, answer.text


def people(owner, data_set: str) -> list[dict]:
    return owner.http.get(f"/v1/data-sets/{data_set}/people").json()["items"]


def unshare(owner, data_set: str) -> None:
    for one_of_them in people(owner, data_set):
        assert owner.http.delete(f"/v1/data-sets/{data_set}/people/{one_of_them['id']}").status_code == 204


def session_of(who, data_set: str) -> str:
    answer = who.http.post("/v1/sessions", json={"data_set_id": data_set})
    assert answer.status_code == 201, answer.text
    return answer.json()["session_id"]


def runs(api, session: str) -> bool:  # noqa: F811
    return bool(api.redis.exists(f"diaphane:session:{session}"))


def make_link(owner, data_set: str, hours: int = 24) -> dict:
    answer = owner.http.post(f"/v1/data-sets/{data_set}/links", json={"hours": hours})
    assert answer.status_code == 201, answer.text
    return answer.json()


def visit(api, key: str | None = None, **what: str) -> httpx.Response:  # noqa: F811
    return client(api).post("/v1/visits", json={"key": key or secrets.token_hex(32), **what})


def titles(who: httpx.Client, **question: str) -> list[str]:
    answer = who.get("/v1/gallery", params={"limit": 100, **question})
    assert answer.status_code == 200, answer.text
    return [item["title"] for item in answer.json()["items"]]


def sample(api, title: str) -> str:  # noqa: F811
    made = str(uuid.uuid4())
    api.psql("""INSERT INTO data_sets (id, title, state, is_sample, visibility, published_at, anonymised_at)
                VALUES (%s, %s, 'uploading', true, 'public', now(), now())""", made, title)
    make_ready(api, made)
    return made


def test_only_the_owner_can_edit_the_description(api, one, other):  # noqa: F811
    made = ready(api, one, "Knee")
    changed = one.http.patch(f"/v1/data-sets/{made}", json={"description": "After the fall.\nLeft.", "body_part": "leg"})
    assert changed.status_code == 200
    assert (changed.json()["title"], changed.json()["description"], changed.json()["body_part"]) == (
        "Knee", "After the fall.\nLeft.", "leg")
    assert one.http.patch(f"/v1/data-sets/{made}", json={"title": "My knee", "body_part": None}).json()["body_part"] is None
    problem(other.http.patch(f"/v1/data-sets/{made}", json={"title": "x"}), 404, "not-found")
    share(one, made, other.email, "save")
    problem(other.http.patch(f"/v1/data-sets/{made}", json={"title": "x"}), 403, "forbidden")
    assert one.http.get(f"/v1/data-sets/{made}").json()["title"] == "My knee"


def test_a_shared_scan_is_visible_until_it_is_unshared(api, one, other, worker):  # noqa: F811
    made = ready(api, one, "Shoulder")
    problem(other.http.get(f"/v1/data-sets/{made}"), 404, "not-found")
    share(one, made, other.email.upper())
    seen = other.http.get(f"/v1/data-sets/{made}").json()
    assert seen["role"] == "shared-view" and not seen["owned"] and seen["shared"] is None
    assert made in [item["id"] for item in other.http.get("/v1/data-sets").json()["items"]]
    assert one.http.get(f"/v1/data-sets/{made}").json()["shared"] == {"people": 1, "links": 0}
    theirs, mine = session_of(other, made), session_of(one, made)
    problem(other.http.post(f"/v1/sessions/{theirs}/links"), 403, "forbidden")   # cannot be shared further
    for method, path in (("GET", "people"), ("GET", "links")):
        problem(other.http.request(method, f"/v1/data-sets/{made}/{path}"), 403, "forbidden")
    problem(other.http.delete(f"/v1/data-sets/{made}"), 403, "forbidden")
    share(one, made, other.email, "save")
    assert [p["may"] for p in people(one, made)] == ["save"]
    assert other.http.get(f"/v1/data-sets/{made}").json()["role"] == "shared-edit"
    unshare(one, made)
    assert not runs(api, theirs) and runs(api, mine)
    problem(other.http.get(f"/v1/data-sets/{made}"), 404, "not-found")
    problem(other.http.post("/v1/sessions", json={"data_set_id": made}), 404, "not-found")


def test_an_invitation_does_not_reveal_whether_the_address_has_an_account(api, one, other):  # noqa: F811
    made = ready(api, one, "Wrist")
    stranger = f"later-{uuid.uuid4().hex[:8]}@example.org"
    for email in (stranger, other.email):
        share(one, made, email)
    shown = people(one, made)
    assert {p["email"] for p in shown} == {stranger, other.email}
    assert {frozenset(p) for p in shown} == {frozenset({"id", "email", "may", "slices", "downloads", "created_at"})}
    mails = api.wait_until(lambda: api.mails(stranger), what="the invitation")
    text = mails[-1].get_content()
    assert "Wrist" not in text and f"{api.url}/scans" in text
    assert text.startswith(f"{one.email} shared a scan with you on Diaphane.")
    from api_client import Person

    late = Person(api, stranger)
    forget_attempts(api)
    late.sign_up().sign_in()
    assert late.http.get(f"/v1/data-sets/{made}").json()["role"] == "shared-view"
    # It belongs to that account now, not to the address.
    api.psql("UPDATE users SET email_key = %s WHERE email_key = %s", f"moved-{stranger}", stranger)
    assert late.http.get(f"/v1/data-sets/{made}").status_code == 200
    problem(one.http.post(f"/v1/data-sets/{made}/people", json={"email": one.email, "may": "view"}), 422, "invalid")
    problem(one.http.post(f"/v1/data-sets/{made}/people", json={"email": "nobody", "may": "view"}), 422, "invalid")


@pytest.mark.parametrize("name", ["Your account ends. Go: http://evil.ex/x", "evil.example", "me@example.org", "Hello! Click",
                                  'Diaphane" says', "\u201cDiaphane\u201d", "evil\u3002example"])
def test_a_misleading_public_name_is_refused(one, name):  # noqa: F811
    problem(one.http.patch("/v1/me/public-name", json={"public_name": name}), 422, "invalid")


def test_an_invitation_names_the_sender_and_their_confirmed_address(api):  # noqa: F811
    one = person(api)
    made = ready(api, one)
    assert one.http.patch("/v1/me/public-name", json={"public_name": " Ann\u202e  O\u2019Hill\u200b "}).status_code == 204
    assert one.http.get("/v1/me/public-name").json() == {"public_name": "Ann O\u2019Hill"}
    # A name that was chosen before names were validated is not shown.
    for kept, first in (("Ann O\u2019Hill", f"Ann O\u2019Hill ({one.email})"), ("Pay at evil.ex/x", one.email)):
        api.psql("UPDATE users SET public_name = %s WHERE id = %s", kept, one.id)
        stranger = f"stranger-{uuid.uuid4().hex[:8]}@example.org"
        share(one, made, stranger)
        [mail] = api.wait_until(lambda address=stranger: api.mails(address), what="the invitation")
        assert mail.get_content().splitlines()[0] == f"{first} shared a scan with you on Diaphane."
        assert mail["Subject"].startswith("A scan was shared with you on Diaphane / ")
    api.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", made)
    assert publish(one, made).json()["owner_name"] == ""


def test_shares_of_a_disabled_account_are_hidden_until_it_is_enabled(api, worker):  # noqa: F811
    owner, friend, other = person(api), person(api), person(api)
    admin = person(api).becomes_administrator()
    public, private = ready(api, owner, "Public", anonymised=True), ready(api, owner, "Private")
    assert publish(owner, public).status_code == 200
    share(owner, private, friend.email)
    token = make_link(owner, private)["token"]
    foreign = ready(api, other, "Foreign", anonymised=True)
    assert publish(other, foreign).status_code == 200
    scene = CONTRACT.spec["components"]["schemas"]["Scene"]["example"]
    preset = owner.http.post(f"/v1/data-sets/{foreign}/presets", json={"name": "Mine", "scene": scene}).json()["id"]

    key = secrets.token_hex(32)   # one visitor who takes one slot

    def visit() -> httpx.Response:
        return client(api).post("/v1/visits", json={"key": key, "token": token})

    def answers() -> list[int]:
        return [friend.http.get(f"/v1/data-sets/{private}").status_code,
                friend.http.post("/v1/sessions", json={"data_set_id": private}).status_code,
                other.http.get(f"/v1/data-sets/{public}").status_code,
                other.http.get(f"/v1/data-sets/{public}/presets").status_code,
                client(api).post("/v1/follow", json={"token": token}).status_code, visit().status_code,
                other.http.get(f"/v1/presets/{preset}").status_code]

    def listed() -> list[bool]:
        return [public in {item["id"] for item in other.http.get("/v1/gallery", params={"q": "Public", "limit": 100}).json()["items"]},
                private in {item["id"] for item in friend.http.get("/v1/data-sets").json()["items"]},
                preset in {item["id"] for item in other.http.get(f"/v1/data-sets/{foreign}/presets").json()["items"]}]

    before = answers()
    assert set(before) <= {200, 201} and listed() == [True] * 3
    running = [session_of(friend, private), session_of(other, public), visit().json()["session_id"]]
    elsewhere = session_of(other, foreign)
    assert all(runs(api, each) for each in running)
    path = f"/v1/admin/users/{owner.id}"
    assert admin.http.patch(path, json={"disabled": True}).status_code == 200
    assert [runs(api, each) for each in [*running, elsewhere]] == [False, False, False, True]
    assert answers() == [404] * 7 and listed() == [False] * 3
    problem(friend.http.post(f"/v1/sessions/{running[0]}/tickets"), 404, "not-found")
    assert admin.http.patch(path, json={"disabled": False}).status_code == 200
    assert answers() == before and listed() == [True] * 3


def test_only_anonymised_scans_can_be_published(api, one):  # noqa: F811
    made = ready(api, one, "Not yet")
    problem(publish(one, made), 409, "not-anonymised")
    assert not one.http.get(f"/v1/data-sets/{made}").json()["is_public"]
    problem(publish(one, one.data_set(100)["data_set"]["id"]), 409, "not-ready")


def test_a_public_scan_is_in_the_gallery(api, one, other):  # noqa: F811
    word = uuid.uuid4().hex[:8]
    made = {}
    for title, part in (("Broken shoulder", "arm"), ("Shoulders and neck", "neck"), ("Quiet knee", "leg")):
        made[title] = ready(api, one, f"{title} {word}", anonymised=True)
        one.http.patch(f"/v1/data-sets/{made[title]}", json={"body_part": part})
        assert publish(one, made[title]).json()["is_public"]
    one.http.patch(f"/v1/data-sets/{made['Quiet knee']}", json={"description": "near the shoulder, not"})
    assert one.http.patch("/v1/me/public-name", json={"public_name": "Ann of the hills"}).status_code == 204
    found = [t.removesuffix(f" {word}") for t in titles(other.http, q=word)]
    assert found == ["Quiet knee", "Shoulders and neck", "Broken shoulder"]
    assert len(titles(other.http, q=f"should {word}")) == 3
    assert [t[:6] for t in titles(other.http, q=f"KNEE, {word}!")] == ["Quiet "]
    assert [t[:6] for t in titles(other.http, q=word, body_part="arm")] == ["Broken"]
    assert titles(other.http, q=word, modality="MR") == []
    assert titles(other.http, q="'; DROP TABLE users; --") == [] and titles(other.http, q="!&|") == []
    assert titles(client(api), q=word) == []   # visitors see samples only
    shown = other.http.get("/v1/gallery", params={"q": word}).json()["items"]
    assert {item["owner_name"] for item in shown} == {"Ann of the hills"} and {item["role"] for item in shown} == {"other"}
    assert one.email not in str(shown)
    page = other.http.get("/v1/gallery", params={"q": word, "limit": 2}).json()
    rest = other.http.get("/v1/gallery", params={"q": word, "limit": 2, "cursor": page["next_cursor"]}).json()
    assert [len(page["items"]), len(rest["items"])] == [2, 1] and rest["next_cursor"] is None
    # The list contains only the user's own data sets and those shared with them.
    assert not {item["id"] for item in other.http.get("/v1/data-sets").json()["items"]} & set(made.values())
    problem(other.http.get("/v1/gallery", params={"body_part": "soul"}), 422, "invalid")
    problem(one.http.patch("/v1/me/public-name", json={"public_name": "me@example.org"}), 422, "invalid")


def test_making_a_scan_private_ends_only_the_sessions_of_others(api, one, other, worker):  # noqa: F811
    made = ready(api, one, anonymised=True)
    publish(one, made)
    third = person(api)
    share(one, made, third.email)
    theirs, mine, friends = session_of(other, made), session_of(one, made), session_of(third, made)
    make_private(one, made)
    assert [runs(api, s) for s in (theirs, mine, friends)] == [False, True, True]
    problem(other.http.get(f"/v1/data-sets/{made}"), 404, "not-found")


def test_a_link_gives_access_until_it_is_disabled(api, one, other, worker):  # noqa: F811
    made = ready(api, one, "By link")
    link = make_link(one, made)
    assert link["path"] == f"/shared#{link['token']}"
    assert link["token"] not in str(api.psql("SELECT * FROM data_set_links"))
    assert link["token"] not in one.http.get(f"/v1/data-sets/{made}/links").text
    leads = client(api).post("/v1/follow", json={"token": link["token"]}).json()
    assert leads["data_set"]["title"] == "By link" and leads["data_set"]["role"] == "shared-view"
    key = secrets.token_hex(32)
    first = visit(api, key, token=link["token"]).json()
    again = visit(api, key, token=link["token"]).json()
    assert first["session_id"] == again["session_id"] and first["stream_url"] != again["stream_url"]
    second = visit(api, token=link["token"]).json()
    by_another = visit(api, token=make_link(one, made)["token"]).json()
    mine = session_of(one, made)
    assert one.http.delete(f"/v1/data-sets/{made}/links/{link['id']}").status_code == 204
    assert not runs(api, first["session_id"]) and not runs(api, second["session_id"])
    assert runs(api, by_another["session_id"]) and runs(api, mine)
    problem(visit(api, key, token=link["token"]), 404, "not-found")
    problem(client(api).post("/v1/follow", json={"token": link["token"]}), 404, "not-found")
    problem(other.http.delete(f"/v1/data-sets/{made}/links/{link['id']}"), 404, "not-found")


def test_shares_and_views_are_in_the_audit_log(api, one, other, worker):  # noqa: F811
    made = ready(api, one, anonymised=True)
    share(one, made, other.email, "save")
    unshare(one, made)
    link = make_link(one, made)
    visit(api, token=link["token"])
    visit(api, token=link["token"])    # of the same hour
    assert one.http.delete(f"/v1/data-sets/{made}/links/{link['id']}").status_code == 204
    assert publish(one, made).status_code == 200
    session_of(one, made)
    session_of(other, made)
    make_private(one, made)
    mine = session_of(one, made)
    live = one.http.post(f"/v1/sessions/{mine}/links", json={"slices": True})
    assert live.status_code == 201, live.text
    assert client(api).post("/v1/join", json={"token": live.json()["token"], "key": secrets.token_hex(32)}).status_code == 201
    assert one.http.delete(f"/v1/sessions/{mine}/links").status_code == 204
    entries = api.psql("SELECT action, actor_id::text, details FROM audit_log WHERE subject_id = %s ORDER BY id", made)
    assert [(action, actor) for action, actor, _ in entries] == [
        ("data-set.shared", one.id), ("data-set.unshared", one.id), ("data-set.link-made", one.id), ("data-set.looked-at", None),
        ("data-set.link-ended", one.id), ("data-set.published", one.id), ("data-set.looked-at", one.id), ("data-set.looked-at", other.id),
        ("data-set.withdrawn", one.id), ("data-set.live-link-made", one.id), ("data-set.looked-at", None), ("data-set.live-links-ended", one.id)]
    details = [given for _, _, given in entries]
    assert [(given["slices"], given.get("downloads")) for given in details if "slices" in given] == [(1, 1), (0, 0), (0, 0), (1, None)]
    assert details[0]["may"] == "save" and details[3] == {"by": "link", "link": link["id"]}
    assert [given["by"] for given in details if "by" in given] == ["link", "owner", "gallery", "live-link"]
    assert other.email not in str(details)


def test_visits_end_when_their_link_expires(api, one, worker):  # noqa: F811
    made = ready(api, one)
    link = make_link(one, made, hours=1)
    here = visit(api, token=link["token"]).json()
    api.psql("UPDATE data_set_links SET expires_at = now() - interval '1 second' WHERE id = %s", link["id"])
    api.psql("UPDATE visits SET expires_at = now() - interval '1 second' WHERE session_id = %s", here["session_id"])
    problem(visit(api, token=link["token"]), 404, "not-found")
    api.wait_until(lambda: not runs(api, here["session_id"]), what="the end of the visit")
    api.wait_until(lambda: not api.psql("SELECT 1 FROM data_set_links WHERE id = %s", link["id"]), what="the link's end")
    for hours in (0, 2161):
        problem(one.http.post(f"/v1/data-sets/{made}/links", json={"hours": hours}), 422, "invalid")


def test_links_and_shares_per_scan_are_limited(api, one):  # noqa: F811
    made = ready(api, one)
    for _ in range(10):
        make_link(one, made)
    problem(one.http.post(f"/v1/data-sets/{made}/links", json={"hours": 1}), 429, "too-many")
    api.psql("""INSERT INTO data_set_people (id, data_set_id, email_key, may_save, created_at)
                SELECT gen_random_uuid(), %s, 'p' || n || '@example.org', false, now() FROM generate_series(1, 50) n""", made)
    problem(one.http.post(f"/v1/data-sets/{made}/people", json={"email": "51@example.org", "may": "view"}), 429, "too-many")


def test_only_samples_can_be_viewed_without_an_account(api, one, worker):  # noqa: F811
    shown = sample(api, f"A sample {uuid.uuid4().hex[:6]}")
    nobody = client(api)
    assert [item["id"] for item in nobody.get("/v1/gallery").json()["items"] if item["id"] == shown]
    problem(nobody.get(f"/v1/data-sets/{shown}/thumbnails/bone"), 503, "no-worker")
    here = visit(api, data_set_id=shown)
    assert here.status_code == 201 and runs(api, here.json()["session_id"])
    public = ready(api, one, anonymised=True)
    publish(one, public)
    problem(visit(api, data_set_id=public), 404, "not-found")
    problem(nobody.get(f"/v1/data-sets/{public}/thumbnails/bone"), 404, "not-found")
    problem(visit(api, data_set_id=ready(api, one)), 404, "not-found")
    problem(visit(api), 422, "invalid")
    problem(visit(api, token="0" * 64, data_set_id=shown), 422, "invalid")
    # Limited in time and number.
    api.psql("UPDATE visits SET expires_at = now() WHERE session_id = %s", here.json()["session_id"])
    api.wait_until(lambda: not runs(api, here.json()["session_id"]), what="the end of the visit")
    forget_attempts(api)
    api.psql("DELETE FROM visits")
    api.redis.delete("diaphane:visitors")  # left over from earlier tests
    for _ in range(8):  # half of the visitors' quarter of 64 slots, for one address
        assert visit(api, data_set_id=shown).status_code == 201
    problem(visit(api, data_set_id=shown), 503, "busy")
    assert api.psql("SELECT count(*) FROM visits")[0][0] == 8, "a refused visit is not counted"
    answers = [visit(api, data_set_id=shown).status_code for _ in range(24)]
    assert answers[-3:] == [429] * 3 and answers[0] == 503
    assert one.http.post("/v1/sessions", json={"data_set_id": public}).status_code == 201, "account holders notice nothing"
    forget_attempts(api)
    api.psql("DELETE FROM visits")
    api.psql("""INSERT INTO visits (session_id, data_set_id, expires_at, address_hash)
                SELECT gen_random_uuid(), %s, now() + interval '1 hour', 'elsewhere' FROM generate_series(1, 256)""", shown)
    problem(visit(api, data_set_id=shown), 503, "busy")
    api.psql("DELETE FROM visits")
    api.redis.delete("diaphane:visitors")
    api.psql("DELETE FROM data_sets WHERE id = %s", shown)


def test_a_scan_that_was_taken_down_is_visible_only_to_its_owner(api, one, other, worker):  # noqa: F811
    boss = person(api)
    made = ready(api, one, "Reported", anonymised=True)
    publish(one, made)
    link = make_link(one, made)
    share(one, made, other.email)
    theirs, mine = session_of(other, made), session_of(one, made)
    came = visit(api, token=link["token"]).json()["session_id"]
    words = {"reason": "identifies", "words": "The name is burnt in."}
    for _ in range(2):
        assert other.http.post(f"/v1/data-sets/{made}/reports", json=words).status_code == 204
    problem(one.http.post(f"/v1/data-sets/{made}/reports", json=words), 403, "forbidden")
    for who in (one, other, boss):
        problem(who.http.get("/v1/reports"), 403, "forbidden")
        problem(who.http.get("/v1/report-count"), 403, "forbidden")
        problem(who.http.post(f"/v1/data-sets/{made}/take-down", json={"reason": "x"}), 403, "forbidden")
    boss.becomes_administrator()
    counted = boss.http.get("/v1/report-count").json()["open"]
    assert counted == len(boss.http.get("/v1/reports").json()["items"]) > 0
    [report] = [r for r in boss.http.get("/v1/reports").json()["items"] if r["data_set_id"] == made]
    assert report["reason"] == "identifies" and report["title"] == "Reported" and other.email not in str(report)
    answer = boss.http.post(f"/v1/data-sets/{made}/take-down", json={"reason": "A name is burnt into the picture."})
    assert answer.status_code == 204
    assert [runs(api, s) for s in (theirs, came, mine)] == [False, False, True]
    problem(other.http.get(f"/v1/data-sets/{made}"), 404, "not-found")
    problem(client(api).post("/v1/follow", json={"token": link["token"]}), 404, "not-found")
    shown = one.http.get(f"/v1/data-sets/{made}").json()
    assert shown["taken_down"] == {"reason": "A name is burnt into the picture."} and not shown["is_public"]
    problem(publish(one, made), 403, "forbidden")
    problem(one.http.post(f"/v1/data-sets/{made}/links", json={"hours": 1}), 403, "forbidden")
    assert [r for r in boss.http.get("/v1/reports").json()["items"] if r["data_set_id"] == made] == []
    assert boss.http.get("/v1/report-count").json() == {"open": counted - 1}
    [entry] = api.psql("SELECT actor, action, subject, details::text FROM audit_log WHERE subject_id = %s AND action = 'data-set.taken-down'", made)
    assert entry[:3] == ("administrator", "data-set.taken-down", "data_set") and "burnt" not in entry[3]
    assert boss.http.delete(f"/v1/data-sets/{made}/take-down").status_code == 204
    problem(boss.http.get(f"/v1/data-sets/{made}"), 404, "not-found")   # private again, so administrators cannot see it
    assert publish(one, made).status_code == 200


def test_the_same_idempotency_key_returns_the_same_link_and_token(api, one, other):  # noqa: F811
    from api_client import PASSWORD, Person

    made = ready(api, one)
    ask = lambda who, key, data_set=made, hours=1: who.http.post(  # noqa: E731
        f"/v1/data-sets/{data_set}/links", json={"hours": hours}, headers={"Idempotency-Key": key})
    first = ask(one, "k1")
    assert first.status_code == 201 and ask(one, "k1").json() == first.json()
    assert len(one.http.get(f"/v1/data-sets/{made}/links").json()["items"]) == 1
    second = ask(one, "k2").json()
    tokens = {first.json()["token"], second["token"], make_link(one, made)["token"], make_link(one, made)["token"]}
    assert len(tokens) == 4
    problem(ask(one, "k1", hours=2), 422, "idempotency-key-reused")
    problem(ask(one, "k1", data_set=ready(api, one)), 422, "idempotency-key-reused")
    # Another browser cannot know the token, because it derives from the cookie.
    elsewhere = Person(api, one.email)
    forget_attempts(api)
    assert elsewhere.http.post("/v1/sign-in", json={"email": one.email, "password": PASSWORD}).status_code == 200
    elsewhere.http.headers["X-CSRF-Token"] = elsewhere.http.get("/v1/me").json()["csrf_token"]
    problem(ask(elsewhere, "k1"), 409, "conflict")
    assert client(api).post("/v1/follow", json={"token": first.json()["token"]}).status_code == 200
    # Once ended, it does not come back, even if the key was forgotten meanwhile.
    assert one.http.delete(f"/v1/data-sets/{made}/links/{second['id']}").status_code == 204
    problem(ask(one, "k2"), 409, "conflict")
    api.psql("DELETE FROM idempotency_keys WHERE key = 'k1'")
    problem(ask(one, "k1"), 409, "conflict")


def test_the_same_idempotency_key_creates_one_session_link(api, one, worker):  # noqa: F811
    session = session_of(one, ready(api, one))
    ask = lambda key: one.http.post(f"/v1/sessions/{session}/links", headers={"Idempotency-Key": key})  # noqa: E731
    first = ask("k")
    assert first.status_code == 201
    for _ in range(12):   # one link, of at most 8
        assert ask("k").json() == first.json()
    assert ask("another").json() != first.json()
    assert one.http.delete(f"/v1/sessions/{session}/links").status_code == 204
    problem(ask("k"), 409, "conflict")
    assert ask("anew").status_code == 201
