import { describe, expect, it } from "vitest";
import { judge } from "./judge";
import { pieceOf } from "./piece";
import { HeaderReader } from "./read_file";
import { makeSeries, makeSlice, type MadeSlice } from "./testing";
import type { SliceHeader } from "./types";

async function headers(blobs: readonly Blob[]): Promise<SliceHeader[]> {
  const reads = await Promise.all(blobs.map((blob, i) => new HeaderReader().read(pieceOf(blob), i)));
  return reads.flatMap((read) => (read.kind === "headers" ? read.headers : []));
}

const judged = async (blobs: readonly Blob[]) => judge(await headers(blobs));
const series = (change: (i: number) => MadeSlice, count = 24, gap = 1.5) => makeSeries(count, gap, change);

async function refusal(blobs: readonly Blob[]) {
  const verdict = await judged(blobs);
  return verdict.suitable ? "suitable" : verdict.reason;
}

describe("the judgement of a series", () => {
  it("accepts a regular series and sorts it by position, not by name or number", async () => {
    const blobs = series((i) => ({ z: ((i * 7) % 24) * 1.5 - 10 }));
    const verdict = await judged(blobs);
    expect(verdict).toMatchObject({
      suitable: true,
      size: [8, 8, 24],
      leftOut: { scouts: 0, doubles: 0, damaged: 0, others: 0 },
    });
    if (!verdict.suitable) return;
    expect(verdict.slices.map(({ file }) => (file * 7) % 24)).toEqual([...Array(24).keys()]);
    expect(verdict.sizeMm[2]).toBeCloseTo(36, 9);
  });

  it("measures positions along the normal of an oblique series", async () => {
    const c = Math.SQRT1_2;
    const verdict = await judged(
      series((i) => ({ position: [0, -i * c, i * c], orientation: [1, 0, 0, 0, c, c] }), 30),
    );
    expect(verdict).toMatchObject({ suitable: true });
    if (verdict.suitable) expect(verdict.sizeMm[2]).toBeCloseTo(30, 6);
  });

  it("takes directions that were rounded for one, and wider turns for several", async () => {
    const turned = (angle: number) => series((i) => ({ orientation: [1, 0, 0, 0, 1, i % 2 ? angle : 0] }), 48);
    expect(await refusal(turned(0.0035))).toBe("suitable");
    expect(await refusal(turned(0.0045))).toBe("mixed");
  });

  it("allows a jitter of two per cent, and announces resampling for more", async () => {
    expect(await refusal(series((i) => ({ z: i * 1.5 + (i % 2) * 0.014 })))).toBe("suitable");
    expect(await judged(series((i) => ({ z: i * 1.5 + (i % 2) * 0.2 })))).toMatchObject({
      suitable: true,
      repairs: [{ kind: "varying" }],
    });
    expect(await refusal(series((i) => ({ z: i < 12 ? i : 12 + (i - 12) * 9 })))).toBe("varying_spacing");
  });

  it("keeps one of two equal objects and skips an overview image in a good series", async () => {
    const blobs = [
      ...series((i) => ({ sopUid: `9.${i}` })),
      new Blob([makeSlice({ z: 3, sopUid: "9.2" })]),
      new Blob([makeSlice({ z: 3, imageType: "ORIGINAL\\PRIMARY\\LOCALIZER", orientation: [0, 1, 0, 0, 0, -1] })]),
    ];
    expect(await judged(blobs)).toMatchObject({
      suitable: true,
      size: [8, 8, 24],
      leftOut: { doubles: 1, scouts: 1 },
    });
  });

  it("skips a truncated slice at the end, and fills it in in the middle", async () => {
    const cut = (at: number) => series(() => ({})).map((blob, i) => (i === at ? blob.slice(0, blob.size - 40) : blob));
    expect(await judged(cut(23))).toMatchObject({ suitable: true, size: [8, 8, 23], leftOut: { damaged: 1 } });
    const filled = {
      suitable: true,
      size: [8, 8, 24],
      repairs: [{ kind: "filled_in", slices: 1 }],
      leftOut: { damaged: 1 },
    };
    expect(await judged(cut(11))).toMatchObject(filled);
  });

  it("shows a series although one file ends within its header and states no encoding", async () => {
    const blobs = series(() => ({})).map((blob, i) => (i === 23 ? blob.slice(0, blob.size - 160) : blob));
    expect(await judged(blobs)).toMatchObject({ suitable: true, size: [8, 8, 23], leftOut: { damaged: 1 } });
  });

  it("keeps the size that most slices have", async () => {
    const found = { suitable: true, size: [8, 8, 21], leftOut: { others: 3 } };
    expect(await judged(series((i) => (i > 20 ? { rows: 4 } : {})))).toMatchObject(found);
    expect(await judged(series((i) => (i > 20 ? { spacing: [1, 1] } : {})))).toMatchObject(found);
  });

  it("announces by how much a tilted series will be straightened", async () => {
    const verdict = await judged(
      series((i) => ({ position: [0, i * 1.5 * Math.tan((18.5 * Math.PI) / 180), i * 1.5] })),
    );
    expect(verdict).toMatchObject({ suitable: true, repairs: [{ kind: "straightened" }] });
    if (verdict.suitable && verdict.repairs[0]?.kind === "straightened")
      expect(verdict.repairs[0].degrees).toBeCloseTo(18.5, 6);
  });

  it("refuses a file or a scan above the server's limits before anything is sent", async () => {
    const found = await headers(series(() => ({})));
    const reason = (change: Partial<SliceHeader>) => {
      const verdict = judge(found.map((slice) => ({ ...slice, ...change })));
      return verdict.suitable ? "suitable" : verdict.reason;
    };
    const sent = (bytes: number) => reason({ voxels: { from: 1000, to: 1000 + bytes, vr: "OW", encapsulated: false } });
    expect([sent(980e6), sent(2 ** 30), sent(2 ** 30 + 1)]).toEqual(["suitable", "suitable", "too_large"]);
    // 24 slices of one file; then of one each
    const sized = (rows: number, oneFile: boolean) =>
      reason({ rows, columns: 4096, bitsAllocated: 16, ...(oneFile ? { file: 0 } : {}) });
    expect([sized(4096, true), sized(6000, true)]).toEqual(["suitable", "too_large"]);
    expect([sized(6000, false), sized(12000, false)]).toEqual(["suitable", "too_large"]);
  });

  it("refuses an implausible scale", async () => {
    const found = await headers(series(() => ({})));
    const reason = (change: Partial<SliceHeader>) => {
      const verdict = judge(found.map((slice) => ({ ...slice, ...change })));
      return verdict.suitable ? "suitable" : verdict.reason;
    };
    expect([0, 1e38, -1e38, 1e-300, 1].map((slope) => reason({ slope }))).toEqual([
      ...Array<string>(4).fill("bad_rescale"),
      "suitable",
    ]);
    expect(reason({ intercept: 1e30 })).toBe("bad_rescale");
  });

  it.each<[string, Blob[]]>([
    ["too_few_slices", series(() => ({}), 3)],
    ["too_short", series(() => ({}), 24, 0.5)],
    ["scout", series(() => ({ imageType: "ORIGINAL\\PRIMARY\\LOCALIZER" }), 2)],
    ["views_not_slices", series(() => ({ imageType: "DERIVED\\SECONDARY\\PROJECTION IMAGE" }))],
    ["not_original", series(() => ({ imageType: "DERIVED\\SECONDARY\\MPR" }))],
    ["screenshots", series(() => ({ photometric: "RGB", samples: 3, pixels: new Uint8Array(384) }))],
    ["no_slices", series(() => ({ sopClass: "1.2.840.10008.5.1.4.1.1.7" }))],
    ["no_slices", series(() => ({ sopClass: "1.2.840.10008.5.1.4.1.1.88.22" }), 1)],
    ["no_position", series(() => ({ sopClass: "1.2.840.10008.5.1.4.1.1.2.1", frames: 40 }), 1)],
    ["no_position", series(() => ({ position: null }))],
    ["no_position", series(() => ({ orientation: null }))],
    ["one_position", series(() => ({ z: 5 }))],
    ["too_few_slices", series((i) => ({ z: (i % 12) * 2 }))],
    ["repeated_position", series((i) => ({ z: Math.min(i, 20) * 2 }))],
    ["no_spacing", series(() => ({ spacing: [1e-30, 1e30] }))],
    ["mixed", series((i) => (i % 2 ? { rows: 4 } : {}))],
    ["mixed", series((i) => (i > 18 ? { orientation: [0, 1, 0, 0, 0, -1] } : {}))],
    ["mixed", series((i) => (i % 2 ? { spacing: [1, 1] } : {}))],
    ["missing_slices", series((i) => ({ z: (i < 12 ? i : i + 2) * 1.5 }))],
    ["tilted", series((i) => ({ position: [0, i * 2, i * 1.5] }))],
    ["unsupported_compression", series(() => ({ syntax: "1.2.840.10008.1.2.4.102" }))],
    ["damaged", series(() => ({})).map((blob) => blob.slice(0, blob.size - 2))],
  ])("refuses with %s", async (reason, blobs) => {
    expect(await refusal(blobs)).toBe(reason);
  });
});
