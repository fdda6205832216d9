"""The kinds of samples, what each shows, and their scans. Synthetic ones derive from seeds. The seeds with which the method was
developed (DEVELOPED_ON) differ from those of the reported results (REPORTED_ON)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Iterator

from . import bodies, scan as scans
from .bodies import View
from .real import Face, Real
from .scan import Scan

DEVELOPED_ON, REPORTED_ON = 10_000, 20_000


@dataclass(frozen=True)
class Sample:
    kind: str
    name: str
    scan: Scan
    is_head: bool | None        # None: either answer is acceptable (a brain without a face), and it is not counted
    face: Face | None = None    # of a real head, in the head's own axes


WHOLE = View((-110, -135, -150), (110, 130, 105))
HEAD_VIEWS = {
    "whole": WHOLE,
    "brow and above alone": View((-110, -135, -20), (110, 130, 105)),
    "face without the vault": View((-110, -135, -150), (110, 130, 15), off=4),
    "jaw and neck": View((-110, -135, -190), (110, 130, -60), off=4),
    "without the top of the head": View((-110, -135, -150), (110, 130, 45), off=4),
    "with the shoulders' height below": View((-140, -150, -300), (140, 150, 115)),
}
TRUNK = View((-260, -160, -140), (260, 160, 140), off=20)
SMALL = View((-120, -130, -110), (120, 130, 110))
OTHER_VIEWS = {
    "chest": (bodies.chest, TRUNK),
    "abdomen": (bodies.abdomen, TRUNK),
    "pelvis": (bodies.pelvis, TRUNK),
    "legs": (bodies.legs, View((-210, -120, -150), (210, 120, 150), off=15)),
    "knee": (bodies.knee, View((-100, -100, -90), (100, 100, 90))),
    "foot": (bodies.foot, View((-80, -170, -100), (80, 130, 120))),
    "hand": (bodies.hand, View((-90, -60, -110), (90, 60, 120))),
    "neck and shoulders, no skull": (bodies.shoulders, View((-240, -120, -220), (240, 130, 20))),
    "sphere": (bodies.sphere, SMALL),
    "cylinder": (bodies.cylinder, View((-120, -120, -160), (120, 120, 160))),
    "box": (bodies.box, SMALL),
    "scanner's phantom": (bodies.hollow, View((-130, -130, -140), (130, 130, 140))),
    "air and table": (bodies.nothing, SMALL),
}
WEIGHTINGS = ("T1", "T2", "FLAIR")


def made(count: int, seeds: int) -> Iterator[Sample]:
    """Yields `count` samples of each kind in CT and as many in MR, a third in each weighting."""
    for modality in ("CT", "MR"):
        def shown(i: int) -> str:
            return "CT" if modality == "CT" else WEIGHTINGS[i % 3]

        for part, view in HEAD_VIEWS.items():
            for i in range(count):
                yield Sample(f"made {modality}: head, {part}", f"{shown(i)} {i}",
                             bodies.look(bodies.head, view, shown(i), seeds + i), True)
        for i in range(count):
            yield Sample(f"made {modality}: head, turned up to 30 degrees", f"{shown(i)} {i}",
                         bodies.look(bodies.head, WHOLE, shown(i), seeds + 500 + i, most_turn=30), True)
        for name, (paint, view) in OTHER_VIEWS.items():
            for i in range(count):
                yield Sample(f"made {modality}: {name}", f"{shown(i)} {i}", bodies.look(paint, view, shown(i), seeds + 1000 + i), False)
        for i in range(count):
            yield Sample(f"made {modality}: noise", f"{i}", bodies.noise(modality, seeds + i), False)


def real(sources: list[Real]) -> Iterator[Sample]:
    for source in sources:
        what = source.what
        if what != "head":
            kind, is_head = {
                "brain": ("real: brain alone", None),
                "animal": ("real: brain of an animal", False),
                "picture of a head": ("real: one picture of a head, 20 times", True),
                "picture of something else": ("real: one picture of something else, 20 times", False),
                "piece": ("real: a piece of 2 cm", None),
            }[what]
            yield Sample(kind, source.name, source.scan, is_head)
            continue
        yield Sample("real: as it is", source.name, source.scan, True, source.face)
        for kind, name, change in _variants(source.scan):
            yield Sample(kind, f"{source.name}, {name}", change(source.scan), True, source.face if "turned" in kind else None)


Change = Callable[[Scan], Scan]


def _variants(of: Scan) -> Iterator[tuple[str, str, Change]]:
    for axis in ("pitch", "yaw", "roll"):
        for degrees in (-30, -20, -10, 10, 20, 30):
            yield ("real: turned by 10 to 30 degrees", f"{axis} {degrees}",
                   lambda s, a=axis, d=degrees: scans.turned(s, **{a: d}))
    for high in (0.7, 0.8, 0.9):
        yield "real: top not in it", f"the lower {high:.0%}", lambda s, h=high: scans.cropped(s, 2, 0, h)
    for low in (0.2, 0.3, 0.4, 0.5):
        yield "real: upper part alone", f"the upper {1 - low:.0%}", lambda s, low=low: scans.cropped(s, 2, low, 1)
    for share in (0.35, 0.45):
        yield "real: face without the vault", f"the lower {share:.0%}", lambda s, h=share: scans.cropped(s, 2, 0, h)
    for axis, side in ((0, "right"), (1, "front")):
        yield "real: a side cut off", f"{side} 15% cut off", lambda s, a=axis: scans.cropped(s, a, 0.15, 1)
    yield "real: stored otherwise", "mirrored", scans.mirrored
    yield "real: stored otherwise", "sagittal slices", scans.as_sagittal
    for factor in (2, 3, 5):
        if of.spacing[2] * factor <= 7.5:
            yield "real: thicker slices", f"{factor} times", lambda s, f=factor: scans.thick(s, f)
    for factor in (0.8, 0.9, 1.1):
        yield "real: smaller or larger", f"{factor} times", lambda s, f=factor: scans.scaled(s, f)
    for sigma in (30, 80) if of.modality == "CT" else (20, 50):
        yield "real: more noise", f"sigma {sigma}", lambda s, n=sigma: scans.noisy(s, n)
    if of.modality != "CT":
        yield "real: contrast inverted", "inverted", scans.inverted
        for strength in (0.4, 0.7):
            yield "real: a coil that fades", f"by {strength:.0%}", lambda s, n=strength: scans.shaded(s, n)
