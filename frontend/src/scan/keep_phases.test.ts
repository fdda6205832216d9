import { describe, expect, it } from "vitest";
import { readNifti } from "./image/nifti";
import { hasChoice, keepPhases, keptPhases, sparserChoices } from "./keep_phases";
import { scanFiles } from "./scan";
import type { ScanResult, Series } from "./types";
import { partBlobs, sizesOf } from "./upload_plan";
import { bundleSize, makeBundle } from "./bundle";
import { makeSlice } from "./testing";

const scanned = (files: readonly File[]): Promise<ScanResult> =>
  scanFiles(
    files,
    () => undefined,
    () => false,
  );
const first = ({ series: [one] }: ScanResult): Series => one ?? expect.unreachable();

const size = [20, 18, 16] as const;
const count = size[0] * size[1] * size[2];
const times = 7;

/** A NIfTI file with seven moments, 40 ms apart. All voxels of a moment are its number. */
function moments(): File {
  const header = new Uint8Array(352);
  const view = new DataView(header.buffer);
  view.setInt32(0, 348, true);
  [4, ...size, times].forEach((one, i) => view.setInt16(40 + 2 * i, one, true));
  view.setInt16(70, 4, true);
  [1, 1, 1, 1, 0.04].forEach((one, i) => view.setFloat32(76 + 4 * i, one, true));
  view.setFloat32(108, 352, true);
  view.setUint8(123, 2 | 8);
  header.set(new TextEncoder().encode("n+1"), 344);
  const voxels = Int16Array.from({ length: count * times }, (_, i) => Math.floor(i / count));
  return new File([header, voxels], "heart.nii");
}

describe("the choice of phases of a research file", () => {
  it("sends only the chosen ones, in one file with their time", async () => {
    const file = moments();
    const series = first(await scanned([file]));
    expect(hasChoice(series)).toBe(true);
    for (const [choice, wanted, step] of [
      [{ every: 1 }, [0, 1, 2, 3, 4, 5, 6], 40],
      [{ every: 2 }, [0, 2, 4, 6], 80],
      [{ every: 5 }, [0, 5], 200],
      [{ only: 3 }, [3], 40],
    ] as const) {
      const { upload } = keepPhases(series, choice);
      const blobs = await partBlobs(upload, [file]);
      expect(blobs).toHaveLength(1);
      const bytes = new Uint8Array((await blobs[0]?.arrayBuffer()) ?? new ArrayBuffer());
      const header = readNifti(bytes);
      expect(header).toMatchObject({ size, volumes: wanted.length });
      if (wanted.length > 1) expect(header).toMatchObject({ stepMs: expect.closeTo(step, 3) as number });
      const sent = new Int16Array(bytes.slice(352).buffer);
      expect(sent).toHaveLength(count * wanted.length);
      expect([...new Set(sent)]).toEqual(wanted);
      expect(keptPhases(choice, times)).toBe(wanted.length);
      expect(bundleSize(sizesOf(upload))).toBe(makeBundle(blobs).size);
    }
  });

  it("makes another upload of the same files", async () => {
    const series = first(await scanned([moments()]));
    const marks = [{ every: 1 }, { every: 2 }, { only: 1 }, { only: 2 }].map(
      (one) => keepPhases(series, one).fingerprint,
    );
    expect(new Set(marks)).toHaveLength(4);
    expect(marks[0]).toBe(series.fingerprint);
  });
});

describe("the choice of phases of a DICOM series", () => {
  it("sends only the files of the chosen ones", async () => {
    const files = Array.from({ length: 6 * 20 }, (_, i) => {
      const k = (i * 7919) % 120; // in no order
      const made = makeSlice({ z: 2 * Math.floor(k / 6), instance: k, triggerTime: 80 * (k % 6) });
      return new File([made], String(i));
    });
    const series = first(await scanned(files));
    const all = await partBlobs(series.upload, files);
    const perPhase = series.slices;
    expect(all).toHaveLength(6 * perPhase);
    const kept = await partBlobs(keepPhases(series, { every: 3 }).upload, files);
    const bytes = (blobs: readonly Blob[]) =>
      Promise.all(blobs.map(async (one) => [...new Uint8Array(await one.arrayBuffer())].join()));
    expect(await bytes(kept)).toEqual(
      await bytes([...all.slice(0, perPhase), ...all.slice(3 * perPhase, 4 * perPhase)]),
    );
    const one = await partBlobs(keepPhases(series, { only: 5 }).upload, files);
    expect(await bytes(one)).toEqual(await bytes(all.slice(5 * perPhase)));
  });
});

it("offers distances that leave at least two phases", () => {
  expect(sparserChoices(2)).toEqual([]);
  expect(sparserChoices(3)).toEqual([2]);
  expect(sparserChoices(20)).toEqual([2, 3, 4, 5, 10]);
});
