import { describe, expect, it } from "vitest";
import { de } from "../texts/de";
import { en } from "../texts/en/en";
import { correctionsOf, noteOf } from "./corrections";

describe("the corrections of a scan", () => {
  it("are recognised by ingest's sentences", () => {
    expect(correctionsOf(["straightened 18.5 degrees (gantry tilt)"])).toEqual(["tilt"]);
    expect(correctionsOf(["2 slices were missing and filled in from the neighbours"])).toEqual(["missing"]);
    expect(
      correctionsOf([
        "the distance from slice to slice varies from 1.08 to 7.00 mm; slices were computed every 4.00 mm, so small things may be blurred",
      ]),
    ).toEqual(["spacing"]);
    expect(correctionsOf(["slices lie up to 0.20 mm off their places; the mean distance was used"])).toEqual([
      "spacing",
    ]);
    expect(correctionsOf(["1 slice was there twice; one of each was kept"])).toEqual(["duplicates"]);
    expect(correctionsOf(["3 scout pictures were left out"])).toEqual(["overview"]);
    expect(correctionsOf(["4 slices of another size were left out"])).toEqual(["size"]);
    expect(correctionsOf(["1 file was damaged and left out"])).toEqual(["damaged"]);
    expect(correctionsOf(["each slice had a scale of its own; all were brought to one scale"])).toEqual(["brightness"]);
    expect(correctionsOf(["the negative was inverted"])).toEqual(["negative"]);
    expect(correctionsOf(["1 phase was incomplete and left out"])).toEqual(["phases"]);
    expect(
      correctionsOf(["3 slices at the ends of some phases were left out, because other phases do not have them"]),
    ).toEqual(["phases"]);
  });
  it("say which phases were left out", () => {
    expect(noteOf("2 phases were incomplete and left out")).toEqual({ kind: "incomplete", count: 2 });
    expect(noteOf("only 4 of 7 phases were kept, because all of them would be larger than allowed")).toEqual({
      kind: "fewer",
      kept: 4,
      of: 7,
    });
    expect(noteOf("1 slice at the ends of some phases was left out, because other phases do not have them")).toEqual({
      kind: "uncommon",
      count: 1,
    });
  });
  it("are listed once each, without unknown ones", () => {
    expect(correctionsOf(["1 file was damaged", "2 files were damaged", "something new"])).toEqual(["damaged"]);
  });
  it("form one sentence for a patient", () => {
    expect(en.scans.repaired(["tilt", "spacing"])).toBe(
      "We corrected this scan: it was tilted and its slices were unevenly spaced.",
    );
    expect(en.scans.repaired([])).toBe("We corrected this scan.");
    expect(de.scans.repaired(["tilt"])).toBe("Wir haben diese Aufnahme korrigiert, denn sie war schräg aufgenommen.");
  });
});

describe("the details of a correction", () => {
  /** Each sentence of ingest (classify.cpp, scan.cpp, build_volume.cpp), that of older scans, and the note. */
  const known: readonly (readonly [string, string, string])[] = [
    [
      "gantry tilt of 18.5 degrees corrected",
      "straightened 18.5 degrees (gantry tilt)",
      "Die Neigung des Geräts um 18,5° wurde ausgeglichen.",
    ],
    [
      "slice spacing varied from 1.08 to 7.00 mm and was resampled to 4.00 mm, so small details may be blurred",
      "the distance from slice to slice varies from 1.08 to 7.00 mm; slices were computed every 4.00 mm, so small things may be blurred",
      "Die Schichten lagen 1,08 bis 7,00 mm auseinander und wurden auf 4,00 mm umgerechnet. Kleine Einzelheiten können deshalb unscharf sein.",
    ],
    [
      "slice positions deviated by up to 0.20 mm; the mean spacing was used",
      "slices lie up to 0.20 mm off their places; the mean distance was used",
      "Die Lage der Schichten wich um bis zu 0,20 mm ab. Verwendet wurde der mittlere Abstand.",
    ],
    [
      "2 slices were missing and interpolated from the neighbouring slices",
      "2 slices were missing and filled in from the neighbours",
      "2 fehlende Schichten wurden aus den Nachbarschichten ergänzt.",
    ],
    [
      "1 slice was duplicated; one copy of each was kept",
      "1 slice was there twice; one of each was kept",
      "1 Schicht war doppelt vorhanden und wurde nur einmal übernommen.",
    ],
    ["3 overview images were skipped", "3 scout pictures were left out", "3 Übersichtsbilder wurden ausgelassen."],
    [
      "4 slices of a different size were skipped",
      "4 slices of another size were left out",
      "4 Schichten mit anderer Größe wurden ausgelassen.",
    ],
    [
      "1 file was damaged or unreadable and skipped",
      "1 file was damaged and left out",
      "1 beschädigte oder unlesbare Datei wurde ausgelassen.",
    ],
    [
      "the slices had different value scales and were converted to a single one",
      "each slice had a scale of its own; all were brought to one scale",
      "Die Schichten hatten verschiedene Werteskalen und wurden auf eine gemeinsame umgerechnet.",
    ],
    [
      "the inverted (negative) image was converted back",
      "the negative was inverted",
      "Das Negativ wurde in ein Positiv umgewandelt.",
    ],
    [
      "values above 32,767 Hounsfield units were clipped",
      "values above 32,767 were clipped",
      "Werte über 32.767 wurden abgeschnitten.",
    ],
    ["values were halved for storage", "values were halved for storage", "Die Werte wurden zum Speichern halbiert."],
  ];
  it.each(known)("are written in German for '%s' and its older form", (now, older, german) => {
    for (const sentence of [now, older]) {
      const note = noteOf(sentence);
      expect(note).not.toBeNull();
      if (note) expect(de.scans.repairNote(note)).toBe(german);
    }
  });
  it("keep their figures in English", () => {
    const note = noteOf(
      "slice spacing varied from 1.08 to 7.00 mm and was resampled to 4.00 mm, so small details may be blurred",
    );
    expect(note).toEqual({ kind: "spacing", fromMm: 1.08, toMm: 7, usedMm: 4 });
    if (note)
      expect(en.scans.repairNote(note)).toBe(
        "Slice spacing varied from 1.08 to 7.00 mm and was resampled to 4.00 mm, so small details may be blurred.",
      );
  });
  it("do not exist for any other sentence, which the page shows as it is", () => {
    expect(noteOf("something new")).toBeNull();
  });
});
