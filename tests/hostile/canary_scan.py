"""A valid scan with a canary word in every place that can hold text, none of which a server may store."""

from __future__ import annotations

import base64
import random
import string

from .dicom_bytes import EXPLICIT, TAR_END, element, entry, header, implicit, item, noise, padded, tar_header, u16

#: Kinds of places, each with its own word, so that a hit shows where it came from.
PLACES = ("person", "header", "nested", "private", "around", "names", "upload")
TEXTS = {"LO": (0x00080080, 0x0008103E, 0x00081030, 0x00081040, 0x00100020, 0x00100021, 0x00101000, 0x00102180, 0x00180010,
                0x00181000, 0x00181030, 0x00321060, 0x00324000, 0x00380010, 0x00400254, 0x00281055),
         "SH": (0x00080050, 0x00080094, 0x00081010, 0x00102160, 0x00181210, 0x00200010, 0x00400253),
         "ST": (0x00080081, 0x00400280), "LT": (0x001021B0, 0x00104000, 0x00204000, 0x00184000),
         "PN": (0x00080090, 0x00081048, 0x00081050, 0x00081060, 0x00081070, 0x00101001, 0x00101005, 0x00321032),
         "AE": (0x00080054,), "UC": (0x00189900,), "UT": (0x00402001,), "UR": (0x00081190,), "CS": (0x00100022,)}


class CanaryScan:
    """`words`: by place, new for each scan, so that nothing of another run is found."""

    def __init__(self) -> None:
        letters = random.SystemRandom()
        self.words = {place: "Canary" + "".join(letters.choices(string.ascii_letters, k=9)) for place in PLACES}
        self.uid = "2.25." + "".join(letters.choices("123456789", k=30))
        self.born = "18" + "".join(letters.choices("123456789", k=16))

    def all_words(self) -> list[str]:
        return [*self.words.values(), self.uid, self.born]

    def file(self, number: int) -> bytes:
        word = self.words
        inside = element(0x00081155, "UI", self.uid) + element(0x00100010, "PN", word["nested"])
        nested = element(0x00400275, "SQ", item(element(0x00400007, "LO", word["nested"]) + element(0x00081199, "SQ", item(inside))))
        # All text elements of a plain slice, and further ones.
        parts = [part for part in header(number, image_type=element(
            0x00080008, "CS", f"ORIGINAL\\PRIMARY\\AXIAL\\{word['header']}"), patient=element(0x00100010, "PN", word["person"] + "^Jane"),
            sop_uid=element(0x00080018, "UI", f"{self.uid}.{number}"), series_uid=element(0x0020000E, "UI", self.uid))]
        parts += [element(tag, vr, f"{word['header']} of {vr}") for vr, tags in TEXTS.items() for tag in tags]
        parts += [element(0x00100030, "DA", self.born[:8]), element(0x0008002A, "DT", self.born), element(0x0020000D, "UI", self.uid),
                  element(0x00081140, "SQ", item(inside)), nested,
                  element(0x00090010, "LO", word["private"]), element(0x00091001, "UN", item(implicit(0x00091002, word["private"].encode() + b" "))),
                  element(0x00290010, "LO", "SIEMENS CSA HEADER"), element(0x00291010, "OB", b"SV10" + word["private"].encode()),
                  element(0x00880200, "SQ", item(element(0x00280010, "US", u16(4)) + element(0x7FE00010, "OB", word["around"]))),
                  element(0x60000010, "US", u16(16)), element(0x60000022, "LO", word["around"]),
                  element(0x60003000, "OW", word["around"]), element(0x60004000, "LT", word["around"]),
                  element(0x7FE00010, "OW", noise(number, 16, 16)), element(0xFFFCFFFC, "OB", word["around"])]
        parts.sort(key=lambda part: (part[1] << 24 | part[0] << 16 | part[3] << 8 | part[2]))
        meta = element(0x00020010, "UI", EXPLICIT) + element(0x00020016, "AE", word["around"]) + element(
            0x00020102, "OB", word["around"])
        return (word["around"] * 9).encode()[:128] + b"DICM" + meta + b"".join(parts)

    def upload(self, slices: int = 20) -> bytes:
        """Returns a tar as another client might send it: names of folders, files and owners, comments, and trailing data."""
        name, owner = self.words["names"].encode(), self.words["names"].encode()[:31]
        magic = b"ustar\x0000" + owner.ljust(32, b"\0") + owner.ljust(32, b"\0")
        comment = b" comment=" + name + b"\n"
        pax = b"%d" % (len(comment) + 2) + comment
        out = entry(pax, b"pax/" + name, b"x")
        for number in range(slices):
            data = self.file(number)
            out += tar_header(b"%s/%s%05d.dcm" % (name, name, number), len(data), magic=magic, rest=name) + padded(data)
        return out + TAR_END + padded(name)

    def metadata(self) -> dict[str, str]:
        """Returns what tus clients send about a file."""
        def coded(text: str) -> str:
            return base64.b64encode(text.encode()).decode()

        word = self.words["upload"]
        return {"Upload-Metadata": f"filename {coded(word + '.zip')},relativePath {coded('/disc/' + word)},name {coded(word)}",
                "Content-Disposition": f'attachment; filename="{word}"', "X-Forwarded-User": word}
