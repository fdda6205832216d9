import { describe, expect, it } from "vitest";
import { canonicalHeader } from "./image/canonical";
import { readNifti } from "./image/nifti";
import type { ImageHeader } from "./image/header";
import { disguisedUid } from "./disguised_uid";
import { cleanLabelFile, LabelFileError } from "./label_file";

const canary = "Jane Canary";
const text = (value: string) => new TextEncoder().encode(value);

async function unpacked(blob: Blob): Promise<Uint8Array<ArrayBuffer>> {
  return new Uint8Array(await new Response(blob.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
}

function nifti(): Uint8Array<ArrayBuffer> {
  const bytes = canonicalHeader({
    size: [4, 3, 2],
    volumes: 1,
    run: 24,
    stepMs: null,
    values: 1,
    type: "uint8",
    littleEndian: true,
    axes: [
      [1, 0, 0],
      [0, 2, 0],
      [0, 0, 3],
    ],
    origin: [-10, 20, 30],
    spacing: [1, 2, 3],
    slope: 1,
    intercept: 0,
    modality: "",
    coding: "raw",
    begin: 352,
    storedBytes: null,
  });
  bytes.set(text(canary), 148); // descrip
  return bytes;
}

function element(tag: number, value: Uint8Array): Uint8Array {
  const even = value.length + (value.length % 2);
  const bytes = new Uint8Array(8 + even);
  const view = new DataView(bytes.buffer);
  view.setUint16(0, tag >>> 16, true);
  view.setUint16(2, tag & 0xffff, true);
  view.setUint32(4, even, true);
  bytes.set(value, 8);
  return bytes;
}

const joined = (...parts: readonly Uint8Array[]) => Uint8Array.from(parts.flatMap((part) => [...part]));
const item = (...parts: readonly Uint8Array[]) => element(0xfffee000, joined(...parts));

/** A structure set in implicit little endian, with names of the patient at several depths. */
function structureSet(): Uint8Array<ArrayBuffer> {
  const explicit = (tag: number, uid: string) => {
    const bytes = element(0x00020000 | tag, text(uid));
    bytes.set(text("UI"), 4);
    new DataView(bytes.buffer).setUint16(6, bytes.length - 8, true);
    return bytes;
  };
  return joined(
    new Uint8Array(128),
    text("DICM"),
    explicit(0x0002, "1.2.840.10008.5.1.4.1.1.481.3"),
    explicit(0x0010, "1.2.840.10008.1.2"),
    element(0x00080016, text("1.2.840.10008.5.1.4.1.1.481.3")),
    element(0x00100010, text(canary)),
    element(0x30060010, item(element(0x00200052, text("1.2.3")))),
    element(
      0x30060020,
      item(
        element(0x30060022, text("7 ")),
        element(0x30060024, text("1.2.3")),
        element(0x30060026, text("Liver ")),
        element(0x30060028, text(canary)),
      ),
    ),
    element(0x300600b0, text(canary)),
  );
}

describe("a file of labels", () => {
  it("is sent with its voxels and its place, and without the texts of its header", async () => {
    const voxels = Uint8Array.from({ length: 24 }, (_, i) => i % 3);
    const sent = await unpacked(await cleanLabelFile(new Blob([nifti(), voxels])));
    expect(new TextDecoder("latin1").decode(sent)).not.toContain(canary);
    const header = readNifti(sent) as ImageHeader;
    expect(header).toMatchObject({ size: [4, 3, 2], type: "uint8", origin: [-10, 20, 30] });
    expect(sent.subarray(352)).toEqual(voxels);
  });

  it("is sent with the names of its structures, and without those of the patient", async () => {
    const sent = new TextDecoder("latin1").decode(await unpacked(await cleanLabelFile(new Blob([structureSet()]))));
    expect(sent).not.toContain(canary);
    expect(sent).toContain("Liver");
    expect(sent).not.toContain("1.2.3\0");
    expect(sent.split(disguisedUid("1.2.3"))).toHaveLength(3);
  });

  it("is refused here if it is another kind of file, or cut off", async () => {
    await expect(cleanLabelFile(new Blob(["hello"]))).rejects.toMatchObject({ fault: "unknown" });
    await expect(cleanLabelFile(new Blob([nifti(), new Uint8Array(3)]))).rejects.toMatchObject({ fault: "damaged" });
    const packed = new Blob([nifti(), new Uint8Array(24)]).stream().pipeThrough(new CompressionStream("gzip"));
    const whole = await new Response(packed).blob();
    await expect(cleanLabelFile(whole.slice(0, whole.size - 20))).rejects.toBeInstanceOf(LabelFileError);
    expect(await unpacked(await cleanLabelFile(whole))).toHaveLength(352 + 24);
  });
});

describe("the UID of a frame of reference", () => {
  it("is replaced by a number that ingest computes in the same way", () => {
    // As in volume/frame_of_reference_test.cpp.
    expect(disguisedUid("1.2.3")).toBe("2.25.261189956532771003411213951354307305753");
    expect(disguisedUid(disguisedUid("1.2.3"))).toBe(disguisedUid("1.2.3"));
    expect(disguisedUid("")).toBe("");
  });
});
