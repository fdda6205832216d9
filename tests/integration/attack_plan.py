"""Which attacks are sent to which route in which role: every route of api/openapi.yaml, the stream and the pages. Plain data."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Callable, Sequence

from edge_attacks import REFUSED, Attack, Request
from access_matrix import OPERATIONS, ROWS
from access_matrix_fixture import ROLES

#: The kind of the unmodified request.
ITSELF = "the request itself"
SAFE = ("GET", "HEAD", "OPTIONS")


@dataclass(frozen=True)
class Route:
    """`may`: by role, "+" or the status with which it is refused (access_matrix.txt)."""

    name: str
    group: str
    method: str
    path: str
    may: dict[str, str] = field(hash=False)
    stated: frozenset[int] = frozenset()   # failure statuses that the contract states for it

    @property
    def changes(self) -> bool:
        return self.method not in SAFE or self.group == "stream"


#: The page's own addresses and files. The last one does not exist.
PAGES = ("/", "/scans", "/verify", "/view/0d1f0c4e-0000-4000-8000-000000000000", "/favicon.svg", "/assets/none.js")


def routes() -> list[Route]:
    made = []
    for name, (path, method, operation) in OPERATIONS.items():
        stated = frozenset(int(status) for status in operation["responses"] if status.startswith("5"))
        made.append(Route(name, operation["tags"][0], method, path, ROWS[name], stated))
    # A ticket of the user's own session opens the stream. A role without one uses an invented ticket, which the gateway refuses
    # with a readable message.
    own = {role: "+" if cell == "+" else "101" for role, cell in ROWS["createSession"].items()}
    made.append(Route("stream", "stream", "GET", "/stream", own))
    made += [Route(path, "pages", "GET", path, dict.fromkeys(ROLES, "404" if path.endswith("none.js") else "+")) for path in PAGES]
    return made


@dataclass(frozen=True)
class Cell:
    route: Route
    role: str

    @property
    def may(self) -> bool:
        return self.route.may[self.role] == "+"

    @property
    def may_change(self) -> bool:
        return self.may and self.route.changes


def cells(chosen: Sequence[Route], roles: Sequence[str] = ROLES) -> list[Cell]:
    return [Cell(route, role) for route in chosen for role in roles]


#: Selects the attacks on a request that are sent in the cell with this number: all or some.
Choice = Callable[[int, Sequence[Attack]], Sequence[Attack]]


def all_of_them(number: int, attacks: Sequence[Attack]) -> Sequence[Attack]:
    return attacks


def some_of(each: int) -> Choice:
    """Sends `each` attacks in every cell. The next route continues in the list, and each role starts elsewhere in it."""
    def choose(number: int, attacks: Sequence[Attack]) -> Sequence[Attack]:
        route, role = divmod(number, len(ROLES))
        first = route * each + role * len(attacks) // len(ROLES)
        return [attacks[(first + n) % len(attacks)] for n in range(each)]
    return choose


@dataclass
class Tally:
    """Results of the attacks on one cell."""

    sent: int = 0
    refused: int = 0
    answered: int = 0
    silent: int = 0                        # closed without a response, as allowed if there was no request
    misses: list[str] = field(default_factory=list)

    def add(self, other: "Tally") -> None:
        self.sent, self.refused, self.answered, self.silent = (
            self.sent + other.sent, self.refused + other.refused, self.answered + other.answered, self.silent + other.silent)
        self.misses += other.misses


def fault_of(cell: Cell, attack: Attack, statuses: Sequence[int]) -> str:
    """Returns what is wrong with these responses on one connection, or an empty text."""
    if not statuses:
        return "no answer" if attack.must_answer and not attack.leaves else ""
    if len(statuses) > attack.answers:
        return f"{len(statuses)} answers where {attack.answers} may be: {statuses}"
    if attack.kind == ITSELF:
        wanted = cell.route.may[cell.role]
        fits = statuses[0] < 400 if wanted == "+" else str(statuses[0]) == wanted
        return "" if fits else f"{wanted} wanted, {statuses[0]} got"
    allowed = attack.only or REFUSED if attack.only or attack.refused else None
    for status in statuses:
        if allowed is not None:
            fits = status in allowed or (bool(attack.only) and status in REFUSED)
        elif status in REFUSED or status == 100 and "expect" in attack.name:
            fits = True
        elif status >= 500:
            fits = status in cell.route.stated
        elif status < 400:
            fits = cell.may or str(status) == cell.route.may[cell.role] or (attack.page and status == 200)
        else:
            fits = True
        if not fits:
            return f"answered with {list(statuses)}"
    return ""


def table(tallies: dict[Cell, Tally]) -> list[dict[str, str | int]]:
    """Returns rows by group of routes and role: sent, refused, answered, closed without a response, failures."""
    summed: dict[tuple[str, str], Tally] = {}
    counted: Counter[str] = Counter()
    for route in {cell.route.name: cell.route for cell in tallies}.values():
        counted[route.group] += 1
    for cell, tally in tallies.items():
        summed.setdefault((cell.route.group, cell.role), Tally()).add(tally)
    return [{"group": group, "routes": counted[group], "role": role, "sent": one.sent, "refused": one.refused, "answered": one.answered,
             "closed": one.silent, "misses": len(one.misses)} for (group, role), one in summed.items()]


def printed(rows: Sequence[dict[str, str | int]]) -> str:
    if not rows:
        return ""
    lines = [list(rows[0]), *([str(cell) for cell in row.values()] for row in rows)]
    widths = [max(len(line[n]) for line in lines) for n in range(len(lines[0]))]
    return "\n".join("  ".join(cell.rjust(width) if n not in (0, 2) else cell.ljust(width) for n, (cell, width) in enumerate(zip(line, widths)))
                     for line in lines)
