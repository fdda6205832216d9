"""Sends the attacks of attack_plan.py to a running stack, each on a request that is authorised for its role, and checks the
results.

Attacks that only read, or are not permitted, come first. After them, the database, the sessions and the files must be unchanged.
Attacks that may change something follow, with new users and objects whenever one did."""

from __future__ import annotations

import asyncio
import contextlib
import json
import re
import socket
import struct
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import count
from typing import Awaitable, Iterable, Iterator, Sequence

import psycopg
from api_client import forget_attempts
from attack_plan import ITSELF, Cell, Choice, Tally, fault_of
from edge_attacks import Attack, Request, attacks_on, slow
from edge_helpers import STATUS_LINE
from harness import TestStack, files_below
from psycopg import sql
from access_matrix import OPERATIONS
from access_matrix_fixture import World, able_to_render, free_slots, question

#: Concurrent cells with one connection each: more than the API has threads, and too few to make it refuse.
AT_ONCE = 24
#: Seconds without a byte, after a response and without one.
KEPT_OPEN, UNANSWERED = 1.0, 8.0
#: Seconds after which a response that must come will not. No test is decided by it, because machines are busy.
MUST_ANSWER = 60.0
#: Seconds within which the edge has logged a request that it has answered.
LOGGED = 10.0
#: How often a repeatable request is repeated before it gets new objects, because lists are limited.
REPEATED = 8
#: Headers that matter to a route. Other headers of a client are ignored.
TOLD = ("cookie", "x-csrf-token", "content-type", "tus-resumable", "upload-offset", "upload-length", "if-match")
#: The first byte of the gateway's last message.
CLOSE = b"\x88"
MARK = re.compile(rb"marked-[0-9a-f]{12}")
ADDRESS = re.compile(rb"person-[0-9a-f]{12}@example\.org")


@dataclass
class Aimed:
    """A cell with its request, and the objects that the request concerns."""

    number: int
    cell: Cell
    world: World
    request: Request
    tally: Tally = field(default_factory=Tally)


def take_aim(stack: TestStack, cell: Cell, number: int = 0, world: World | None = None) -> Aimed:
    world = world or World(stack)
    if cell.route.name in OPERATIONS:
        asked = question(world, cell.role, *OPERATIONS[cell.route.name])
        headers = tuple((name, value) for name, value in asked.headers.raw if name.decode().lower() in TOLD)
        limit = 8 << 20 if asked.url.path.startswith("/v1/uploads/") else 1 << 20
        request = Request(asked.method.encode(), asked.url.raw_path, headers, asked.read(), body_limit=limit)
    else:
        asked = world.someone(cell.role).http.build_request(cell.route.method, cell.route.path)
        headers = tuple((name, value) for name, value in asked.headers.raw if name.lower() == b"cookie")
        request = Request(asked.method.encode(), asked.url.raw_path, headers, reads_body=False)
        if cell.route.group == "stream":
            request = _stream(world, cell, request)
    mark(world)
    return Aimed(number, cell, world, request)


def _stream(world: World, cell: Cell, request: Request) -> Request:
    ticket = "0" * 64
    data_set = world.data_set_id()
    if cell.may:
        able_to_render(world.stack)
        answer = world.someone(cell.role).http.post("/v1/sessions", json={"data_set_id": data_set})
        assert answer.status_code == 201, answer.text
        ticket = answer.json()["stream_url"].rpartition("=")[2]
    upgrade = {"Upgrade": "websocket", "Connection": "upgrade, close", "Origin": world.stack.url, "Sec-WebSocket-Version": "13",
               "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Protocol": "diaphane.v1"}
    return Request(b"GET", f"/stream?ticket={ticket}".encode(),
                   (*request.headers, *((name.encode(), value.encode()) for name, value in upgrade.items())), reads_body=False)


def mark(world: World) -> None:
    """Puts a word into the texts of its scan and presets, by which leaks are recognised."""
    if world.data_set:
        world.word = f"marked-{world.data_set.replace('-', '')[:12]}"
        world.stack.psql("UPDATE data_sets SET title = %s, description = %s WHERE id = %s", world.word, world.word, world.data_set)
        world.stack.psql("UPDATE presets SET name = %s WHERE data_set_id = %s", world.word, world.data_set)


def make_room(stack: TestStack) -> None:
    """Resets limits by count, for all users together or for one."""
    forget_attempts(stack)
    stack.psql("DELETE FROM visits")
    free_slots(stack)


def addresses() -> Iterator[str]:
    """Yields loopback addresses in turn, because limits by address are not tested here."""
    for number in count():
        yield f"127.{16 + number // 65536 % 64}.{number // 256 % 256}.{number % 256}"


class Attacker:
    """Raw connections to the edge, each from its own address."""

    def __init__(self, stack: TestStack):
        self.stack = stack
        self.port = stack.ports["edge"]
        self.source = addresses()

    async def connect(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        return await asyncio.open_connection("127.0.0.1", self.port, local_addr=(next(self.source), 0))

    async def talk(self, attack: Attack) -> bytes:
        """Returns everything until the edge closes the connection, or a stream falls silent."""
        reader, writer = await self.connect()
        got = bytearray()
        try:
            writer.write(attack.data)
            if attack.leaves:
                await writer.drain()
                if attack.leaves == "reset":
                    raw = writer.get_extra_info("socket")
                    raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                return b""
            sending = asyncio.ensure_future(writer.drain())
            unanswered = MUST_ANSWER if attack.must_answer else UNANSWERED
            try:
                while part := await asyncio.wait_for(reader.read(65536), KEPT_OPEN if got else unanswered):
                    got += part
                    if b"HTTP/1.1 101 " in got and CLOSE in got.partition(b"\r\n\r\n")[2]:
                        break
            finally:
                sending.cancel()
        except (ConnectionError, TimeoutError):
            pass                            # refused while still sending; kept open after its response, or without one
        finally:
            writer.transport.abort() if attack.leaves == "reset" else writer.close()
        return bytes(got)

    async def send(self, aimed: Aimed, attack: Attack) -> list[int]:
        """Sends one attack and separates expected from unexpected responses. Repeats attacks that merely exceeded a rate limit.
        """
        for last in (False, False, True):
            answer = await self.talk(attack)
            statuses = [int(found) for found in STATUS_LINE.findall(answer)]
            if last or not any(status in (429, 503) for status in statuses):
                break
            await asyncio.to_thread(make_room, self.stack)
        self.judge(aimed, attack, answer)
        return statuses

    @staticmethod
    def judge(aimed: Aimed, attack: Attack, answer: bytes) -> None:
        statuses, tally = [int(found) for found in STATUS_LINE.findall(answer)], aimed.tally
        tally.sent += 1
        if not statuses:
            tally.silent += 1
        elif any(status < 400 and status != 100 for status in statuses):
            tally.answered += 1
        else:
            tally.refused += 1
        for fault in filter(None, (fault_of(aimed.cell, attack, statuses), told(aimed, answer))):
            tally.misses.append(f"{aimed.cell.route.name} as {aimed.cell.role}: {attack.kind}, {attack.name}: {fault}")

    async def drip(self, aimed: Aimed, seconds: int) -> None:
        """Sends headers and a body at one byte per second at the same time. Any response must end the connection."""
        async def one(name: str, data: bytes) -> None:
            reader, writer = await self.connect()
            got = b""
            try:
                writer.write(data)
                for _ in range(seconds):
                    if got or reader.at_eof():
                        break
                    writer.write(b"x")
                    got = await _within(1, reader.read(4096))
            except ConnectionError:
                pass
            finally:
                writer.close()
            # For a role that may not send a body, it is refused before it is read.
            only = frozenset(range(400, 500)) if name == "a body" and aimed.request.reads_body else frozenset()
            attack = Attack("slow", f"{name}, a byte a second", data, name == "headers", must_answer=False, only=only)
            self.judge(aimed, attack, got)

        await asyncio.gather(*(one(name, data) for name, data in zip(("headers", "a body"), slow(aimed.request))))


async def _within(seconds: float, reading) -> bytes:
    try:
        return await asyncio.wait_for(reading, seconds)
    except TimeoutError:
        return b""


def told(aimed: Aimed, answer: bytes) -> str:
    """Returns another user's data in the response, or an empty text."""
    cell, world = aimed.cell, aimed.world
    if not cell.may and b"HTTP/1.1 101 " in answer and answer.rpartition(b"\r\n\r\n")[2][:1] not in (CLOSE, b""):
        return "it was let into a session"
    for word in set(MARK.findall(answer)):
        shown = world.stack.psql("SELECT 1 FROM data_sets WHERE title = %s AND (visibility = 'public' OR EXISTS"
                                 " (SELECT FROM reports r WHERE r.data_set_id = data_sets.id))", word.decode())
        if not cell.may or (word.decode() != world.word and not shown):
            return f"it has the title of a scan that is not {cell.role}'s to see"
    everybody = cell.may and cell.role == "administrator"
    own = {one.email.encode() for one in world.people.values()} if cell.may else {world.someone(cell.role).email.encode()}
    for address in set(ADDRESS.findall(answer)):
        if not everybody and address not in own:
            return "it has somebody else's address"
    return ""


# State that must not change

#: Tables that change on their own, or count requests.
PASSING = ("attempts", "mail_queue", "disposals", "schema_migrations")
PASSING_COLUMNS = {"web_sessions": ("used_at", "expires_at"), "exports": ("state", "bytes", "attempts", "leased_until"),
                   "presets": ("pictured_at", "picture_not_before", "picture_tries")}


@dataclass(frozen=True)
class State:
    """Rows of all tables, sessions with their state, ended sessions and links, and files of uploads and volumes with their sizes.
    """

    rows: Counter[str]
    sessions: dict[str, tuple]
    ended: frozenset[str]
    files: dict[str, int]


def state_of(stack: TestStack) -> State:
    rows: Counter[str] = Counter()
    with psycopg.connect(stack.dsn) as database:
        for (table,) in database.execute("SELECT tablename FROM pg_tables WHERE schemaname = 'public' ORDER BY 1").fetchall():
            if table in PASSING:
                continue
            # Excludes entries that record an administrator's access, the only change that reading causes.
            where = " WHERE action NOT LIKE '%%.looked-at'" if table == "audit_log" else ""
            row = sql.SQL("to_jsonb(t)" + " - {}" * len(gone := PASSING_COLUMNS.get(table, ()))).format(*map(sql.Literal, gone))
            found = database.execute(sql.SQL("SELECT ({})::text FROM {} t" + where).format(row, sql.Identifier(table)))
            rows.update(f"{table}: {text}" for (text,) in found)
    keys = list(stack.redis.scan_iter("diaphane:*", count=1000))
    sessions = {key: tuple(stack.redis.hmget(key, "user", "data_set", "scene")) for key in keys if re.fullmatch(r"diaphane:session:[0-9a-f-]{36}", key)}
    files: dict[str, int] = {}
    for path in files_below(stack.data_dir / "uploads", stack.data_dir / "volumes"):
        with contextlib.suppress(FileNotFoundError):    # deleted meanwhile
            files[str(path)] = path.stat().st_size
    return State(rows, sessions, frozenset(key for key in keys if key.endswith(":ended")), files)


def changes(before: State, after: State) -> list[str]:
    """Returns what differs. Ignores sessions that merely expired."""
    found = [f"gone or changed: {row[:300]}" for row in before.rows - after.rows] + [f"new: {row[:300]}" for row in after.rows - before.rows]
    found += [f"ended: {key}" for key in after.ended - before.ended]
    found += [f"another session: {key}" for key, what in before.sessions.items() if after.sessions.get(key, what) != what]
    found += [f"new: {key}" for key in after.sessions.keys() - before.sessions.keys()]
    found += [f"a file: {path}" for path in before.files.keys() | after.files.keys() if before.files.get(path) != after.files.get(path)]
    return found


class Sent:
    """Compares what the edge forwarded with what the API received: each request must come through the edge, exactly once."""

    def __init__(self, stack: TestStack):
        self.stack = stack
        stack.stack.log_limit = 1 << 40     # keeps all log lines until the end of the run
        self.begun = {name: self._size(name) for name in ("edge", "api")}

    def _size(self, name: str) -> int:
        path = self.stack.stack.log_path(name)
        return path.stat().st_size if path.exists() else 0

    def _lines(self, name: str) -> Iterator[dict]:
        with self.stack.stack.log_path(name).open("rb") as log:
            log.seek(self.begun[name])
            for line in log:
                if line.endswith(b"\n") and (b'"event":"request"' in line or b'"request"' in line):
                    yield json.loads(line)

    def smuggled(self) -> list[str]:
        asked = Counter(line["request_id"] for line in self._lines("api") if line.get("event") == "request")
        # The edge logs a request after its response, while other users continue to send requests.
        deadline = time.monotonic() + LOGGED
        while not asked.keys() <= (known := {line["request_id"] for line in self._lines("edge")}) and time.monotonic() < deadline:
            time.sleep(1)
        return [f"a request that the edge does not know, or more than once: {name}" for name, times in asked.items() if name not in known or times > 1]


# Running the attacks

@dataclass
class Outcome:
    tallies: dict[Cell, Tally]
    misses: list[str]


def run(stack: TestStack, chosen: Sequence[Cell], choice: Choice, drip_seconds: int = 12, renew: bool = True) -> Outcome:
    """`renew`: a role with permission to change something gets new objects for each attack. Otherwise, only when the request can
    no longer succeed."""
    return asyncio.run(_run(stack, chosen, choice, drip_seconds, renew))


async def _run(stack: TestStack, chosen: Sequence[Cell], choice: Choice, drip_seconds: int, renew: bool) -> Outcome:
    attacker, sent = Attacker(stack), Sent(stack)
    aimed = await asyncio.to_thread(_aim, stack, chosen)
    able_to_render(stack)
    before = await asyncio.to_thread(state_of, stack)
    await asyncio.gather(*(attacker.drip(one, drip_seconds) for one in aimed if drip_seconds), _at_most(AT_ONCE, (
        _ask(attacker, one, choice) for one in aimed)))
    await asyncio.to_thread(forget_attempts, stack)
    misses = changes(before, await asyncio.to_thread(state_of, stack))
    await _at_most(4, (_change(attacker, one, choice, renew) for one in aimed if one.cell.may_change))
    misses += await asyncio.to_thread(sent.smuggled)
    return Outcome({one.cell: one.tally for one in aimed}, misses + [miss for one in aimed for miss in one.tally.misses])


async def _at_most(number: int, works: Iterable[Awaitable[None]]) -> None:
    """Runs all of them with limited concurrency."""
    left = iter(works)

    async def turn() -> None:
        for work in left:
            await work

    await asyncio.gather(*(turn() for _ in range(number)))


async def _ask(attacker: Attacker, aimed: Aimed, choice: Choice) -> None:
    """Sends attacks that change nothing, because they are refused or only read."""
    for attack in attacks_of(aimed, choice):
        if attack.refused or not aimed.cell.may_change:
            await attacker.send(aimed, attack)


def attacks_of(aimed: Aimed, choice: Choice) -> list[Attack]:
    return [Attack(ITSELF, "as it is", aimed.request.data()), *choice(aimed.number, attacks_on(aimed.request))]


def _aim(stack: TestStack, chosen: Sequence[Cell]) -> list[Aimed]:
    """Creates one world for all roles of a route."""
    forget_attempts(stack)
    routes: dict[str, list[tuple[int, Cell]]] = {}
    for number, cell in enumerate(chosen):
        routes.setdefault(cell.route.name, []).append((number, cell))

    def at(numbered: list[tuple[int, Cell]]) -> list[Aimed]:
        world = World(stack)
        made = [take_aim(stack, cell, number, world) for number, cell in numbered]
        mark(world)
        return made

    with ThreadPoolExecutor(4) as threads:
        return [one for some in threads.map(at, routes.values()) for one in some]


async def _change(attacker: Attacker, aimed: Aimed, choice: Choice, renew: bool) -> None:
    """Sends attacks on a request that may succeed, one after the other."""
    number, answered, most = 0, 0, 1 if renew else 1 << 30
    used = renew or b'"code"' in aimed.request.body
    while True:
        if used:
            again = await asyncio.to_thread(take_aim, attacker.stack, aimed.cell, aimed.number)
            aimed.world, aimed.request = again.world, again.request
        attacks = [one for one in attacks_of(aimed, choice) if not one.refused and (renew or one.kind != ITSELF)]
        if number == len(attacks):
            return
        used, answered = False, 0
        while number < len(attacks) and not used:
            answered += _carried_out(await attacker.send(aimed, attacks[number]))
            if number == 0 and renew and _carried_out(await attacker.send(aimed, Attack("again", "as it is", attacks[0].data))):
                most = REPEATED
            number += 1
            used = answered >= most


def _carried_out(statuses: Sequence[int]) -> bool:
    return any(status < 400 and status != 100 for status in statuses)
