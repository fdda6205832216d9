import { deflateRawSync } from "node:zlib";
import { describe, expect, it } from "vitest";
import { pieceOf } from "./piece";
import { HeaderReader } from "./read_file";
import { scanFiles } from "./scan";
import { concat, makeSeries, makeSlice } from "./testing";

const scan = (files: readonly Blob[]) =>
  scanFiles(
    files,
    () => undefined,
    () => false,
  );
const header = async (blob: Blob) => {
  const read = await new HeaderReader().read(pieceOf(blob), 0);
  return read.kind === "headers" ? (read.headers[0] ?? "nothing") : read.kind;
};

describe("reading a header", () => {
  it("decodes the patient's name in its own character set, for display only", async () => {
    expect(await header(new Blob([makeSlice()]))).toMatchObject({ patient: { name: "Müller Änne", id: "4711" } });
  });

  it("supports implicit encoding, a missing preamble and a missing meta header", async () => {
    const want = { seriesUid: "1.2.5", rows: 8, columns: 8, truncated: false };
    expect(await header(new Blob([makeSlice({ syntax: "1.2.840.10008.1.2" })]))).toMatchObject(want);
    expect(await header(new Blob([makeSlice({ preamble: "none" })]))).toMatchObject(want);
    expect(await header(new Blob([makeSlice({ preamble: "nothing" })]))).toMatchObject(want);
    expect(await header(new Blob([makeSlice({ preamble: "nothing", syntax: "1.2.840.10008.1.2" })]))).toMatchObject(
      want,
    );
  });

  it("finds the voxels, whatever precedes them", async () => {
    for (const made of [
      {},
      { preamble: "none" as const },
      { preamble: "nothing" as const },
      { paddingBytes: 30_000 },
    ]) {
      const pixels = Uint8Array.from({ length: 128 }, (_, i) => i);
      const blob = new Blob([makeSlice({ ...made, pixels })]);
      const found = await header(blob);
      if (typeof found === "string" || !found.pixels) throw new Error("no voxels found");
      const { offset, length } = found.pixels;
      expect(new Uint8Array(await blob.slice(offset, offset + length).arrayBuffer())).toEqual(pixels);
    }
  });

  it("reads more than 8 KB only for a longer header, and the same length of the next file", async () => {
    const reader = new HeaderReader();
    const reads = async (paddingBytes: number) => {
      const sizes: number[] = [];
      const blob = new Blob([makeSlice({ paddingBytes }), new Uint8Array(1_000_000)]);
      const slice = blob.slice.bind(blob);
      blob.slice = (from?: number, to?: number) => {
        sizes.push(((to ?? 0) - (from ?? 0)) / 1024);
        return slice(from, to);
      };
      expect(await reader.read(pieceOf(blob), 0)).toMatchObject({ headers: [{ rows: 8 }] });
      return sizes.map(Math.floor);
    };
    expect(await reads(10)).toEqual([8]);
    expect(await reads(30_000)).toEqual([8, 64]);
    expect(await reads(30_000)).toEqual([64]);
    expect(await reads(100_000)).toEqual([64, 256]);
    expect(await reads(400_000)).toEqual([256, 1367]);
    expect(await reads(10)).toEqual([256]);
    expect(await reads(10)).toEqual([8]);
  });

  /** A deflated file of so many frames of 2,000 × 2,000 points, of which every `step`th byte is noise. */
  const deflated = (frames: number, step: number) => {
    const plain = makeSlice({ syntax: "1.2.840.10008.1.2.1.99" });
    const at = plain.length - makeSlice({ preamble: "nothing" }).length;
    const pixels = new Uint8Array(frames * 8_000_000);
    for (let i = 0; i < pixels.length; i += step) pixels[i] = (i * 2_654_435_761) >>> 24;
    const body = makeSlice({ preamble: "nothing", pixels, frames, rows: 2000, columns: 2000 });
    return new Blob([concat([plain.subarray(0, at), deflateRawSync(body, { level: 1 })])]);
  };

  it("inflates a deflated file completely, also a large one", async () => {
    const small = deflated(1, 8_000_000);
    expect(small.size).toBeLessThan(100_000);
    expect(await header(small)).toMatchObject({
      rows: 2000,
      transferSyntax: "1.2.840.10008.1.2.1",
      truncated: false,
    });
    expect(await header(deflated(3, 8))).toMatchObject({ frames: 3, truncated: false });
  });

  it("does not read a deflated file that expands too far, instead of cutting it off", async () => {
    expect(await header(deflated(3, 24_000_000))).toBe("unreadable");
  });

  it("recognises other files", async () => {
    expect(await header(new Blob(["%PDF-1.7 and so on, long enough to look at"]))).toBe("not_dicom");
    expect(await header(new Blob([]))).toBe("not_dicom");
    expect(await header(new Blob([new Uint8Array([8, 0, 255, 255, 3, 4]), new Uint8Array(400)]))).toBe("not_dicom");
    expect(await header(new Blob([makeSlice().slice(0, 180)]))).toBe("unreadable");
    expect(await header(new Blob([new Uint8Array(128), "DICM", new Uint8Array(64).fill(255)]))).toBe("unreadable");
  });
});

describe("scanning a folder", () => {
  it("never stops at a bad file, but counts it", async () => {
    const broken = new Blob(["x"]);
    broken.slice = () => {
      throw new Error("the disc was taken out");
    };
    const files = [new Blob(["readme"]), ...makeSeries(20, 1.5), broken, new Blob([makeSlice().slice(0, 180)])];
    const progress: number[] = [];
    const result = await scanFiles(
      files,
      (done) => progress.push(done),
      () => false,
    );
    expect(result).toMatchObject({ notDicom: 1, unreadable: 2, files: 23 });
    expect(result.series).toHaveLength(1);
    expect(progress).toEqual(Array.from({ length: 23 }, (_, i) => i + 1));
  });

  it("ignores the directory of a disc, which is neither a slice nor damaged", async () => {
    const directory = new Blob([makeSlice({ sopClass: "1.2.840.10008.1.3.10", seriesUid: "" })]);
    const found = await scanFiles(
      [...makeSeries(20, 2), directory],
      () => undefined,
      () => false,
    );
    expect(found).toMatchObject({ unreadable: 0, notDicom: 0, notSlices: 0 });
    expect(found.series).toHaveLength(1);
  });

  it("separates two patients, even with the same series number", async () => {
    const result = await scan([...makeSeries(20, 1.5), ...makeSeries(18, 1.5, () => ({ patientId: "4712" }))]);
    expect(result.series.map((series) => [series.patient.id, series.slices])).toEqual([
      ["4711", 20],
      ["4712", 18],
    ]);
  });

  it("lists suitable series first and ignores a DICOMDIR", async () => {
    const result = await scan([
      new Blob([makeSlice({ sopClass: "1.2.840.10008.1.3.10" })]),
      ...makeSeries(40, 1, () => ({ seriesUid: "1.9", imageType: "ORIGINAL\\PRIMARY\\LOCALIZER" })),
      ...makeSeries(20, 1.5),
    ]);
    expect(result.series.map((series) => series.verdict.suitable)).toEqual([true, false]);
    expect(result.notSlices).toBe(0);
  });

  it("draws the middle slice under its window with its physical proportions", async () => {
    const pixels = new Uint8Array(new Int16Array(64).fill(1024 + 40).buffer); // 40 HU: the centre of the window
    const result = await scan(
      makeSeries(21, 1.5, (i) => ({ pixels: i === 10 ? pixels : new Uint8Array(128), spacing: [1, 0.5] })),
    );
    const thumbnail = result.series[0]?.thumbnail;
    expect(thumbnail).toMatchObject({ width: 80, height: 160 });
    expect([...new Set(thumbnail?.gray)]).toEqual([127]);
  });

  it("draws a CT of MONOCHROME1 like any other, and shows another negative as a positive", async () => {
    const stored = new Uint8Array(new Uint16Array(64).fill(2064).buffer); // 1040 HU: white
    const grayOf = async (modality: string, photometric: string) => {
      const result = await scan(makeSeries(20, 1.5, () => ({ pixels: stored, modality, photometric })));
      return result.series[0]?.thumbnail?.gray[0];
    };
    expect(await grayOf("CT", "MONOCHROME1")).toBe(await grayOf("CT", "MONOCHROME2"));
    expect(await grayOf("CT", "MONOCHROME1")).toBe(255);
    expect(await grayOf("MR", "MONOCHROME1")).toBe(0);
  });

  it("ignores the bits above the stored ones, signed or not", async () => {
    const stored = new Uint8Array(new Uint16Array(64).fill(0xf000 | 2064).buffer); // 2064 - 1024: white; as 16 bits: far out
    for (const isSigned of [true, false]) {
      const result = await scan(makeSeries(20, 1.5, () => ({ pixels: stored, bitsStored: 12, isSigned })));
      expect(result.series[0]?.thumbnail?.gray[0]).toBe(isSigned ? 0 : 255); // 12 bits signed: -2032
    }
  });

  it("gives the same files the same fingerprint, and different ones another", async () => {
    const uid = (i: number) => ({ sopUid: `7.${i}` });
    const prints = await Promise.all(
      [makeSeries(20, 1.5, uid), makeSeries(20, 1.5, uid).reverse(), makeSeries(21, 1.5, uid)].map(
        async (files) => (await scan(files)).series[0]?.fingerprint,
      ),
    );
    expect(prints[0]).toBe(prints[1]);
    expect(prints[2]).not.toBe(prints[0]);
    expect(prints[0]).toMatch(/^[0-9a-f]{16}$/);
  });

  it("reads three thousand headers", async () => {
    const bytes = makeSlice({ pixels: new Uint8Array(2 * 256 * 256), rows: 256, columns: 256 });
    const files = Array.from({ length: 3000 }, () => new Blob([bytes]));
    expect((await scan(files)).series[0]?.slices).toBe(3000);
  }, 60_000);
});
