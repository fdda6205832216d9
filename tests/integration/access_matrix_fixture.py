"""The objects of test_access_matrix.py: users of every role, and one object of each kind that belongs to the owner. A new operation
needs a row in access_matrix.txt, a method of World for each new path parameter, and a body in `bodies` if one made of the schema's
required fields is not enough."""

from __future__ import annotations

import hashlib
import uuid
from pathlib import Path
from typing import Any, Callable

import answering_worker
import httpx
from api_client import CONTRACT, PASSWORD, Person, add_worker, client, make_ready, put_thumbnail
from cut_helpers import KEEP, store
from harness import TestStack
from panoramas import hdr
from seeds import stored, write_person
from study_helpers import create, definition, picture, step

ROLES = ("nobody", "unverified", "other", "view", "edit", "owner", "administrator")


#: The only worker.
WORKER = "who-may"


def able_to_render(stack: TestStack) -> None:
    """Gives the worker enough slots for a whole list of attacks, for longer than it lasts."""
    add_worker(stack, WORKER, slots=100_000, seconds=36_000, address=answering_worker.address())


def free_slots(stack: TestStack) -> None:
    """Frees the slots that sessions have taken (place.lua)."""
    stack.redis.delete(f"diaphane:worker:{WORKER}:sessions")


class World:
    """The objects of one request. Everything is new, so that requests do not affect each other."""

    def __init__(self, stack: TestStack):
        self.stack = stack
        self.people: dict[str, Person] = {}
        self.data_set = ""
        self.second = ""
        self.saved = ""
        self.study = ""
        self.stored_hash = ""
        self.taken_down = False
        #: A word in the scan's texts, for tests that search for it.
        self.word = ""
        #: The user whose presets, sessions and recordings are requested. The scan is the owner's.
        self.maker = "owner"
        self.joined = ""
        self.linked: dict = {}

    # Users

    def someone(self, role: str) -> Person:
        if role not in self.people:
            self.people[role] = self._make(role)
        return self.people[role]

    def _make(self, role: str) -> Person:
        one = Person(self.stack)
        if role == "nobody":
            return one
        one_id, token, csrf = write_person(self.stack.psql, one.email, role, consents=True)
        one.http.cookies.set("diaphane", token)
        one.http.headers["X-CSRF-Token"] = csrf
        one.known_id = one_id
        if role == "administrator":
            one.becomes_administrator()
        return one

    @property
    def owner(self) -> Person:
        return self.someone("owner")

    @property
    def who_made(self) -> Person:
        self.data_set_id()
        return self.someone(self.maker)

    # Path parameters

    def data_set_id(self) -> str:
        if not self.data_set:
            self.data_set = self.owner.data_set(10)["data_set"]["id"]
            make_ready(self.stack, self.data_set)
            self.share(self.data_set)
        return self.data_set

    def second_data_set_id(self) -> str:
        """Another scan of the owner, shared with the same people."""
        if not self.second:
            self.data_set_id()
            self.second = self.owner.data_set(10)["data_set"]["id"]
            make_ready(self.stack, self.second)
            self.share(self.second)
        return self.second

    def align(self) -> None:
        """Aligns both scans, as ingestd does."""
        self.stack.psql("""INSERT INTO alignments (fixed, moving, state, matrix, residual_mm, overlap)
                           VALUES (%s, %s, 'ready', '{1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1}', 1, 1) ON CONFLICT DO NOTHING""",
                        self.data_set_id(), self.second_data_set_id())

    def volume_hash(self) -> str:
        self.stored_hash = self.stored_hash or store(self.stack, self.data_set_id())
        return self.stored_hash

    def share(self, data_set: str) -> None:
        """Shares it with `view` and `edit`."""
        for role in ("view", "edit"):
            given = {"email": self.someone(role).email, "may": "view" if role == "view" else "save"}
            answer = self.owner.http.post(f"/v1/data-sets/{data_set}/people", json=given)
            assert answer.status_code == 204, answer.text

    def publish(self) -> None:
        data_set = self.data_set_id()
        # Long ago, so that its pictures are newer.
        self.stack.psql("UPDATE data_sets SET anonymised_at = now() - interval '1 hour' WHERE id = %s", data_set)
        answer = self.owner.http.post(f"/v1/data-sets/{data_set}/visibility", json={"visibility": "public"})
        assert answer.status_code == 200, answer.text

    def take_down(self) -> None:
        if self.taken_down:
            return
        self.taken_down = True
        self.publish()
        answer = self.someone("administrator").http.post(f"/v1/data-sets/{self.data_set}/take-down", json={"reason": "A name."})
        assert answer.status_code == 204, answer.text

    def make_sample(self) -> None:
        """Makes it a sample that the operator uploaded: without an owner, visible to everyone."""
        self.stack.psql("UPDATE data_sets SET owner_id = NULL, is_sample = true, visibility = 'public', published_at = now(), anonymised_at = now() - interval '1 hour' WHERE id = %s", self.data_set_id())

    def person_id(self) -> str:
        return self.owner.http.get(f"/v1/data-sets/{self.data_set_id()}/people").json()["items"][0]["id"]

    def link(self) -> dict:
        if not self.linked:
            self.linked = self.owner.http.post(f"/v1/data-sets/{self.data_set_id()}/links", json={"hours": 1}).json()
        return self.linked

    def link_id(self) -> str:
        self.link()
        return self.owner.http.get(f"/v1/data-sets/{self.data_set_id()}/links").json()["items"][0]["id"]

    def preset_id(self) -> str:
        if not self.saved:
            self.saved = self.who_made.http.post(f"/v1/data-sets/{self.data_set_id()}/presets", json={"name": "a", "scene": SCENE}).json()["id"]
        return self.saved

    def picture_preset(self) -> None:
        """Creates its picture."""
        put_picture(self.stack, self.preset_id())

    def report_id(self) -> str:
        self.publish()
        self.someone("other").http.post(f"/v1/data-sets/{self.data_set}/reports", json={"reason": "other"})
        return self.stack.psql("SELECT id::text FROM reports WHERE data_set_id = %s", self.data_set)[0][0]

    def end_links(self) -> None:
        """Ends all links, whatever they lead to."""
        for link in self.owner.http.get(f"/v1/data-sets/{self.data_set_id()}/links").json()["items"]:
            assert self.owner.http.delete(f"/v1/data-sets/{self.data_set}/links/{link['id']}").status_code == 204
        if self.joined:
            assert self.owner.http.delete(f"/v1/sessions/{self.joined}/links").status_code == 204

    def unshare(self) -> None:
        for one in self.owner.http.get(f"/v1/data-sets/{self.data_set_id()}/people").json()["items"]:
            assert self.owner.http.delete(f"/v1/data-sets/{self.data_set}/people/{one['id']}").status_code == 204

    def cut(self) -> None:
        """Requests its anonymisation as its owner."""
        if self.stored_hash:
            return
        keep = {"keep": KEEP, "volume_hash": self.volume_hash(), "confirm": "this cannot be undone"}
        assert self.owner.http.post(f"/v1/data-sets/{self.data_set}/anonymise", json=keep).status_code == 202

    def joining(self) -> str:
        """Returns the token of a link to the owner's session."""
        self.joined = self.session_id()
        return self.owner.http.post(f"/v1/sessions/{self.joined}/links").json()["token"]

    def upload_id(self) -> str:
        """Returns the upload of a scan that is shared before it is complete."""
        made = self.owner.data_set(10)["data_set"]["id"]
        self.share(made)
        return made

    def session_id(self) -> str:
        able_to_render(self.stack)
        answer = self.who_made.http.post("/v1/sessions", json={"data_set_id": self.data_set_id()})
        assert answer.status_code == 201, answer.text
        return answer.json()["session_id"]

    def environment_id(self) -> str:
        answer = self.who_made.http.post("/v1/environments", params={"name": "Sky"}, content=hdr(4, 2, lambda x, y: (1, 1, 1)))
        assert answer.status_code == 201, answer.text
        return answer.json()["id"]

    def annotation_id(self) -> str:
        answer = self.who_made.http.post(f"/v1/data-sets/{self.data_set_id()}/annotations", json=ANNOTATIONS)
        assert answer.status_code == 201, answer.text
        return answer.json()["id"]

    def give_archive_access(self) -> None:
        self.stack.psql("UPDATE users SET archive_access = true WHERE id = %s", self.owner.known_id)

    def archive(self) -> str:
        """Returns an archive that does not exist, because the stack is connected to none."""
        self.give_archive_access()
        return "radiology"

    def fetch_id(self) -> str:
        return str(uuid.uuid4())

    def make_researcher(self) -> None:
        self.stack.psql("UPDATE users SET is_researcher = true WHERE id = %s", self.owner.known_id)

    def study_id(self) -> str:
        """Returns a study of the owner with the picture of picture_id()."""
        self.make_researcher()
        if not self.study:
            pictures = [{"id": self.picture_id(), "comfort": -1}, {"id": "more", "comfort": 1}]
            self.study = create(self.owner, definition(step("order", pictures=pictures)))
            for one in pictures:
                put = self.owner.http.put(f"/v1/studies/{self.study}/pictures/{one['id']}", content=picture())
                assert put.status_code == 204, put.text
        return self.study

    def picture_id(self) -> str:
        return "less"

    def recording_id(self) -> str:
        answer = self.who_made.http.post("/v1/recordings", json=RECORDING)
        assert answer.status_code == 201, answer.text
        return answer.json()["id"]

    def browser_session_id(self) -> str:
        return self.who_made.http.get("/v1/me/browser-sessions").json()["items"][0]["id"]

    def token_id(self) -> str:
        return self.who_made.http.post("/v1/me/tokens", json=API_TOKEN).json()["id"]

    def user_id(self) -> str:
        return self.owner.known_id

    def preset(self) -> str:
        put_thumbnail(self.stack, self.data_set_id())
        return "bone"

    # Preconditions of requests

    def token_for(self, one: Person, purpose: str) -> str:
        """Returns the token as in a mail."""
        token = hashlib.sha256(uuid.uuid4().bytes).hexdigest()
        new_email = f"new-{uuid.uuid4().hex}@example.org" if purpose == "change" else None
        self.stack.psql("""INSERT INTO email_tokens (token_hash, user_id, purpose, expires_at, new_email)
                           VALUES (%s, %s, %s, now() + interval '1 hour', %s)""",
                        stored(token), one.known_id, purpose, new_email)
        return token

    def export_of(self, one: Person, state: str) -> None:
        """Gives `one` an existing export."""
        if not hasattr(one, "known_id"):
            return
        export = str(uuid.uuid4())
        self.stack.psql("""INSERT INTO exports (id, user_id, state, bytes, created_at, expires_at)
                           VALUES (%s, %s, %s, 3, now(), now() + interval '1 day')
                           ON CONFLICT (user_id) DO UPDATE SET id = EXCLUDED.id, state = EXCLUDED.state""", export, one.known_id, state)
        put_export_file(self.stack, f"{export}.zip", b"zip")

    def no_scan_export_of(self, one: Person) -> None:
        self.stack.psql("DELETE FROM scan_exports WHERE user_id = %s", getattr(one, "known_id", None))

    def scan_export_of(self, one: Person, state: str) -> None:
        """Gives this user an export of the scan, as ingestd leaves it."""
        if not hasattr(one, "known_id"):
            return
        export = str(uuid.uuid4())
        self.no_scan_export_of(one)
        self.stack.psql("""INSERT INTO scan_exports (id, user_id, data_set_id, format, state, bytes, created_at, expires_at)
                           VALUES (%s, %s, %s, 'nifti', %s, 3, now(), now() + interval '1 day')""",
                        export, one.known_id, self.data_set_id(), state)
        put_export_file(self.stack, f"{export}.scan", b"nii")


def put_export_file(stack: TestStack, name: str, content: bytes) -> None:
    """Stores the file of an export as api and ingestd do."""
    folder = stack.data_dir / "cache" / "exports"
    folder.mkdir(exist_ok=True)
    (folder / name).write_bytes(content)
    for path in (folder / name, folder):
        stack.stack.run_as.own(path)


def put_picture(stack: TestStack, preset: str, content: bytes = b"\xff\xd8\xff") -> Path:
    """Stores a preset's picture as api does after a worker rendered it."""
    file = stack.data_dir / "cache" / "presets" / preset / "picture.jpg"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(content)
    for path in (file, file.parent, file.parent.parent):
        stack.stack.run_as.own(path)
    stack.psql("UPDATE presets SET pictured_at = now() WHERE id = %s", preset)
    return file


RECORDING = {"format": "diaphane-interaction", "version": 1, "viewport": {"width": 64, "height": 64},
             "events": [{"at_ms": 0, "scene": {}}]}
SCENE = CONTRACT.spec["components"]["schemas"]["Scene"]["example"]
ANNOTATIONS = {"name": "Before surgery", "content": CONTRACT.spec["components"]["schemas"]["Annotations"]["example"]}
NEW_PASSWORD = "another long and quiet one"

API_TOKEN = {"name": "Notebook", "scopes": ["read"], "days": 1, "password": PASSWORD}

#: Bodies by operation: (world, requesting user) -> body.
bodies: dict[str, Callable[[World, Person], Any]] = {
    "signUp": lambda world, who: {"email": f"new-{uuid.uuid4().hex}@example.org", "consent": True},
    "verifyAccount": lambda world, who: {"token": world.token_for(world.someone("unverified"), "verify"),
                                         "password": NEW_PASSWORD},
    "signIn": lambda world, who: {"email": world.owner.email, "password": PASSWORD},
    "requestPasswordReset": lambda world, who: {"email": f"nobody-{uuid.uuid4().hex}@example.org"},
    "resetPassword": lambda world, who: {"token": world.token_for(world.owner, "reset"), "password": NEW_PASSWORD},
    "confirmEmailChange": lambda world, who: {"token": world.token_for(world.owner, "change")},
    "giveConsent": lambda world, who: {"version": who.http.get("/v1/me").json().get("consent", {}).get("version", "none")},
    "changePassword": lambda world, who: {"current": PASSWORD, "password": NEW_PASSWORD},
    "requestEmailChange": lambda world, who: {"email": f"new-{uuid.uuid4().hex}@example.org", "password": PASSWORD},
    "beginSecondFactor": lambda world, who: {"password": PASSWORD},
    "confirmSecondFactor": lambda world, who: {"code": who.device.code() if who.device else "000000"},
    "renewRecoveryCodes": lambda world, who: {"password": PASSWORD, "code": who.device.code() if who.device else "000000"},
    "removeSecondFactor": lambda world, who: {"password": PASSWORD, "code": who.device.code() if who.device else "000000"},
    "createApiToken": lambda world, who: {**API_TOKEN, **({"code": who.device.code()} if who.device else {})},
    "deleteAccount": lambda world, who: {"password": PASSWORD, **({"code": who.device.code()} if who.device else {})},
    "createDataSet": lambda world, who: {"bytes": 10},
    "searchArchive": lambda world, who: {"patient_name": "Phantasia"},
    "listArchiveSeries": lambda world, who: {"study": "1.2"},
    "startFetch": lambda world, who: {"study": "1.2", "series": "1.2.3"},
    "recordReceipt": lambda world, who: {"via": "stow", "study": "1.2"},
    "changeUser": lambda world, who: {"quota_bytes": 1000},
    "createSession": lambda world, who: {"data_set_id": ready_to_render(world)},
    "renameEnvironment": lambda world, who: {"name": "Park"},
    "createRecording": lambda world, who: RECORDING,
    "anonymise": lambda world, who: {"keep": KEEP, "volume_hash": world.volume_hash(), "confirm": "this cannot be undone"},
    "addLabels": lambda world, who: {"bytes": 10},
    "requestScanExport": lambda world, who: {"format": "stl", "above": 300},
    "describeDataSet": lambda world, who: {"title": "Another"},
    "setVisibility": lambda world, who: {"visibility": "private"},
    "shareWithPerson": lambda world, who: {"email": f"friend-{uuid.uuid4().hex}@example.org", "may": "view"},
    "createDataSetLink": lambda world, who: {"hours": 1},
    "followLink": lambda world, who: {"token": world.link()["token"]},
    "followLinkAnnotations": lambda world, who: {"token": world.link()["token"]},
    "followLinkTour": lambda world, who: {"token": world.link()["token"]},
    "followLinkThumbnail": lambda world, who: {"token": world.link()["token"]},
    "createVisit": lambda world, who: {"token": world.link()["token"], "key": uuid.uuid4().hex * 2},
    "setPublicName": lambda world, who: {"public_name": "A patient"},
    "createPreset": lambda world, who: {"name": "b", "scene": SCENE},
    "changePreset": lambda world, who: {"name": "c"},
    "createAnnotations": lambda world, who: ANNOTATIONS,
    "changeAnnotations": lambda world, who: {"name": "After surgery"},
    "setDefaultPreset": lambda world, who: {"preset_id": world.preset_id()},
    "voteForPreset": lambda world, who: {"value": 1},
    "reportDataSet": lambda world, who: {"reason": "other"},
    "reportPreset": lambda world, who: {"reason": "offensive"},
    "takeDownPreset": lambda world, who: {"reason": "Its name offends."},
    "takeDownDataSet": lambda world, who: {"reason": "A name is on it."},
    **{name: lambda world, who: {"definition": definition()} for name in ("createStudy", "replaceStudy")},
    "setStudyState": lambda world, who: {"state": "open"},
    "previewStudy": lambda world, who: {"key": uuid.uuid4().hex * 2},
    "adoptStudyResults": lambda world, who: {"comfort": True},
    "adoptTour": lambda world, who: {"study_id": world.study_id(), "step": "viewpoint"},
    "getStudyInvitation": lambda world, who: {"token": "0" * 64},
    "joinStudy": lambda world, who: {"token": "0" * 64, "key": "0" * 64, "language": "en", "record": False},
    "answerStudy": lambda world, who: {"key": "0" * 64, "step": "a", "value": {}, "duration_ms": 0, "sequence": 0},
    "getParticipantPicture": lambda world, who: {"key": "0" * 64, "picture": "a"},
    "createStudyVisit": lambda world, who: {"key": "0" * 64, "step": "a"},
    "addStudyRecording": lambda world, who: {"key": "0" * 64, "step": "a", "recording": RECORDING},
    **{name: lambda world, who: {"key": "0" * 64} for name in ("finishStudy", "withdrawFromStudy")},
    "join": lambda world, who: {"token": world.joining(), "key": "0" * 64},
}


def signed_in(who: Person) -> bool:
    return who.http.get("/v1/me").status_code == 200


def begin_second_factor(world: World, who: Person) -> None:
    """Started, but not confirmed."""
    without_second_factor(world, who)
    if signed_in(who):
        who.begins_second_factor()


def with_second_factor(world: World, who: Person) -> None:
    if signed_in(who) and who.device is None:
        who.sets_up_second_factor()


def without_second_factor(world: World, who: Person) -> None:
    """An administrator without a second factor, whose role then grants nothing."""
    if signed_in(who) and who.device is not None:
        who.removes_second_factor()


#: Preconditions by operation.
before: dict[str, Callable[[World, Person], None]] = {
    "beginSecondFactor": without_second_factor,
    "confirmSecondFactor": begin_second_factor,
    "renewRecoveryCodes": with_second_factor,
    "removeSecondFactor": with_second_factor,
    "getExport": lambda world, who: world.export_of(who, "queued"),
    "deleteExport": lambda world, who: world.export_of(who, "ready"),
    "downloadExport": lambda world, who: world.export_of(who, "ready"),
    "requestScanExport": lambda world, who: world.no_scan_export_of(who),
    "getScanExport": lambda world, who: world.scan_export_of(who, "queued"),
    "deleteScanExport": lambda world, who: world.scan_export_of(who, "ready"),
    "downloadScanExport": lambda world, who: world.scan_export_of(who, "ready"),
    "deleteAlignment": lambda world, who: world.align(),
    "createTicket": lambda world, who: able_to_render(world.stack),
    "createVisit": lambda world, who: able_to_render(world.stack),
    "voteForPreset": lambda world, who: world.publish(),
    "reportDataSet": lambda world, who: world.publish(),
    "takeDownDataSet": lambda world, who: world.publish(),
    "restoreDataSet": lambda world, who: world.take_down(),
    "getPresetThumbnail": lambda world, who: world.picture_preset(),
    "reportPreset": lambda world, who: world.publish(),
    "takeDownPreset": lambda world, who: world.publish(),
    "restorePreset": lambda world, who: world.publish(),
    "listStudies": lambda world, who: world.make_researcher(),
    "createStudy": lambda world, who: world.make_researcher(),
    "listArchives": lambda world, who: world.give_archive_access(),
    "recordReceipt": lambda world, who: world.give_archive_access(),
}


#: Operations that concern a public scan, or one that was, unless stated otherwise.
ABOUT_PUBLIC = ("voteForPreset", "reportDataSet", "takeDownDataSet", "restoreDataSet", "reportPreset")


def disable(world: World, who: Person) -> None:
    world.stack.psql("UPDATE users SET disabled_at = now() WHERE id = %s", getattr(who, "known_id", None))


def made_by_edit(world: World) -> None:
    world.maker = "edit"


#: States in rows of the table, applied last: of the scan, of its links, or of the requesting user.
STATES: dict[str, Callable[[World, Person], None]] = {
    "private": lambda world, who: None,
    "public": lambda world, who: world.publish(),
    "taken-down": lambda world, who: world.take_down(),
    "sample": lambda world, who: world.make_sample(),
    "unshared": lambda world, who: world.unshare(),
    "cutting": lambda world, who: world.cut(),
    "expired": lambda world, who: world.stack.psql("UPDATE data_set_links SET expires_at = now() - interval '1 s' WHERE data_set_id = %s", world.data_set_id()),
    "ended": lambda world, who: world.end_links(),
    "of-edit": lambda world, who: None,
    "one-factor": without_second_factor,
    "disabled": disable,
}
#: Like STATES, but applied before anything else is created.
FIRST: dict[str, Callable[[World], None]] = {"of-edit": made_by_edit}
#: States of the scan, for which the operation's own precondition (`before`) is skipped.
OF_THE_SCAN = ("private", "public", "taken-down", "sample")


def ready_to_render(world: World) -> str:
    able_to_render(world.stack)
    return world.data_set_id()


def ask(world: World, role: str, path: str, method: str, operation: dict[str, Any], state: str = "") -> httpx.Response:
    """Requests one operation on the owner's objects as a user of that role."""
    request = question(world, role, path, method, operation, state)
    return world.someone(role).http.send(request)


def question(world: World, role: str, path: str, method: str, operation: dict[str, Any], state: str = "") -> httpx.Request:
    """Returns the request of ask() with all of its preconditions. `state`: one of STATES, or the object of the operation."""
    name = operation["operationId"]
    FIRST.get(state, lambda _: None)(world)
    who = world.someone(role)
    if not (state in OF_THE_SCAN and name in ABOUT_PUBLIC):
        before.get(name, lambda *_: None)(world, who)
    for parameter in operation["parameters"]:
        if parameter["in"] == "path":
            make = getattr(world, parameter["name"], None)
            assert make, f"{name}: World has no {parameter['name']}() yet (access_matrix_fixture.py)"
            path = path.replace("{" + parameter["name"] + "}", make())
    body: Any = bodies[name](world, who) if name in bodies else None
    if state:
        STATES[state](world, who)
    headers = {"Tus-Resumable": "1.0.0"} if path.startswith("/v1/uploads") else {}
    if name == "createUpload":
        headers["Upload-Length"] = "10"
    if name == "appendToUpload":
        part = {"Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"}
        return who.http.build_request(method, path, content=b"0123456789", headers={**headers, **part})
    if name == "putStudyPicture":
        return who.http.build_request(method, path, content=picture(), headers={"Content-Type": "image/png"})
    if name in ("changePreset", "deletePreset", "replaceStudy"):
        headers["If-Match"] = '"1"'
    if name == "createEnvironment":
        return who.http.build_request(method, path, params={"name": "Sky"}, content=hdr(4, 2, lambda x, y: (1, 1, 1)))
    if name == "importPreset":
        xml = CONTRACT.resolve(operation["requestBody"])["content"]["application/xml"]["example"]
        return who.http.build_request(method, path, content=xml, headers={"Content-Type": "application/xml"})
    if body is None and "requestBody" in operation:
        schema = CONTRACT.resolve(CONTRACT.resolve(operation["requestBody"])["content"]["application/json"]["schema"])
        assert not schema.get("required"), f"{name} needs a body (access_matrix_fixture.py)"
        body = {}
    return who.http.build_request(method, path, headers=headers, **({} if body is None else {"json": body}))


__all__ = ["ROLES", "World", "ask", "client", "question"]
