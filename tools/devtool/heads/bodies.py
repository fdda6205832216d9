"""Random bodies of ellipsoids: heads and other body parts. Tissues are painted first, and then converted to their appearance in
CT or MR. Places are in mm along the patient's axes (x to the left, y to the back, z to the head)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

import numpy as np

from .scan import Scan, turning

AIR, SOFT, FAT, BONE, MARROW, BRAIN, CSF, ENAMEL, LUNG, LIVER, TABLE = range(11)

#: Appearance of each tissue: HU, and MR of three weightings (T1, T2, FLAIR).
SHOWN = {
    "CT": (-1000, 45, -95, 950, 280, 34, 8, 2300, -820, 62, 90),
    "T1": (3, 250, 700, 25, 450, 400, 110, 8, 20, 330, 3),
    "T2": (3, 180, 450, 20, 260, 330, 720, 8, 25, 200, 3),
    "FLAIR": (3, 230, 330, 20, 250, 390, 60, 8, 20, 240, 3),
}


class Canvas:
    """Tissues by place. Later paint covers earlier paint."""

    def __init__(self, x: np.ndarray, y: np.ndarray, z: np.ndarray):
        self.x, self.y, self.z = x, y, z
        self.tissue = np.zeros(x.shape, np.uint8)

    def far(self, middle, half) -> np.ndarray:
        """Returns the distance from the centre of an ellipsoid, 1 at its surface."""
        return np.sqrt(((self.x - middle[0]) / half[0]) ** 2 + ((self.y - middle[1]) / half[1]) ** 2 +
                       ((self.z - middle[2]) / half[2]) ** 2)

    def ring(self, middle, half) -> np.ndarray:
        """Returns the distance from the axis of an upright cylinder, 1 at its surface."""
        return np.hypot((self.x - middle[0]) / half[0], (self.y - middle[1]) / half[1])

    def between(self, low: float, high: float) -> np.ndarray:
        return (self.z >= low) & (self.z <= high)

    def paint(self, where: np.ndarray, tissue: int) -> None:
        self.tissue[where] = tissue

    def ball(self, middle, half, tissue: int) -> None:
        self.paint(self.far(middle, half) < 1, tissue)

    def bone(self, middle, radius: float, low: float, high: float) -> None:
        """Paints an upright long bone: a shell with marrow in it."""
        ring = self.ring(middle, (radius, radius))
        self.paint((ring < 1) & self.between(low, high), BONE)
        self.paint((ring < 0.6) & self.between(low, high), MARROW)


Paint = Callable[[Canvas, np.random.Generator], None]


def head(c: Canvas, rng: np.random.Generator) -> None:
    """Paints a head, with the centre of the brain at 0."""
    s = rng.uniform(0.82, 1.08)                     # from a three-year-old child to a large man
    brain = np.array([66, 82, 62]) * s * rng.uniform(0.95, 1.05, 3)
    skull, scalp = rng.uniform(4, 8), rng.uniform(4, 8)
    fat = rng.uniform(1, 3)
    neck = rng.uniform(50, 62) * s
    low = c.z < -35 * s
    c.paint(low & (c.ring((0, 18 * s), (neck, neck)) < 1), FAT)
    c.paint(low & (c.ring((0, 18 * s), (neck - 4, neck - 4)) < 1), SOFT)
    face = np.array([rng.uniform(54, 62), rng.uniform(42, 50), rng.uniform(58, 68)]) * s
    c.ball((0, -62 * s, -70 * s), face + 3, FAT)
    c.ball((0, -62 * s, -70 * s), face, SOFT)
    c.ball((0, -108 * s, -66 * s), (13 * s, rng.uniform(10, 17) * s, 22 * s), SOFT)
    c.ball((0, -92 * s, -118 * s), (26 * s, 18 * s, 15 * s), SOFT)
    for side in (-1, 1):
        c.ball((side * (brain[0] + skull + scalp + 3), 12 * s, -42 * s), (7, 13 * s, 26 * s), SOFT)
    c.ball((0, 0, 0), brain + skull + scalp + fat, FAT)
    c.ball((0, 0, 0), brain + skull + scalp, SOFT)
    shell = c.far((0, -62 * s, -70 * s), face * 0.78)
    c.paint((shell < 1) & (shell > 0.86) & c.between(-100 * s, -30 * s), BONE)
    jaw = c.ring((0, -50 * s), (46 * s, 52 * s))
    front = c.y < -30 * s
    c.paint(front & (jaw < 1) & (jaw > 0.82) & c.between(-122 * s, -100 * s), BONE)
    c.paint(front & (jaw < 0.95) & (jaw > 0.84) & c.between(-98 * s, -86 * s), ENAMEL)
    for side in (-1, 1):
        c.ball((side * 23 * s, -70 * s, -66 * s), np.array([13, 14, 15]) * s * rng.uniform(0.7, 1.1), AIR)
        c.ball((side * 32 * s, -82 * s, -36 * s), np.array([16, 18, 16]) * s, FAT)
        c.ball((side * 32 * s, -84 * s, -36 * s), np.array([12, 12, 12]) * s, CSF)
    c.ball((0, -82 * s, -64 * s), (7 * s, 26 * s, 18 * s), AIR)
    c.paint(c.between(-200 * s, -60 * s) & (c.ring((0, -22 * s), (8 * s, 9 * s)) < 1), AIR)
    spine = c.ring((0, 20 * s), (19 * s, 17 * s))
    c.paint((c.z < -66 * s) & (spine < 1), BONE)
    c.paint((c.z < -66 * s) & (spine < 0.75), MARROW)
    c.ball((0, 0, 0), brain + skull, BONE)
    c.ball((0, 0, 0), brain + 0.65 * skull, MARROW)
    c.ball((0, 0, 0), brain + 0.35 * skull, BONE)
    c.ball((0, 0, 0), brain, CSF)
    c.ball((0, 0, 0), brain - rng.uniform(2, 6), BRAIN)
    for side in (-1, 1):
        c.ball((side * 12 * s, 5 * s, 8 * s), np.array([6, 28, 10]) * s * rng.uniform(0.6, 1.4), CSF)
    if rng.random() < 0.3:                          # operated: a hole in the vault
        at = np.array([rng.choice([-1, 1]) * 0.8 * brain[0], rng.uniform(-40, 40), 30])
        hole = (c.far(at, np.full(3, rng.uniform(15, 30))) < 1) & ((c.tissue == BONE) | (c.tissue == MARROW))
        c.paint(hole, SOFT)
    if rng.random() < 0.5:
        rest = c.ring((0, 0), brain[:2] + skull + scalp + fat + 12)
        c.paint((c.y > 30) & (rest > 1) & (rest < 1.06), TABLE)


def _trunk(c: Canvas, rng: np.random.Generator) -> tuple[float, float]:
    across, deep, fat = rng.uniform(130, 195), rng.uniform(90, 130), rng.uniform(5, 35)
    if rng.random() < 0.2:                          # a child
        across, deep, fat = 0.55 * across, 0.6 * deep, 5
    ring = c.ring((0, 0), (across, deep))
    c.paint(ring < 1, FAT)
    inner = c.ring((0, 0), (across - fat, deep - fat))
    c.paint(inner < 1, SOFT)
    if rng.random() < 0.4:                          # arms beside the head
        for side in (-1, 1):
            c.paint(c.ring((side * (across + 52), 10), (44, 46)) < 1, FAT)
            c.paint(c.ring((side * (across + 52), 10), (38, 40)) < 1, SOFT)
            c.bone((side * (across + 52), 10), 12, -1e3, 1e3)
    y = 0.5 * (deep - fat)
    c.paint(c.ring((0, y), (22, 19)) < 1, BONE)
    c.paint(c.ring((0, y), (19, 16)) < 1, MARROW)
    c.paint(c.ring((0, y + 27), (9, 8)) < 1, CSF)
    if rng.random() < 0.6:
        c.paint((c.y > deep + 6) & (c.y < deep + 14) & (np.abs(c.x) < 220), TABLE)
    return across - fat, deep - fat


def chest(c: Canvas, rng: np.random.Generator) -> None:
    across, deep = _trunk(c, rng)
    for side in (-1, 1):
        c.ball((side * 0.5 * across, 0, rng.uniform(-20, 20)), (0.38 * across, 0.75 * deep, 130), LUNG)
    c.ball((15, -0.3 * deep, -20), (55, 45, 60), SOFT)
    cage = c.ring((0, 0), (0.93 * across, 0.95 * deep))
    along = np.mod(np.abs(c.z + 0.5 * c.y), 26)
    c.paint((cage > 0.93) & (cage < 1) & (along < 9) & (c.y > -0.85 * deep), BONE)
    c.paint((np.abs(c.x) < 18) & (np.abs(c.y + 0.93 * deep) < 7), BONE)
    for side in (-1, 1):
        c.ball((side * 0.6 * across, 0.85 * deep, 60), (42, 5, 60), BONE)


def abdomen(c: Canvas, rng: np.random.Generator) -> None:
    across, deep = _trunk(c, rng)
    c.ball((-0.45 * across, -10, 50), (0.5 * across, 0.75 * deep, 75), LIVER)
    c.ball((0.6 * across, 20, 60), (35, 40, 50), LIVER)
    for side in (-1, 1):
        c.ball((side * 0.4 * across, 0.45 * deep, 0), (25, 22, 52), LIVER)
    for _ in range(8):
        c.ball((rng.uniform(-0.6, 0.6) * across, rng.uniform(-0.7, 0) * deep, rng.uniform(-100, 60)), rng.uniform(8, 24, 3), AIR)
    cage = c.ring((0, 0), (0.95 * across, 0.96 * deep))
    c.paint((cage > 0.94) & (cage < 1) & (np.mod(np.abs(c.z + 0.5 * c.y), 26) < 9) & (c.z > 30), BONE)


def pelvis(c: Canvas, rng: np.random.Generator) -> None:
    across, deep = _trunk(c, rng)
    ring = c.ring((0, 0), (0.68 * across, 0.75 * deep))
    c.paint((ring > 0.86) & (ring < 1.02) & ((c.y > -0.2 * deep) | (np.abs(c.z + 40) < 12)) & c.between(-70, 70), BONE)
    for side in (-1, 1):
        c.ball((side * 0.62 * across, 0, -50), (25, 25, 25), BONE)
        c.ball((side * 0.62 * across, 0, -50), (21, 21, 21), MARROW)
    c.ball((0, -20, -20), (42, 38, 36), CSF)


def legs(c: Canvas, rng: np.random.Generator) -> None:
    radius, one = rng.uniform(58, 92), rng.random() < 0.4
    for side in ((0,) if one else (-1, 1)):
        x = side * (radius + rng.uniform(3, 12))
        grow = 1 + 0.0008 * c.z                     # narrower towards the knee
        ring = np.hypot(c.x - x, c.y) / (radius * grow)
        c.paint(ring < 1, FAT)
        c.paint(ring < 0.86, SOFT)
        c.bone((x, 0), rng.uniform(13, 17), -1e3, 1e3)


def knee(c: Canvas, rng: np.random.Generator) -> None:
    radius = rng.uniform(50, 75)
    ring = np.hypot(c.x, c.y) / (radius * (1 + 0.0015 * np.abs(c.z)))
    c.paint(ring < 1, FAT)
    c.paint(ring < 0.88, SOFT)
    c.bone((0, 5), 14, 30, 1e3)
    c.bone((0, 5), 13, -1e3, -30)
    c.bone((35, 15), 6, -1e3, -30)
    for z, half in ((24, (38, 28, 24)), (-24, (36, 26, 20))):
        c.ball((0, 5, z), half, BONE)
        c.ball((0, 5, z), np.array(half) - 3, MARROW)
    c.ball((0, -35, 10), (20, 9, 20), BONE)
    c.ball((0, 0, 0), (30, 22, 5), CSF)


def foot(c: Canvas, rng: np.random.Generator) -> None:
    """Paints the foot of a person who lies on their back: toes up, sole towards the feet."""
    s = rng.uniform(0.85, 1.1)
    c.paint((c.ring((0, 40 * s), (45 * s, 48 * s)) < 1) & (c.z > -20), SOFT)
    c.ball((0, 62 * s, -25 * s), (38 * s, 38 * s, 45 * s), SOFT)
    c.ball((0, -40 * s, -40 * s), (45 * s, 110 * s, 30 * s), SOFT)
    c.bone((0, 40 * s), 17 * s, 0, 1e3)
    c.ball((0, 62 * s, -25 * s), (22 * s, 26 * s, 22 * s), BONE)
    c.ball((0, 62 * s, -25 * s), (19 * s, 23 * s, 19 * s), MARROW)
    for i in range(5):
        c.ball((s * (i - 2) * 17, -70 * s, -40 * s), (5 * s, 45 * s, 6 * s), BONE)


def hand(c: Canvas, rng: np.random.Generator) -> None:
    s = rng.uniform(0.85, 1.1)
    c.ball((0, 0, -30), (45 * s, 16 * s, 60 * s), SOFT)
    for i in range(4):
        x = s * (i - 1.5) * 21
        c.ball((x, 0, 55 * s), (9 * s, 9 * s, 48 * s), SOFT)
        c.ball((x, 0, 0), (5 * s, 5 * s, 85 * s), BONE)
    c.ball((55 * s, 0, -10 * s), (11 * s, 11 * s, 40 * s), SOFT)


def shoulders(c: Canvas, rng: np.random.Generator) -> None:
    """Paints the neck without a skull, and the body below it."""
    s = rng.uniform(0.85, 1.1)
    c.paint(c.ring((0, 15 * s), (60 * s, 62 * s)) < 1, SOFT)
    c.ball((0, 20 * s, -150 * s), (215 * s, 85 * s, 110 * s), SOFT)
    c.paint(c.ring((0, -20 * s), (9, 10)) < 1, AIR)
    spine = c.ring((0, 20 * s), (19 * s, 17 * s))
    c.paint(spine < 1, BONE)
    c.paint(spine < 0.75, MARROW)
    for side in (-1, 1):
        c.ball((side * 80 * s, -20 * s, -70 * s), (70 * s, 8, 8), BONE)
        c.ball((side * 165 * s, 10 * s, -95 * s), (24 * s, 24 * s, 24 * s), BONE)


def sphere(c: Canvas, rng: np.random.Generator) -> None:
    c.ball((0, 0, 0), np.full(3, rng.uniform(60, 100)), rng.choice([SOFT, CSF]))


def cylinder(c: Canvas, rng: np.random.Generator) -> None:
    radius, half = rng.uniform(55, 100), rng.uniform(60, 140)
    c.paint((c.ring((0, 0), (radius, radius)) < 1) & c.between(-half, half), rng.choice([SOFT, CSF]))


def box(c: Canvas, rng: np.random.Generator) -> None:
    half = rng.uniform(50, 110, 3)
    c.paint((np.abs(c.x) < half[0]) & (np.abs(c.y) < half[1]) & (np.abs(c.z) < half[2]), rng.choice([SOFT, CSF]))


def hollow(c: Canvas, rng: np.random.Generator) -> None:
    """Paints a phantom for calibrating a scanner: water in plastic, with rods."""
    radius, half = rng.uniform(70, 110), rng.uniform(60, 120)
    ring = c.ring((0, 0), (radius, radius))
    c.paint((ring < 1) & c.between(-half, half), TABLE)
    c.paint((ring < 0.93) & c.between(-half + 6, half - 6), CSF)
    for i in range(6):
        at = (0.6 * radius * np.cos(i), 0.6 * radius * np.sin(i))
        c.paint((c.ring(at, (8, 8)) < 1) & c.between(-half + 10, half - 10), int(rng.choice([BONE, FAT, AIR])))


def nothing(c: Canvas, rng: np.random.Generator) -> None:
    """Paints nothing but, sometimes, a table."""
    if rng.random() < 0.5:
        c.paint((c.y > 60) & (c.y < 70), TABLE)


@dataclass(frozen=True)
class View:
    """The scanned box: mm, low and high along x, y, z of the body's own axes, and its maximum offset."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    off: float = 8


def look(paint: Paint, view: View, shown: str, seed: int, most_turn: float = 8, spacing: float = 3.0) -> Scan:
    """Returns a scan of a body of that kind. All random choices derive from `seed`."""
    rng = np.random.default_rng(seed)
    low, high = np.array(view.low, float), np.array(view.high, float)
    low, high = low + rng.uniform(-view.off, view.off, 3), high + rng.uniform(-view.off, view.off, 3)
    step = np.array([spacing, spacing, rng.choice([1.0, 1.5, 2.0]) * spacing])
    n = np.maximum(8, ((high - low) / step).astype(int))
    z, y, x = np.meshgrid(*((np.arange(m) + 0.5 - m / 2) * s for m, s in zip(n[::-1], step[::-1])), indexing="ij")
    turn = turning(*rng.uniform(-most_turn, most_turn, 3))
    body = np.stack([x, y, z], -1).astype(np.float32) @ turn.astype(np.float32) + ((low + high) / 2).astype(np.float32)
    canvas = Canvas(body[..., 0], body[..., 1], body[..., 2])
    paint(canvas, rng)
    values = np.array(SHOWN[shown], np.float32)[canvas.tissue]
    if shown == "CT":
        values = values + rng.normal(0, rng.uniform(5, 40), values.shape)
        return Scan(_stored(values), tuple(float(s) for s in step), np.eye(3), "CT")
    # Simulates the field of a coil: up to a third weaker at one side, sometimes fading towards the
    # ends.
    way = rng.normal(size=3)
    field = 1 - 0.33 * (1 + (x * way[0] + y * way[1] + z * way[2]) / (np.linalg.norm(way) * 200)) / 2
    if rng.random() < 0.3:
        field = field * np.clip(1.15 - (np.abs(z) / (0.5 * n[2] * step[2])) ** 4, 0, 1)
    sigma = rng.uniform(3, 20)
    values = np.hypot(values * field + rng.normal(0, sigma, values.shape), rng.normal(0, sigma, values.shape))
    return Scan(_stored(values), tuple(float(s) for s in step), np.eye(3), "MR")


def noise(shown: str, seed: int) -> Scan:
    rng = np.random.default_rng(seed)
    values = rng.normal(0, 1, (60, 70, 70)) * rng.uniform(50, 900) + (0 if shown == "CT" else 500)
    return Scan(_stored(values), (3.0, 3.0, 3.0), np.eye(3), "CT" if shown == "CT" else "MR")


def _stored(values: np.ndarray) -> np.ndarray:
    return np.clip(np.round(values), -32768, 32767).astype(np.int16)
